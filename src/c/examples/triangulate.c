/* Triangulates a grid of points, locates queries in it and interpolates a function.
 *
 * Build with: cc triangulate.c $(pkg-config --cflags --libs septet) */
#include <septet.h>
#include <stdio.h>
#include <stdlib.h>

/* Ends the program if a call failed. */
static void check(septet_status status) {
    if (status != SEPTET_OK) {
        fprintf(stderr, "septet: %s (status %d, point %lld)\n", septet_last_error(), (int)status,
                (long long)septet_last_index());
        exit(1);
    }
}

int main(void) {
    enum { SIDE = 5, POINTS = SIDE * SIDE * SIDE };
    static double points[3 * POINTS], values[POINTS];
    for (int i = 0; i < POINTS; i++) {
        points[3 * i] = i % SIDE;
        points[3 * i + 1] = i / SIDE % SIDE;
        points[3 * i + 2] = i / SIDE / SIDE;
        values[i] = points[3 * i] + 10 * points[3 * i + 1] + 100 * points[3 * i + 2];
    }

    septet_options options;
    septet_options_init(&options);
    options.threads = 2;
    septet_triangulation *t = NULL;
    check(septet_triangulate(points, POINTS, 3, &options, &t));
    size_t cells = septet_cells_count(t);
    printf("ABI %u, dimension %u, rank %d\n", (unsigned)septet_abi(), (unsigned)septet_dimension(t), (int)septet_rank(t));
    printf("%zu points, %zu facets on the hull\n", septet_points_count(t), septet_hull_count(t));

    int32_t *vertices = malloc(cells * 4 * sizeof *vertices);
    if (vertices == NULL) {
        return 1;
    }
    check(septet_cells_i32(t, vertices));
    printf("first cell: %d %d %d %d\n", (int)vertices[0], (int)vertices[1], (int)vertices[2], (int)vertices[3]);
    free(vertices);

    const double queries[] = {1.5, 2.25, 3.0, 4.0, 4.0, 4.0, 9.0, 0.0, 0.0};
    int64_t found[3], nearest[3];
    double value[3];
    check(septet_locate(t, queries, 3, 1, found));
    check(septet_nearest(t, queries, 3, 1, nearest));
    check(septet_interpolate(t, values, 1, queries, 3, SEPTET_LINEAR, -1.0, 1, value));
    for (int i = 0; i < 3; i++) {
        printf("%s, nearest %lld, value %g\n", found[i] < 0 ? "outside" : "inside", (long long)nearest[i], value[i]);
    }
    septet_free(t);

    double bad[] = {0.0, 0.0, 1.0, 0.0 / (queries[1] - 2.25)};
    septet_status status = septet_triangulate(bad, 2, 2, NULL, &t);
    printf("status %d at point %lld\n", (int)status, (long long)septet_last_index());
    return 0;
}
