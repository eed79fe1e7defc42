/* septet: exact Delaunay triangulation of points in the plane and in space. The C interface.
 *
 * Rules for all functions:
 * - A function that can fail returns a septet_status. It writes its outputs only if it returns SEPTET_OK.
 * - After a failure, septet_last_error() of the same thread describes it. The text is valid until the next call of this thread.
 * - NULL for a required pointer is SEPTET_OPTION. An array without entries may be NULL. A function that returns a number and no
 *   status returns 0 for NULL.
 * - The library never prints, exits, aborts or unwinds into its caller.
 * - A septet_triangulation is immutable: threads may share it. Only septet_free must have no concurrent call.
 * - Arrays are row by row. Indices are 0-based, -1 means none. No call keeps a pointer of its caller.
 * - Results do not depend on the number of threads.
 * - A later version may add functions, and fields at the end of septet_options. It changes SEPTET_ABI if it changes anything else.
 *
 * Points have 2 or 3 coordinates. 4 to 6 coordinates are not in this interface; the program `septet triangulate` has them. */
#ifndef SEPTET_H
#define SEPTET_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define SEPTET_ABI 1

/* The values are the exit codes of the program. */
typedef int32_t septet_status;
#define SEPTET_OK 0
#define SEPTET_FAILED 1      /* an internal error; please report it */
#define SEPTET_OPTION 2      /* an argument is not valid */
#define SEPTET_POINTS 3      /* a point is not finite, its digits spread too far, or it lies outside of the box
                              * or of the periodic box: septet_last_index() names it. Or the points do not span the space, so
                              * nothing has cells. */
#define SEPTET_REFUTED 4     /* the certificate was refused; please report it */
#define SEPTET_LIMIT 5       /* max_memory, or an index does not fit its type */
#define SEPTET_MACHINE 6     /* a worker failed */
#define SEPTET_CANCELLED 130

/* The version of the library, such as "0.1.0", and of its ABI: compare the latter with SEPTET_ABI. */
const char *septet_version(void);
uint32_t septet_abi(void);

/* The last failure of this thread: its text in UTF-8 (never NULL), and the row of the point that caused it, or -1. */
const char *septet_last_error(void);
int64_t septet_last_index(void);

/* Options of septet_triangulate. In C and C++, septet_options_init(&options) sets all of them to their defaults. Other languages
 * call septet_options_init_sized with the size of their structure. */
typedef struct septet_options {
    size_t size;            /* sizeof(septet_options): set by septet_options_init. Fields beyond it have their defaults. */
    uint32_t threads;       /* 0: all cores; 1: the call computes on the thread of its caller; at most 4096 */
    uint32_t skip_invalid;  /* 1: points that are not finite are dropped, so they have no cells; 0: they are an error */
    uint64_t seed;          /* of the random draws; results do not depend on it */
    uint64_t max_memory;    /* bytes; 0: no limit */
    const int32_t *cancel;  /* another thread stores a non-zero value to end the call within a second; NULL: never.
                             * Another thread of the library reads it atomically during the call. */
    const double *weights;  /* a weight for each point, which is a squared length, so r * r for a ball of radius r; NULL: none.
                             * The triangulation is then the regular one, and some points may be hidden. */
    const double *period;   /* the length of a periodic box along each axis, 0 along an axis that is not periodic; NULL: no box.
                             * Cells are then one of each class of translated cells. */
    const double *origin;   /* the lower corner of the periodic box, one number for each axis; NULL: 0 */
    uint32_t wrap;          /* 1: points outside of the periodic box stand for their images in it; 0: they are an error */
    uint32_t reserved;      /* must be 0 */
} septet_options;

/* WARNING: pass the size of your own structure, sizeof(septet_options) of the header that the program was built with. A smaller size leaves
 * the fields beyond it unset and unused; a larger one writes beyond the structure. */
void septet_options_init_sized(septet_options *options, size_t size);

/* WARNING: the exported function septet_options_init sets only the fields up to cancel, and size to them, so that weights, period, origin
 * and wrap are not read. In C and C++, the macro below replaces it and sets all fields. Programs in other languages, and calls through a
 * pointer to the function, must use septet_options_init_sized. */
void septet_options_init(septet_options *options);
#define septet_options_init(options) septet_options_init_sized((options), sizeof(septet_options))

typedef struct septet_triangulation septet_triangulation;

/* Triangulates n points of dimension 2 or 3. options may be NULL. points may be NULL if n is 0. Points that coincide count
 * once. Points that do not span the space are no error: they have no cells, and their rank is less than the dimension. */
