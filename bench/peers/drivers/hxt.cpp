// HXT, the parallel Delaunay kernel of Gmsh (Marot, Pellerin and Remacle 2019), from Gmsh's source package.
#include <hxt_omp.h>
#include <hxt_tetDelaunay.h>
#include <hxt_tools.h>

#include "driver.hpp"

void must(HXTStatus status) {
    if (status != HXT_STATUS_OK) driver::fail("HXT failed");
}

int main(int argc, char** argv) {
    auto task = driver::task(argc, argv);
    const auto& points = task.points;
    if (points.dimension != 3) driver::fail("HXT: space only");
    omp_set_num_threads(task.threads);
    HXTMesh* mesh;
    must(hxtMeshCreate(&mesh));
    must(hxtAlignedMalloc(&mesh->vertices.coord, points.size() * 4 * sizeof(double)));
    for (std::size_t i = 0; i < points.size(); ++i) {
        std::copy_n(points[i], 3, &mesh->vertices.coord[4 * i]);
        mesh->vertices.coord[4 * i + 3] = 0;
    }
    mesh->vertices.num = mesh->vertices.size = static_cast<std::uint32_t>(points.size());
    HXTDelaunayOptions options{};
    options.perfectDelaunay = 1;
    options.delaunayThreads = task.threads;
    auto measured = driver::measure([&] { must(hxtDelaunay(mesh, &options)); });
    driver::Cells<4> cells;
    for (std::uint64_t c = 0; c < mesh->tetrahedra.num; ++c) {
        const std::uint32_t* node = &mesh->tetrahedra.node[4 * c];
        if (node[3] == HXT_GHOST_VERTEX) continue;
        std::array<std::uint64_t, 4> corners;
        for (std::size_t i = 0; i < 4; ++i) {
            const double* p = &mesh->vertices.coord[4 * std::size_t{node[i]}];
            corners[i] = driver::corner(3, [&](std::size_t axis) { return p[axis]; });
        }
        cells.add(corners);
    }
    driver::answer(measured, cells, VERSION);
}
