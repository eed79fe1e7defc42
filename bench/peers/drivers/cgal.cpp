// CGAL: Delaunay_triangulation_3 with Compact_location (its default) and its own spatially sorted insertion of a range;
// Delaunay_triangulation_2 in the plane. With CGAL_LINKED_WITH_TBB, it uses Parallel_tag and a lock grid in space.
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/version.h>

#ifdef CGAL_LINKED_WITH_TBB
#include <tbb/global_control.h>
#endif

#include <memory>

#include "driver.hpp"

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

template <class Point> std::uint64_t corner(const Point& p, std::size_t dimension) {
    return driver::corner(dimension, [&](std::size_t i) { return p[static_cast<int>(i)]; });
}

#ifdef CGAL_LINKED_WITH_TBB
using Structure = CGAL::Triangulation_data_structure_3<CGAL::Triangulation_vertex_base_3<Kernel>,
                                                       CGAL::Delaunay_triangulation_cell_base_3<Kernel>, CGAL::Parallel_tag>;
using Space = CGAL::Delaunay_triangulation_3<Kernel, Structure>;
// Cells of the lock grid along an axis, as in CGAL's manual.
constexpr int LOCKS = 50;

std::unique_ptr<Space> build(const std::vector<Space::Point>& points) {
    auto box = CGAL::bbox_3(points.begin(), points.end());
    Space::Lock_data_structure locks(box, LOCKS);
    auto made = std::make_unique<Space>(points.begin(), points.end(), &locks);
    made->set_lock_data_structure(nullptr);
    return made;
}
#else
using Space = CGAL::Delaunay_triangulation_3<Kernel>;

std::unique_ptr<Space> build(const std::vector<Space::Point>& points) {
    return std::make_unique<Space>(points.begin(), points.end());
}
#endif

const std::string VERSION = CGAL_VERSION_STR;

void space(const driver::Points& given) {
    std::vector<Space::Point> points;
    points.reserve(given.size());
    for (std::size_t i = 0; i < given.size(); ++i) points.emplace_back(given[i][0], given[i][1], given[i][2]);
    std::unique_ptr<Space> made;
    auto measured = driver::measure([&] { made = build(points); });
    driver::Cells<4> cells;
    for (auto c = made->finite_cells_begin(); c != made->finite_cells_end(); ++c)
        cells.add({corner(c->vertex(0)->point(), 3), corner(c->vertex(1)->point(), 3), corner(c->vertex(2)->point(), 3),
                   corner(c->vertex(3)->point(), 3)});
    driver::answer(measured, cells, VERSION);
}

void plane(const driver::Points& given) {
    using Plane = CGAL::Delaunay_triangulation_2<Kernel>;
    std::vector<Plane::Point> points;
    points.reserve(given.size());
    for (std::size_t i = 0; i < given.size(); ++i) points.emplace_back(given[i][0], given[i][1]);
    std::unique_ptr<Plane> made;
    auto measured = driver::measure([&] { made = std::make_unique<Plane>(points.begin(), points.end()); });
    driver::Cells<3> cells;
    for (auto c = made->finite_faces_begin(); c != made->finite_faces_end(); ++c)
        cells.add({corner(c->vertex(0)->point(), 2), corner(c->vertex(1)->point(), 2), corner(c->vertex(2)->point(), 2)});
    driver::answer(measured, cells, VERSION);
}

int main(int argc, char** argv) {
    auto task = driver::task(argc, argv);
#ifdef CGAL_LINKED_WITH_TBB
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(task.threads));
    if (task.points.dimension != 3) driver::fail("CGAL inserts in parallel in space only");
#else
    if (task.threads != 1) driver::fail("one thread only");
#endif
    if (task.points.dimension == 3) space(task.points);
    else plane(task.points);
}
