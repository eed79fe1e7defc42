// TetGen as a library: tetrahedra from points, with its copy of the result, without its list of faces.
#include <tetgen.h>

#include "driver.hpp"

int main(int argc, char** argv) {
    auto task = driver::task(argc, argv);
    const auto& points = task.points;
    if (points.dimension != 3 || task.threads != 1) driver::fail("TetGen: space and one thread only");
    tetgenio in, out;
    in.firstnumber = 0;
    in.numberofpoints = static_cast<int>(points.size());
    in.pointlist = new REAL[points.coordinates.size()];
    std::copy(points.coordinates.begin(), points.coordinates.end(), in.pointlist);
    char switches[] = "QF";
    auto measured = driver::measure([&] { tetrahedralize(switches, &in, &out); });
    driver::Cells<4> cells;
    for (int c = 0; c < out.numberoftetrahedra; ++c) {
        std::array<std::uint64_t, 4> corners;
        for (int i = 0; i < 4; ++i) {
            const REAL* p = &out.pointlist[3 * out.tetrahedronlist[c * out.numberofcorners + i]];
            corners[static_cast<std::size_t>(i)] = driver::corner(3, [&](std::size_t axis) { return p[axis]; });
        }
        cells.add(corners);
    }
    driver::answer(measured, cells, VERSION);
}
