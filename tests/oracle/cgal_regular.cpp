// Prints CGAL's regular triangulation of sites with weights, by its exact predicates.
//
// Usage: cgal_regular DIMENSION SITES
//
// SITES holds little-endian doubles, DIMENSION coordinates and a weight a site. The output is a line "cells M", M lines with
// the indices of a finite cell, in ascending order, a line "hidden H", and H lines with the index of a hidden site. Of equal
// sites, the smallest index counts, and the others are not listed. The lines of cells are sorted, and so are those of
// hidden sites.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Regular_triangulation_2.h>
#include <CGAL/Regular_triangulation_3.h>

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

[[noreturn]] void fail(const std::string& reason) {
    std::cerr << reason << std::endl;
    std::exit(1);
}

struct Plane {
    static constexpr int dimension = 2;
    using Site = Kernel::Weighted_point_2;
    using Regular = CGAL::Regular_triangulation_2<Kernel>;
    static Site site(const double* c) { return Site(Kernel::Point_2(c[0], c[1]), c[2]); }
    template <class F> static void cells(const Regular& t, F f) {
        if (t.dimension() < dimension) return;
        for (auto c = t.finite_faces_begin(); c != t.finite_faces_end(); ++c) f(*c);
    }
};

struct Space {
    static constexpr int dimension = 3;
    using Site = Kernel::Weighted_point_3;
    using Regular = CGAL::Regular_triangulation_3<Kernel>;
    static Site site(const double* c) { return Site(Kernel::Point_3(c[0], c[1], c[2]), c[3]); }
    template <class F> static void cells(const Regular& t, F f) {
        if (t.dimension() < dimension) return;
        for (auto c = t.finite_cells_begin(); c != t.finite_cells_end(); ++c) f(*c);
    }
};

// The coordinates and the weight of a site. Negative zeros become positive.
template <class S> std::array<double, S::dimension + 1> key(const typename S::Site& site) {
    std::array<double, S::dimension + 1> all;
    for (int i = 0; i < S::dimension; ++i) all[i] = site.point()[i] + 0.0;
    all[S::dimension] = site.weight() + 0.0;
    return all;
}

template <class S> void print(const char* name) {
    constexpr int d = S::dimension;
    using Row = std::array<std::uint64_t, d + 1>;

    std::ifstream file(name, std::ios::binary | std::ios::ate);
    if (!file) fail(std::string("cannot read ") + name);
    std::vector<double> data(static_cast<std::size_t>(file.tellg()) / sizeof(double));
    file.seekg(0);
    file.read(reinterpret_cast<char*>(data.data()), static_cast<std::streamsize>(data.size() * sizeof(double)));

    std::vector<typename S::Site> sites;
    for (std::size_t i = 0; i + d < data.size(); i += d + 1) sites.push_back(S::site(&data[i]));
    std::map<std::array<double, d + 1>, std::uint64_t> first;
    for (std::size_t i = 0; i < sites.size(); ++i) first.insert({key<S>(sites[i]), i});

    typename S::Regular regular(sites.begin(), sites.end());
    if (!regular.is_valid()) fail("CGAL's triangulation is not valid");
    std::vector<bool> used(sites.size(), false);
    for (auto v = regular.finite_vertices_begin(); v != regular.finite_vertices_end(); ++v)
        used[first.at(key<S>(v->point()))] = true;
    std::vector<Row> rows;
    S::cells(regular, [&](const auto& cell) {
        Row row;
        for (int i = 0; i <= d; ++i) row[i] = first.at(key<S>(cell.vertex(i)->point()));
        std::sort(row.begin(), row.end());
        rows.push_back(row);
    });
    std::sort(rows.begin(), rows.end());
    std::vector<std::uint64_t> hidden;
    for (const auto& [site, index] : first)
        if (!used[index]) hidden.push_back(index);
    std::sort(hidden.begin(), hidden.end());

    std::cout << "cells " << rows.size() << '\n';
    for (const auto& row : rows)
        for (int i = 0; i <= d; ++i) std::cout << row[i] << (i == d ? '\n' : ' ');
    std::cout << "hidden " << hidden.size() << '\n';
    for (auto index : hidden) std::cout << index << '\n';
}

int main(int argc, char** argv) {
    if (argc != 3) fail("usage: cgal_regular DIMENSION SITES");
    std::ios::sync_with_stdio(false);
    if (std::string(argv[1]) == "2") print<Plane>(argv[2]);
    else print<Space>(argv[2]);
}
