// Checks millions of cells against CGAL, with its exact predicates and its own triangulation.
//
// Usage: cgal_large DIMENSION POINTS CELLS [general]
//
// POINTS and CELLS are .npy files of septet (doubles; 64-bit indices). Every cell must be positively oriented. Every facet
// must belong to at most two cells and be locally Delaunay. The volume must equal that of CGAL to 1e-9, which excludes
// double covers and holes. The numbers of cells and hull facets must satisfy Euler's formula. With `general` (points
// without ties) the cells must equal those of CGAL, one by one.
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

[[noreturn]] void fail(const std::string& reason) {
    std::cout << "FAILED " << reason << std::endl;
    std::exit(1);
}

template <class T> std::vector<T> load(const char* name) {
    std::ifstream file(name, std::ios::binary | std::ios::ate);
    if (!file) fail(std::string("cannot read ") + name);
    std::vector<char> bytes(static_cast<std::size_t>(file.tellg()));
    file.seekg(0);
    file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (bytes.size() < 10 || std::memcmp(bytes.data(), "\x93NUMPY\x01", 7) != 0) fail("no .npy file of version 1");
    std::size_t head = 10 + static_cast<unsigned char>(bytes[8]) + 256u * static_cast<unsigned char>(bytes[9]);
    std::vector<T> data((bytes.size() - head) / sizeof(T));
    std::memcpy(data.data(), bytes.data() + head, data.size() * sizeof(T));
    return data;
}

struct Plane {
    static constexpr int dimension = 2;
    using Point = Kernel::Point_2;
    using Vertex = CGAL::Triangulation_vertex_base_with_info_2<std::uint64_t, Kernel>;
    using Delaunay = CGAL::Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<Vertex>>;
    static Point point(const double* c) { return Point(c[0], c[1]); }
    static bool positive(const std::array<Point, 3>& p) {
        return CGAL::orientation(p[0], p[1], p[2]) == CGAL::POSITIVE;
    }
    static bool inside(const std::array<Point, 3>& p, const Point& q) {
        return CGAL::side_of_oriented_circle(p[0], p[1], p[2], q) == CGAL::ON_POSITIVE_SIDE;
    }
    static long double volume(const std::array<Point, 3>& p) {
        long double a[2], b[2];
        for (int i = 0; i < 2; ++i) a[i] = (long double)p[1][i] - p[0][i], b[i] = (long double)p[2][i] - p[0][i];
        return a[0] * b[1] - a[1] * b[0];
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
    static long double volume(const std::array<Point, 4>& p) {
        long double m[3][3];
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) m[i][j] = (long double)p[i + 1][j] - p[0][j];
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
    struct Side {
        std::array<std::uint64_t, d> facet;
        std::uint64_t cell, apex;
        bool operator<(const Side& o) const { return facet < o.facet; }
    };

    auto coordinates = load<double>(points_name);
    auto indices = load<std::uint64_t>(cells_name);
    std::vector<std::pair<Point, std::uint64_t>> points;
    for (std::size_t i = 0; i < coordinates.size(); i += d) points.push_back({S::point(&coordinates[i]), i / d});
    auto corners = [&](const Row& row) {
        std::array<Point, d + 1> p;
        for (int i = 0; i <= d; ++i) p[i] = points.at(row[i]).first;
        return p;
    };
    std::vector<Row> rows(indices.size() / (d + 1));
    std::vector<Side> sides;
    sides.reserve(indices.size());
    long double volume = 0;
    for (std::size_t c = 0; c < rows.size(); ++c) {
        std::copy_n(&indices[c * (d + 1)], d + 1, rows[c].begin());
        auto p = corners(rows[c]);
        if (!S::positive(p)) fail("cell " + std::to_string(c) + " is not positive");
        volume += S::volume(p);
        for (int i = 0; i <= d; ++i) {
            Side side{{}, c, rows[c][i]};
            for (int j = 0, k = 0; j <= d; ++j)
                if (j != i) side.facet[k++] = rows[c][j];
            std::sort(side.facet.begin(), side.facet.end());
            sides.push_back(side);
        }
    }
    std::sort(sides.begin(), sides.end());
    std::size_t hull = 0;
    for (std::size_t i = 0, next; i < sides.size(); i = next) {
        next = i + 1;
        while (next < sides.size() && sides[next].facet == sides[i].facet) ++next;
        if (next - i > 2) fail("a facet in three cells");
        if (next - i == 1) ++hull;
        else if (S::inside(corners(rows[sides[i].cell]), points[sides[i + 1].apex].first))
            fail("cells " + std::to_string(sides[i].cell) + " and " + std::to_string(sides[i + 1].cell) +
                 " are not locally Delaunay");
    }
    sides.clear();
    sides.shrink_to_fit();

    typename S::Delaunay delaunay(points.begin(), points.end());
    long double expected = 0;
    std::vector<Row> theirs;
    S::cells(delaunay, [&](const auto& cell) {
        Row row;
        for (int i = 0; i <= d; ++i) row[i] = cell.vertex(i)->info();
        long double v = S::volume(corners(row));
        expected += v < 0 ? -v : v;
        std::sort(row.begin(), row.end());
        theirs.push_back(row);
    });
    long double gap = volume > expected ? volume - expected : expected - volume;
    if (gap > 1e-9L * expected) fail("the volumes differ");
    if (general) {
        for (auto& row : rows) std::sort(row.begin(), row.end());
        std::sort(rows.begin(), rows.end());
        std::sort(theirs.begin(), theirs.end());
        if (rows != theirs) fail("the cells are not CGAL's");
    }
    std::cout << "passed " << rows.size() << " cells, " << hull << " hull facets"
              << (general ? ", cell by cell" : ", locally Delaunay") << ", CGAL has " << theirs.size() << std::endl;
}

int main(int argc, char** argv) {
    if (argc < 4) fail("usage: cgal_large DIMENSION POINTS CELLS [general]");
    bool general = argc > 4 && std::string(argv[4]) == "general";
    if (std::atoi(argv[1]) == 2) check<Plane>(argv[2], argv[3], general);
    else check<Space>(argv[2], argv[3], general);
}
