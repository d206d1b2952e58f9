#include "bsi/narrow_phase.h"

#include <omp.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "bsi/narrow_phase_kernels.h"
#include "bsi/proximity.h"

namespace weft::bsi {

namespace {

static_assert(sizeof(Vec3) == 3 * sizeof(double));

constexpr int chunk_size = 2048;  // candidates

std::array<Vec3, 3> corners(const TriangleSet& set, int triangle) {
  const auto& [i, j, k] = set.triangles[triangle];
  return {set.positions[i], set.positions[j], set.positions[k]};
}

Triangle3 to_points(const std::array<Vec3, 3>& corner) {
  Triangle3 triangle;
  for (int i = 0; i < 3; ++i) triangle[i] = {corner[i].x(), corner[i].y(), corner[i].z()};
  return triangle;
}

// One thread's work on one chunk of candidates after the other.
class Sieve {
 public:
  Sieve(const TriangleSet& first, const TriangleSet& second, const NarrowPhaseOptions& options)
      : first_(first), second_(second), options_(options) {
    const auto margin = static_cast<float>(options.margin);
    margin_low_ = std::max(0.0F, std::nextafter(margin, 0.0F));
    margin_high_ = std::nextafter(margin, INFINITY);
  }

  void sift(std::span<const LeafPair> candidates, TriangleHits& hits,
            NarrowPhaseCounters& counters) {
    const NarrowPhaseKernels& kernels = narrow_phase_kernels();
    kernels.judge(pairs(candidates), margin_low_, margin_high_, verdict_.data());
    counters.judged += static_cast<std::int64_t>(candidates.size());
    // Here and in append(), every candidate is written and the place moves on where it counts: that
    // is as good as random, so a branch would be mispredicted as often as not.
    open_.resize(candidates.size());
    std::size_t open = 0;
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      open_[open] = candidates[k];
      open += needs_measuring(verdict_[k]) ? 1 : 0;
    }
    open_.resize(open);
    measure(counters);
    append(candidates, hits);
  }

 private:
  bool needs_measuring(Verdict verdict) const {
    return verdict == Verdict::undecided || (verdict == Verdict::near && options_.distances);
  }

  TrianglePairs pairs(std::span<const LeafPair> list) const {
    return {first_.positions.data()->data(),
            first_.triangles.data()->data(),
            second_.positions.data()->data(),
            second_.triangles.data()->data(),
            list.data(),
            static_cast<int>(list.size())};
  }

  // Settles what is open: verdicts and, where they are wanted, squared distances.
  void measure(NarrowPhaseCounters& counters) {
    if (open_.empty()) return;
    narrow_phase_kernels().measure(pairs(open_), options_.margin, open_verdict_.data(),
                                   squared_.data(), certain_.data());
    counters.measured += static_cast<std::int64_t>(open_.size());
    for (std::size_t k = 0; k < open_.size(); ++k) {
      const bool decided = open_verdict_[k] != Verdict::undecided;
      const bool wanted = options_.distances && open_verdict_[k] != Verdict::apart;
      if (decided && (certain_[k] || !wanted)) continue;
      ++counters.scalar;
      squared_[k] =
          squared_triangle_distance(corners(first_, open_[k].a), corners(second_, open_[k].b));
      if (decided) continue;
      const bool near = squared_[k] <= options_.margin * options_.margin;
      open_verdict_[k] = near ? Verdict::near : Verdict::apart;
    }
  }

  void append(std::span<const LeafPair> candidates, TriangleHits& hits) {
    std::size_t measured = 0;
    if (!open_.empty()) {
      for (std::size_t k = 0; k < candidates.size(); ++k)
        if (needs_measuring(verdict_[k])) verdict_[k] = open_verdict_[measured++];
    }
    std::size_t place = hits.pairs.size();
    hits.pairs.resize(place + candidates.size());
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      hits.pairs[place] = candidates[k];
      place += verdict_[k] == Verdict::near ? 1 : 0;
    }
    hits.pairs.resize(place);
    if (!options_.distances) return;
    // All that are near were measured.
    for (std::size_t k = 0; k < measured; ++k)
      if (open_verdict_[k] == Verdict::near) hits.distances.push_back(std::sqrt(squared_[k]));
  }

