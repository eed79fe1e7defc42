// Checks cells against CGAL, with its exact predicates and its own triangulation.
//
// Usage: cgal_check DIMENSION POINTS CELLS [general]
//
// POINTS holds little-endian doubles, DIMENSION a point; CELLS 64-bit indices, DIMENSION + 1 a cell. Every cell
// has to be positively oriented, every facet locally Delaunay and in at most two cells, and the exact volume
// that of CGAL's triangulation. With `general` (no ties among the points) the cells have to be CGAL's, too.
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Exact_rational.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <string>
#include <vector>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Number = CGAL::Exact_rational;

[[noreturn]] void fail(const std::string& reason) {
    std::cout << "FAILED " << reason << std::endl;
    std::exit(1);
}

template <class T> std::vector<T> load(const char* name) {
    std::ifstream file(name, std::ios::binary | std::ios::ate);
    if (!file) fail(std::string("cannot read ") + name);
    std::vector<T> data(static_cast<std::size_t>(file.tellg()) / sizeof(T));
    file.seekg(0);
    file.read(reinterpret_cast<char*>(data.data()), static_cast<std::streamsize>(data.size() * sizeof(T)));
    return data;
}

struct Plane {
    static constexpr int dimension = 2;
    using Point = Kernel::Point_2;
    using Vertex = CGAL::Triangulation_vertex_base_with_info_2<std::uint64_t, Kernel>;
    using Structure = CGAL::Triangulation_data_structure_2<Vertex>;
    using Delaunay = CGAL::Delaunay_triangulation_2<Kernel, Structure>;
    static Point point(const double* c) { return Point(c[0], c[1]); }
    static bool positive(const std::array<Point, 3>& p) {
        return CGAL::orientation(p[0], p[1], p[2]) == CGAL::POSITIVE;
    }
    static bool inside(const std::array<Point, 3>& p, const Point& q) {
        return CGAL::side_of_oriented_circle(p[0], p[1], p[2], q) == CGAL::ON_POSITIVE_SIDE;
    }
    static Number volume(const std::array<Point, 3>& p) {
        Number m[2][2];
        for (int i = 0; i < 2; ++i)
            for (int j = 0; j < 2; ++j) m[i][j] = Number(p[i + 1][j]) - Number(p[0][j]);
        return m[0][0] * m[1][1] - m[0][1] * m[1][0];
    }
    template <class F> static void cells(const Delaunay& t, F f) {
        for (auto c = t.finite_faces_begin(); c != t.finite_faces_end(); ++c) f(*c);
    }
};

struct Space {
    static constexpr int dimension = 3;
    using Point = Kernel::Point_3;
    using Vertex = CGAL::Triangulation_vertex_base_with_info_3<std::uint64_t, Kernel>;
    using Structure = CGAL::Triangulation_data_structure_3<Vertex, CGAL::Delaunay_triangulation_cell_base_3<Kernel>>;
    using Delaunay = CGAL::Delaunay_triangulation_3<Kernel, Structure>;
    static Point point(const double* c) { return Point(c[0], c[1], c[2]); }
    static bool positive(const std::array<Point, 4>& p) {
        return CGAL::orientation(p[0], p[1], p[2], p[3]) == CGAL::POSITIVE;
    }
    static bool inside(const std::array<Point, 4>& p, const Point& q) {
        return CGAL::side_of_oriented_sphere(p[0], p[1], p[2], p[3], q) == CGAL::ON_POSITIVE_SIDE;
    }
    static Number volume(const std::array<Point, 4>& p) {
        Number m[3][3];
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) m[i][j] = Number(p[i + 1][j]) - Number(p[0][j]);
        return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
               m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    }
    template <class F> static void cells(const Delaunay& t, F f) {
        for (auto c = t.finite_cells_begin(); c != t.finite_cells_end(); ++c) f(*c);
    }
};

template <class S> void check(const char* points_name, const char* cells_name, bool general) {
    constexpr int d = S::dimension;
    using Point = typename S::Point;
    using Row = std::array<std::uint64_t, d + 1>;
    using Facet = std::array<std::uint64_t, d>;

    auto coordinates = load<double>(points_name);
    auto indices = load<std::uint64_t>(cells_name);
    std::vector<Point> points;
    for (std::size_t i = 0; i < coordinates.size(); i += d) points.push_back(S::point(&coordinates[i]));
    auto corners = [&](const Row& row) {
        std::array<Point, d + 1> p;
        for (int i = 0; i <= d; ++i) p[i] = points.at(row[i]);
        return p;
    };

    std::vector<Row> rows(indices.size() / (d + 1));
    Number volume = 0;
    std::map<Facet, std::vector<std::pair<std::size_t, std::uint64_t>>> facets;
    for (std::size_t c = 0; c < rows.size(); ++c) {
        std::copy_n(&indices[c * (d + 1)], d + 1, rows[c].begin());
        auto p = corners(rows[c]);
        if (!S::positive(p)) fail("cell " + std::to_string(c) + " is not positive");
        volume += S::volume(p);
        for (int i = 0; i <= d; ++i) {
            Facet facet;
            for (int j = 0, k = 0; j <= d; ++j)
                if (j != i) facet[k++] = rows[c][j];
            std::sort(facet.begin(), facet.end());
            facets[facet].push_back({c, rows[c][i]});
        }
    }
    for (const auto& [facet, sides] : facets) {
        if (sides.size() > 2) fail("a facet in three cells");
        if (sides.size() == 2 && S::inside(corners(rows[sides[0].first]), points[sides[1].second]))
            fail("cells " + std::to_string(sides[0].first) + " and " + std::to_string(sides[1].first) +
                 " are not locally Delaunay");
    }

    // Of coincident points the smallest index counts.
    std::map<Point, std::uint64_t> first;
    for (std::size_t i = 0; i < points.size(); ++i) first.insert({points[i], i});
    typename S::Delaunay delaunay(points.begin(), points.end());
    for (auto v = delaunay.finite_vertices_begin(); v != delaunay.finite_vertices_end(); ++v)
        v->info() = first.at(v->point());
    Number expected = 0;
    std::vector<Row> theirs, ours = rows;
    S::cells(delaunay, [&](const auto& cell) {
        Row row;
        for (int i = 0; i <= d; ++i) row[i] = cell.vertex(i)->info();
        expected += CGAL::abs(S::volume(corners(row)));
        theirs.push_back(row);
    });
    if (volume != expected) fail("the volumes differ");
    auto sorted = [](std::vector<Row>& all) {
        for (auto& row : all) std::sort(row.begin(), row.end());
        std::sort(all.begin(), all.end());
    };
    sorted(ours);
    sorted(theirs);
    if (general && ours.size() != theirs.size())
        fail(std::to_string(ours.size()) + " cells, " + std::to_string(theirs.size()) + " by CGAL");
    bool equal = ours == theirs;
    if (general && !equal) fail("other cells than CGAL's");
    std::cout << "ok " << rows.size() << " cells, " << theirs.size() << " by CGAL, " << (equal ? "equal" : "ties differ")
              << std::endl;
}

int main(int argc, char** argv) {
    if (argc < 4) fail("usage: cgal_check DIMENSION POINTS CELLS [general]");
    bool general = argc > 4 && std::string(argv[4]) == "general";
    if (std::string(argv[1]) == "2") check<Plane>(argv[2], argv[3], general);
    else check<Space>(argv[2], argv[3], general);
}
