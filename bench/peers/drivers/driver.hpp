// The common code of all drivers: reading the points, the clock, resident memory, the hash of the cells, the output.
//
// A driver is called as `driver POINTS.npy THREADS`, reads the points, times one call of its library, and prints one
// object of JSON. Wall and processor seconds are measured during the call only; `rss_peak` is the largest resident memory
// between the end of reading and the end of the call.
//
// The hash is the sum modulo 2^64 over all finite cells of a mix of the cell's corners, where a corner is a mix of the
// bits of its coordinates (-0 counting as 0) and the corners of a cell are sorted. It depends neither on the order of
// cells or corners nor on the numbering of points. `driver.py` computes the same.
#pragma once

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

namespace driver {

[[noreturn]] inline void fail(const std::string& reason) {
    std::fprintf(stderr, "%s\n", reason.c_str());
    std::exit(1);
}

// Points one after the other, `dimension` doubles each.
struct Points {
    std::size_t dimension = 0;
    std::vector<double> coordinates;
    std::size_t size() const { return coordinates.size() / dimension; }
    const double* operator[](std::size_t i) const { return &coordinates[i * dimension]; }
};

// Reads a .npy file of version 1 that holds doubles in C order, shape (n, 2) or (n, 3).
inline Points read(const char* name) {
    std::ifstream file(name, std::ios::binary | std::ios::ate);
    if (!file) fail(std::string("cannot read ") + name);
    auto bytes = static_cast<std::size_t>(file.tellg());
    file.seekg(0);
    unsigned char start[10];
    if (!file.read(reinterpret_cast<char*>(start), 10) || std::memcmp(start, "\x93NUMPY\x01", 7) != 0)
        fail("no .npy file of version 1");
    std::string head(start[8] + 256u * start[9], ' ');
    file.read(&head[0], static_cast<std::streamsize>(head.size()));
    bool doubles = head.find("'<f8'") != std::string::npos;
    bool rows = head.find("'fortran_order': False") != std::string::npos;
    std::size_t comma = head.find(", ", head.find('('));
    if (!file || !doubles || !rows || comma == std::string::npos) fail("no rows of doubles");
    Points points;
    points.dimension = std::strtoul(&head[comma + 2], nullptr, 10);
    if (points.dimension != 2 && points.dimension != 3) fail("points of dimension 2 or 3 only");
    points.coordinates.resize((bytes - 10 - head.size()) / sizeof(double));
    file.read(reinterpret_cast<char*>(points.coordinates.data()),
              static_cast<std::streamsize>(points.coordinates.size() * sizeof(double)));
    if (!file || points.coordinates.size() % points.dimension) fail("the file is cut off");
    return points;
}

// A line of /proc/self/status, in bytes.
inline std::uint64_t memory(const char* key) {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.rfind(key, 0) == 0) return 1024 * std::strtoull(&line[std::strlen(key) + 1], nullptr, 10);
    fail("the system does not tell resident memory");
}

inline double processor() {
    rusage use{};
    getrusage(RUSAGE_SELF, &use);
    return static_cast<double>(use.ru_utime.tv_sec + use.ru_stime.tv_sec) +
           1e-6 * static_cast<double>(use.ru_utime.tv_usec + use.ru_stime.tv_usec);
}

struct Measured {
    double seconds, processor;
    std::uint64_t before, peak;
};

// Times one call. The peak of resident memory is reset before it.
template <class F> Measured measure(F call) {
    std::ofstream("/proc/self/clear_refs") << "5";
    Measured m{};
    m.before = memory("VmRSS");
    double used = processor();
    auto start = std::chrono::steady_clock::now();
    call();
    m.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    m.processor = processor() - used;
    m.peak = memory("VmHWM");
    return m;
}

// The last steps of splitmix64 (Steele, Lea and Flood 2014).
inline std::uint64_t mix(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

// The hash of one corner. `coordinate(i)` returns the coordinate of axis i.
template <class F> std::uint64_t corner(std::size_t dimension, F coordinate) {
    std::uint64_t h = dimension;
    for (std::size_t i = 0; i < dimension; ++i) {
        double x = coordinate(i) + 0.0;
        std::uint64_t bits;
        std::memcpy(&bits, &x, sizeof bits);
        h = mix(h ^ bits);
    }
    return h;
}

// Counts cells and sums their hashes.
template <std::size_t N> struct Cells {
    std::uint64_t count = 0, hash = 0;
    void add(std::array<std::uint64_t, N> corners) {
        std::sort(corners.begin(), corners.end());
        std::uint64_t h = N;
        for (std::uint64_t c : corners) h = mix(h ^ c);
        hash += h;
        ++count;
    }
};

// The output. If no cells were hashed (`hashed` is false), `count` is the count of the library.
inline void answer(const Measured& m, std::uint64_t count, std::uint64_t hash, bool hashed, const std::string& version) {
    std::printf("{\"seconds\": %.6f, \"processor_seconds\": %.6f, \"rss_before\": %" PRIu64 ", \"rss_peak\": %" PRIu64
                ", \"cells\": %" PRIu64 ", ",
                m.seconds, m.processor, m.before, m.peak, count);
    if (hashed) std::printf("\"hash\": \"%016" PRIx64 "\", ", hash);
    else std::printf("\"hash\": null, ");
    std::printf("\"version\": \"%s\"}\n", version.c_str());
}

template <std::size_t N> void answer(const Measured& m, const Cells<N>& cells, const std::string& version) {
    answer(m, cells.count, cells.hash, true, version);
}

// The command line: the points and the number of threads.
struct Task {
    Points points;
    int threads;
};

inline Task task(int argc, char** argv) {
    if (argc != 3) fail("usage: driver POINTS.npy THREADS");
    return {read(argv[1]), std::atoi(argv[2])};
}

}  // namespace driver