  const TriangleSet& first_;
  const TriangleSet& second_;
  const NarrowPhaseOptions& options_;
  float margin_low_ = 0, margin_high_ = 0;
  std::array<Verdict, chunk_size> verdict_{}, open_verdict_{};
  std::array<double, chunk_size> squared_{};
  std::array<bool, chunk_size> certain_{};
  std::vector<LeafPair> open_;
};

}  // namespace

void find_triangle_hits(const TriangleSet& first, const TriangleSet& second,
                        std::span<const LeafPair> candidates, const NarrowPhaseOptions& options,
                        TriangleHits& hits, NarrowPhaseCounters& counters) {
  assert(options.margin >= 0);
  const int chunks = static_cast<int>((candidates.size() + chunk_size - 1) / chunk_size);
  const auto chunk = [&](int c) {
    const std::size_t start = static_cast<std::size_t>(c) * chunk_size;
    return candidates.subspan(start, std::min<std::size_t>(chunk_size, candidates.size() - start));
  };
  const int threads =
      std::min(options.threads > 0 ? options.threads : omp_get_max_threads(), chunks);
  if (threads <= 1) {
    Sieve sieve(first, second, options);
    for (int c = 0; c < chunks; ++c) sieve.sift(chunk(c), hits, counters);
    return;
  }
  std::vector<TriangleHits> found(chunks);
  std::vector<NarrowPhaseCounters> cost(chunks);
#pragma omp parallel num_threads(threads)
  {
    Sieve sieve(first, second, options);
#pragma omp for schedule(dynamic)
    for (int c = 0; c < chunks; ++c) sieve.sift(chunk(c), found[c], cost[c]);
  }
  for (int c = 0; c < chunks; ++c) {
    hits.pairs.insert(hits.pairs.end(), found[c].pairs.begin(), found[c].pairs.end());
    hits.distances.insert(hits.distances.end(), found[c].distances.begin(),
                          found[c].distances.end());
    counters.judged += cost[c].judged;
    counters.measured += cost[c].measured;
    counters.scalar += cost[c].scalar;
  }
}

void find_triangle_intersections(const TriangleSet& first, const TriangleSet& second,
                                 std::span<const LeafPair> candidates, int threads,
                                 std::vector<TriangleMeeting>& meetings,
                                 NarrowPhaseCounters& counters) {
  TriangleHits hits;
  find_triangle_hits(first, second, candidates, {0, false, threads}, hits, counters);
  std::vector<TriangleIntersection> found(hits.pairs.size());
#pragma omp parallel for schedule(dynamic, 64) \
    num_threads(threads > 0 ? threads : omp_get_max_threads())
  for (std::size_t k = 0; k < found.size(); ++k) {
    const auto [a, b] = hits.pairs[k];
    found[k] = intersect_triangles(to_points(corners(first, a)), to_points(corners(second, b)));
  }
  // Distances can round to 0.
  for (std::size_t k = 0; k < found.size(); ++k)
    if (found[k].kind != IntersectionKind::none) meetings.push_back({hits.pairs[k], found[k]});
}

double squared_triangle_distance(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b) {
  if (triangles_meet(to_points(a), to_points(b))) return 0;
  double least = INFINITY;
  for (int i = 0; i < 3; ++i) {
    least = std::min(least, closest_vertex_triangle(a[i], b[0], b[1], b[2]).squared_distance);
    least = std::min(least, closest_vertex_triangle(b[i], a[0], a[1], a[2]).squared_distance);
    for (int j = 0; j < 3; ++j) {
      least = std::min(
          least, closest_edge_edge(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]).squared_distance);
    }
  }
  return least;
}

}  // namespace weft::bsi
