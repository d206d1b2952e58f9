// Rebuild and traversal of the sphere pyramid: CPU time beside that of a copy of the same
// positions, in one run.
#include <cmath>
#include <cstdio>
#include <cstring>

#include "bench/medians.h"
#include "bsi/pyramid.h"
#include "bsi/shapes.h"
#include "bsi/traversal.h"

namespace {

using namespace weft::bsi;

template <class Work>
double milliseconds(const Work& work) {
  std::vector<double> times;
  for (int i = 0; i < 15; ++i) times.push_back(1e3 * weft::bench::cpu_time_of(work));
  return weft::bench::median(times);
}

void measure(int n) {
  Surface sheet = make_rectangle(2, 2, n, n);
  for (Vec3& p : sheet.positions) p.z() = 0.05 * std::sin(9 * p.x()) * std::cos(7 * p.y());
  Pyramid fast(sheet.atlas, RadiusPolicy::fast), exact(sheet.atlas, RadiusPolicy::exact);
  std::vector<Vec3> copy(sheet.positions.size());
  const double copy_ms = milliseconds([&] {
    std::memcpy(static_cast<void*>(copy.data()), sheet.positions.data(),
                copy.size() * sizeof(Vec3));
  });
  const double fast_ms = milliseconds([&] { static_cast<void>(fast.rebuild(sheet.positions)); });
  const double exact_ms = milliseconds([&] { static_cast<void>(exact.rebuild(sheet.positions)); });
  BoxPyramid boxes(sheet.atlas);
  const double box_ms = milliseconds([&] { static_cast<void>(boxes.rebuild(sheet.positions)); });
  std::vector<LeafPair> pairs;
  TraversalCounters counters;
  const double self_ms = milliseconds([&] {
    pairs.clear();
    counters = {};
    self_traversal(boxes, {.margin = 2e-3}, pairs, counters);
  });
  std::printf("%6d %10.3f %10.3f %10.3f %10.3f %12.1f %12.3f %12zu %10.1f\n", n, copy_ms, fast_ms,
              exact_ms, box_ms, fast_ms / copy_ms, self_ms, pairs.size(),
              1e6 * self_ms / static_cast<double>(counters.box_tests));
}

}  // namespace

int main() {
  std::printf("a wavy sheet of n x n vertices, margin 2 mm; CPU ms, medians of 15\n");
  std::printf("%6s %10s %10s %10s %10s %12s %12s %12s %10s\n", "n", "copy", "fast", "exact",
              "boxes", "fast/copy", "self", "pairs", "ns/test");
  for (int n : {65, 129, 257, 513, 1025}) measure(n);
  return 0;
}