septet_status septet_triangulate(const double *points, size_t n, uint32_t dimension, const septet_options *options,
                                 septet_triangulation **out);
void septet_free(septet_triangulation *t); /* NULL is allowed */

uint32_t septet_dimension(const septet_triangulation *t);  /* 2 or 3 */
int32_t septet_rank(const septet_triangulation *t);        /* dimension of the affine hull of the points, from -1 */
size_t septet_points_count(const septet_triangulation *t);
size_t septet_cells_count(const septet_triangulation *t);
size_t septet_hull_count(const septet_triangulation *t);
size_t septet_duplicates_count(const septet_triangulation *t);

/* Copies into arrays of the caller: cells_count * (dimension + 1) entries, positively oriented, in canonical order, and the cell
 * across the facet opposite each vertex. The _i32 forms return SEPTET_LIMIT if an index does not fit. */
septet_status septet_cells_i32(const septet_triangulation *t, int32_t *out);
septet_status septet_cells_i64(const septet_triangulation *t, int64_t *out);
septet_status septet_neighbors_i32(const septet_triangulation *t, int32_t *out);
septet_status septet_neighbors_i64(const septet_triangulation *t, int64_t *out);

/* hull_count * dimension entries, outward; points_count entries; duplicates_count * 2 entries: point, and the first point at its place,
 * which is the vertex. With weights, it is the first of the heaviest points at its place, and not a vertex if others hide it. */
septet_status septet_hull(const septet_triangulation *t, int64_t *out);
septet_status septet_vertex_to_cell(const septet_triangulation *t, int64_t *out);
septet_status septet_duplicates(const septet_triangulation *t, int64_t *out);

/* Points that weights hide: hidden_count entries, ascending. They are not vertices. None without weights. */
size_t septet_hidden_count(const septet_triangulation *t);
septet_status septet_hidden(const septet_triangulation *t, int64_t *out);

/* In a periodic box: cells_count * (dimension + 1) * dimension whole numbers of lengths. Each vertex of a cell lies at its point plus
 * these numbers times the lengths. SEPTET_OPTION without a box. */
septet_status septet_offsets(const septet_triangulation *t, int32_t *out);

/* 1 if the cells are a simplicial complex; 0 if a point of a periodic box is joined to its own image or twice to another point. The
 * smallest numbers of boxes along each axis whose triangulation is one: dimension entries, SEPTET_OPTION without a box. */
int32_t septet_is_simplicial(const septet_triangulation *t);
septet_status septet_sheets(const septet_triangulation *t, uint32_t *out);

/* The queries below are those of a Delaunay triangulation. With weights, septet_locate, septet_hull, septet_voronoi_volumes in a box, and
 * septet_interpolate with SEPTET_LINEAR have answers. In a periodic box, septet_voronoi_volumes has. The others are SEPTET_OPTION, and
 * septet_hull_count is 0 in a periodic box. */

/* Queries: n points of the dimension of t; n results. threads as in septet_options. septet_locate finds the smallest cell that
 * contains each query, -1 outside of the hull; septet_nearest finds the nearest vertex. Both are exact. A query that is not finite
 * has the result -1. */
septet_status septet_locate(const septet_triangulation *t, const double *x, size_t n, uint32_t threads, int64_t *out);
septet_status septet_nearest(const septet_triangulation *t, const double *x, size_t n, uint32_t threads, int64_t *out);

/* Interpolates columns values a point: values has points_count * columns entries, out n * columns. Queries outside of the hull have
 * the value outside, which may be NaN. */
#define SEPTET_LINEAR 0
#define SEPTET_SIBSON 1
#define SEPTET_LAPLACE 2
septet_status septet_interpolate(const septet_triangulation *t, const double *values, size_t columns, const double *x, size_t n,
                                 int32_t method, double outside, uint32_t threads, double *out);

/* Volumes of the Voronoi cells in the box from low to high (dimension numbers each), or unbounded if both are NULL:
 * points_count entries. Unbounded cells are infinite; points that are no vertices have 0. With weights: power cells, which need
 * a box. In a periodic box: low and high are NULL, unless an axis is not periodic; the volumes add up to the periodic box. */
septet_status septet_voronoi_volumes(const septet_triangulation *t, const double *low, const double *high, uint32_t threads,
                                     double *out);

/* Squared radii from which on the cells belong to the alpha complex: cells_count entries. */
septet_status septet_alpha(const septet_triangulation *t, double *out);

#ifdef __cplusplus
}
#endif
#endif
