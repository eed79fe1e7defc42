// Prints CGAL's Delaunay triangulation of points in a periodic box, by its exact predicates.
//
// Usage: cgal_periodic DIMENSION POINTS
//
// POINTS holds little-endian doubles, DIMENSION coordinates a point, in the unit square or cube without its upper faces. Each
// line of the output is a cell: for each vertex, the index of its point and DIMENSION whole numbers, its offset from the
// point in lengths of the box. The vertices of a cell are in no particular order, and the translation of a cell is any.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Periodic_2_Delaunay_triangulation_2.h>
#include <CGAL/Periodic_2_Delaunay_triangulation_traits_2.h>
#include <CGAL/Periodic_3_Delaunay_triangulation_3.h>
#include <CGAL/Periodic_3_Delaunay_triangulation_traits_3.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <string>
#include <vector>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

[[noreturn]] void fail(const std::string& reason) {
    std::cerr << reason << std::endl;
    std::exit(1);
}

struct Plane {
    static constexpr int dimension = 2;
    using Triangulation = CGAL::Periodic_2_Delaunay_triangulation_2<CGAL::Periodic_2_Delaunay_triangulation_traits_2<Kernel>>;
    using Point = Triangulation::Point;
    static Point point(const double* c) { return Point(c[0], c[1]); }
    template <class F> static void cells(const Triangulation& t, F f) {
        for (auto c = t.faces_begin(); c != t.faces_end(); ++c) f(t.periodic_triangle(c));
    }
};

struct Space {
    static constexpr int dimension = 3;
    using Triangulation = CGAL::Periodic_3_Delaunay_triangulation_3<CGAL::Periodic_3_Delaunay_triangulation_traits_3<Kernel>>;
    using Point = Triangulation::Point;
    static Point point(const double* c) { return Point(c[0], c[1], c[2]); }
    template <class F> static void cells(const Triangulation& t, F f) {
        for (auto c = t.cells_begin(); c != t.cells_end(); ++c) f(t.periodic_tetrahedron(c));
    }
};

template <class S> void print(const char* name) {
    constexpr int d = S::dimension;
    std::ifstream file(name, std::ios::binary | std::ios::ate);
    if (!file) fail(std::string("cannot read ") + name);
    std::vector<double> data(static_cast<std::size_t>(file.tellg()) / sizeof(double));
    file.seekg(0);
    file.read(reinterpret_cast<char*>(data.data()), static_cast<std::streamsize>(data.size() * sizeof(double)));
    std::vector<typename S::Point> points;
    std::map<std::array<double, d>, std::uint64_t> first;
    for (std::size_t i = 0; i + d <= data.size(); i += d) {
        points.push_back(S::point(&data[i]));
        std::array<double, d> key;
        for (int k = 0; k < d; ++k) key[k] = data[i + k];
        first.insert({key, i / d});
    }
    typename S::Triangulation t(points.begin(), points.end());
    if (!t.is_1_cover()) fail("CGAL needs several sheets");
    S::cells(t, [&](const auto& cell) {
        for (int i = 0; i <= d; ++i) {
            std::array<double, d> key;
            for (int k = 0; k < d; ++k) key[k] = cell[i].first[k];
            std::cout << (i ? " " : "") << first.at(key);
            for (int k = 0; k < d; ++k) std::cout << ' ' << cell[i].second[k];
        }
        std::cout << '\n';
    });
}

int main(int argc, char** argv) {
    if (argc != 3) fail("usage: cgal_periodic DIMENSION POINTS");
    std::ios::sync_with_stdio(false);
    if (std::string(argv[1]) == "2") print<Plane>(argv[2]);
    else print<Space>(argv[2]);
}
