// Rebuild of the pyramid with and without its parts: times beside the memory-traffic floor, a copy
// that reads as many bytes as the image holds and writes as many as the boxes take. A body that
// moves as a rigid one, searched after a rebuild and in its own frame. Medians of interleaved
// repeats.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <vector>

#include "bench/experiments.h"
#include "bench/medians.h"
#include "bsi/detail/instruction_set.h"
#include "bsi/pyramid.h"
#include "bsi/shapes.h"
#include "bsi/traversal.h"

namespace weft::bench {

namespace {

using namespace bsi;

using Works = std::vector<std::function<void()>>;

// Returns medians in ms, by a clock of clock_gettime().
std::vector<double> interleaved_medians(const Works& works, int repeats, clockid_t clock) {
  std::vector<std::vector<double>> times(works.size());
  for (int i = 0; i < repeats; ++i) {
    for (std::size_t k = 0; k < works.size(); ++k)
      times[k].push_back(1e3 * time_of(clock, works[k]));
  }
  std::vector<double> medians;
  medians.reserve(times.size());
  for (const auto& of_work : times) medians.push_back(median(of_work));
  return medians;
}

Surface wavy_sheet(int n) {
  Surface sheet = make_rectangle(2, 2, n, n);
  for (Vec3& p : sheet.positions) p.z() = 0.05 * std::sin(9 * p.x()) * std::cos(7 * p.y());
  return sheet;
}

// Three pyramids of one image: with boxes only, with spheres, and with spheres and the bounds of
// steps.
class Pyramids {
 public:
  explicit Pyramids(const Surface& sheet)
      : sheet_(sheet),
        boxes_(sheet.atlas, {.tangents = false}),
        spheres_(sheet.atlas, {.tangents = false, .spheres = true}),
        all_(sheet.atlas, {.tangents = true, .spheres = true}) {}

  Works rebuilds(int threads) {
    const auto of = [this, threads](Pyramid& pyramid) {
      return [this, &pyramid, threads] {
        static_cast<void>(pyramid.rebuild(sheet_.positions, threads));
      };
    };
    return {of(boxes_), of(spheres_), of(all_)};
  }
  std::size_t bytes_of_boxes() const { return boxes_.bytes(); }
  std::size_t bytes() const { return all_.bytes(); }

