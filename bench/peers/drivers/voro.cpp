// Voro++: all Voronoi cells with their neighbours, cut by the bounding box. There are no tetrahedra to compare; the
// driver reports the number of cells.
#include <voro++.hh>

#include <cmath>

#include "driver.hpp"

// Points for each block of Voro++'s grid, as Voro++ recommends.
constexpr double PER_BLOCK = 5.6;

int main(int argc, char** argv) {
    auto task = driver::task(argc, argv);
    const auto& points = task.points;
    if (points.dimension != 3 || task.threads != 1) driver::fail("Voro++: space and one thread only");
    double low[3], high[3], volume = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = high[axis] = points[0][axis];
        for (std::size_t i = 0; i < points.size(); ++i) {
            low[axis] = std::min(low[axis], points[i][axis]);
            high[axis] = std::max(high[axis], points[i][axis]);
        }
        // Points on a face of the box would be outside of it.
        double margin = 1e-9 * (high[axis] - low[axis]) + 1e-300;
        low[axis] -= margin;
        high[axis] += margin;
        volume *= high[axis] - low[axis];
    }
    double side = std::cbrt(volume * PER_BLOCK / static_cast<double>(points.size()));
    int blocks[3];
    for (int axis = 0; axis < 3; ++axis) blocks[axis] = std::max(1, static_cast<int>((high[axis] - low[axis]) / side));
    std::uint64_t cells = 0;
    auto measured = driver::measure([&] {
        voro::container box(low[0], high[0], low[1], high[1], low[2], high[2], blocks[0], blocks[1], blocks[2], false, false,
                            false, 8);
        for (std::size_t i = 0; i < points.size(); ++i)
            box.put(static_cast<int>(i), points[i][0], points[i][1], points[i][2]);
        voro::voronoicell_neighbor cell;
        voro::c_loop_all loop(box);
        if (loop.start()) do
                if (box.compute_cell(cell, loop)) ++cells;
            while (loop.inc());
    });
    driver::answer(measured, cells, 0, false, VERSION);
}
