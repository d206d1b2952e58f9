// Rebuild of the sphere pyramid: times beside the memory-traffic floor, a copy that reads as many
// bytes as the image holds and writes as many as the hierarchy. Medians of interleaved repeats.
#include <omp.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <vector>

#include "bench/medians.h"
#include "bsi/instruction_set.h"
#include "bsi/pyramid.h"
#include "bsi/shapes.h"

namespace {

using namespace weft::bsi;

double elapsed_ms(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

std::vector<double> interleaved_medians(const std::vector<std::function<void()>>& works,
                                        int repeats) {
  std::vector<std::vector<double>> times(works.size());
  for (int i = 0; i < repeats; ++i) {
    for (std::size_t k = 0; k < works.size(); ++k) times[k].push_back(elapsed_ms(works[k]));
  }
  std::vector<double> medians;
  for (const auto& of_work : times) medians.push_back(weft::bench::median(of_work));
  return medians;
}

Surface wavy_sheet(int n) {
  Surface sheet = make_rectangle(2, 2, n, n);
  for (Vec3& p : sheet.positions) p.z() = 0.05 * std::sin(9 * p.x()) * std::cos(7 * p.y());
  return sheet;
}

// Of the spheres alone, which is what a rebuild must write.
std::size_t sphere_bytes(const Pyramid& pyramid) {
  std::size_t count = 0;
  for (int level = 0; level < pyramid.levels(0); ++level) {
    count += pyramid.level_spheres(0, level).size();
  }
  return count * sizeof(Sphere);
}

void measure(int n, int threads) {
  const Surface sheet = wavy_sheet(n);
  Pyramid fast(sheet.atlas, RadiusPolicy::fast), exact(sheet.atlas, RadiusPolicy::exact);
  Pyramid shared(sheet.atlas, RadiusPolicy::fast), shared_exact(sheet.atlas, RadiusPolicy::exact);
  const std::size_t read = sheet.positions.size() * sizeof(Vec3), written = sphere_bytes(fast);
  const auto* image = reinterpret_cast<const char*>(sheet.positions.data());
  std::vector<char> hierarchy(std::max(read, written));
  volatile double sum = 0;
  const auto copy = [&] {
    std::memcpy(hierarchy.data(), image, std::min(read, written));
    double rest = 0;  // what is read and not written
    for (std::size_t i = written; i < read; i += 64) rest += image[i];
    if (read < written) std::memset(hierarchy.data() + read, 0, written - read);
    sum = rest;
  };
  const auto on_threads = [&](Pyramid& pyramid, int count) {
    return [&, count] {
      omp_set_num_threads(count);
      static_cast<void>(pyramid.rebuild(sheet.positions));
    };
  };
  const auto ms =
      interleaved_medians({copy, on_threads(fast, 1), on_threads(exact, 1),
                           on_threads(shared, threads), on_threads(shared_exact, threads)},
                          n < 600 ? 201 : 21);
  std::printf("%6d %9.3f %9.3f %9.3f %8.2f %8.2f %9.2f %9.2f %9.2f %9.2f\n", n, ms[0], ms[1], ms[2],
              ms[1] / ms[0], ms[2] / ms[1], ms[1] / ms[3], ms[2] / ms[4],
              1e6 * ms[1] / (double(n) * n), static_cast<double>(fast.bytes()) / (1 << 20));
}

}  // namespace

int main(int argc, char** argv) {
  const int threads = argc > 1 ? std::atoi(argv[1]) : 2;
  std::printf("a wavy sheet of n x n vertices; wall ms, medians of interleaved repeats; %s\n",
              name(instruction_set()).data());
  std::printf("%6s %9s %9s %9s %8s %8s %9s %9s %9s %9s\n", "n", "copy", "fast", "exact", "f/copy",
              "e/f", "f 1/N", "e 1/N", "ns/vertex", "MiB fast");
  for (int n : {64, 65, 128, 200, 256, 257, 512, 513, 1024, 1025, 2048}) measure(n, threads);
  return 0;
}