 private:
  const Surface& sheet_;
  Pyramid boxes_, spheres_, all_;
};

// The floor: reads the image, writes as many bytes as the hierarchy has.
std::function<void()> copy(const Surface& sheet, std::size_t written, std::vector<char>& out) {
  const std::size_t read = sheet.positions.size() * sizeof(Vec3);
  out.resize(std::max(read, written));
  const auto* image = reinterpret_cast<const char*>(sheet.positions.data());
  return [=, &out] {
    std::memcpy(out.data(), image, std::min(read, written));
    volatile char rest = 0;  // consumes bytes that are read but not written
    for (std::size_t i = written; i < read; i += 64) rest = image[i];
    static_cast<void>(rest);
    if (read < written) std::memset(out.data() + read, 0, written - read);
  };
}

void measure_one_thread(int n, int repeats) {
  const Surface sheet = wavy_sheet(n);
  Pyramids pyramids(sheet);
  std::vector<char> out;
  Works works = pyramids.rebuilds(1);
  works.push_back(copy(sheet, pyramids.bytes_of_boxes(), out));
  const auto ms = interleaved_medians(works, repeats, CLOCK_THREAD_CPUTIME_ID);
  std::printf("%6d %9.3f %9.3f %9.3f %9.3f %9.2f %9.2f %9.2f %9.2f\n", n, ms[3], ms[0], ms[1],
              ms[2], ms[0] / ms[3], ms[1] / ms[0], 1e6 * ms[0] / (static_cast<double>(n) * n),
              static_cast<double>(pyramids.bytes()) / (1 << 20));
}

void measure_threads(int n, int threads, int repeats) {
  const Surface sheet = wavy_sheet(n);
  Pyramids pyramids(sheet);
  Works works = pyramids.rebuilds(1);
  const Works shared = pyramids.rebuilds(threads);
  works.insert(works.end(), shared.begin(), shared.end());
  const auto ms = interleaved_medians(works, repeats, CLOCK_MONOTONIC);
  std::printf("%6d %9.3f %9.3f %9.3f %9.2f %9.2f %9.2f\n", n, ms[0], ms[1], ms[2], ms[0] / ms[3],
              ms[1] / ms[4], ms[2] / ms[5]);
}

// A torus of n x n vertices that has moved as a rigid body, and a sheet that lies on it: the search
// with a rebuild of the torus, and in the frame of the torus. Returns whether both find the same.
bool measure_rigid(int n, int repeats) {
  const Surface torus = make_torus(0.6, 0.25, n, n), sheet = make_rectangle(1, 1, 33, 33);
  const RigidFrame frame{Eigen::AngleAxisd(0.7, Vec3(0.2, 0.1, 1).normalized()).toRotationMatrix(),
                         {0.1, 0, -0.25}};
  std::vector<Vec3> placed;
  placed.reserve(torus.positions.size());
  for (const Vec3& p : torus.positions) placed.push_back(frame.place(p));
  const RigidPyramid rigid(torus.atlas, torus.positions, false, 1);
  Pyramid rebuilt(torus.atlas, {.tangents = false}), first(sheet.atlas, {.tangents = false});
  static_cast<void>(first.rebuild(sheet.positions, 1));
  const TraversalOptions options{.margin = 0.01, .leaf = Leaf::quad, .threads = 1};
  TraversalCounters tests;
  std::vector<LeafPair> pairs, same;
  const Works works = {[&] { static_cast<void>(rebuilt.rebuild(placed, 1)); },
                       [&] {
                         pairs.clear();
                         dual_traversal(first, rebuilt, options, pairs, tests);
                       },
                       [&] {
                         same.clear();
                         dual_traversal(first, rigid, {&frame, 1}, options, same, tests);
                       }};
  const auto ms = interleaved_medians(works, repeats, CLOCK_THREAD_CPUTIME_ID);
  std::printf("%6d %9.3f %9.3f %9.3f %9.2f %9zu\n", n, ms[0], ms[1], ms[2], (ms[0] + ms[1]) / ms[2],
              pairs.size());
  std::sort(pairs.begin(), pairs.end());
  std::sort(same.begin(), same.end());
  return pairs == same;
}

}  // namespace

int run_rebuild(const RebuildOptions& options) {
  std::printf("a wavy sheet of n x n vertices, %s, medians of %d interleaved repeats\n",
              name(instruction_set()).data(), options.repeats);
  std::printf("one thread, CPU ms\n%6s %9s %9s %9s %9s %9s %9s %9s %9s\n", "n", "copy", "boxes",
              "+spheres", "+steps", "box/copy", "+sph./box", "ns/vertex", "MiB all");
  for (const int n : options.sizes) measure_one_thread(n, options.repeats);
  std::printf(
      "a torus that moves as a rigid body and a sheet of 33 x 33 on it, one thread, CPU ms\n"
      "%6s %9s %9s %9s %9s %9s\n",
      "n", "rebuild", "query", "in frame", "gain", "pairs");
  for (const int n : options.sizes) {
    if (measure_rigid(n, options.repeats)) continue;
    std::fprintf(stderr, "%d: other pairs are found in the frame of the torus\n", n);
    return 1;
  }
  if (options.threads == 1) return 0;
  std::printf(
      "wall ms of one thread, and how many times faster %d are\n%6s %9s %9s %9s %9s %9s %9s\n",
      options.threads, "n", "boxes", "+spheres", "+steps", "boxes", "+spheres", "+steps");
  for (const int n : options.sizes) measure_threads(n, options.threads, options.repeats);
  return 0;
}

}  // namespace weft::bench
