#include "bsi/narrow_phase.h"

#include <omp.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "bsi/kernels/block_judge_kernels.h"
#include "bsi/proximity.h"

namespace weft::bsi {

namespace {

static_assert(sizeof(Vec3) == 3 * sizeof(double));

constexpr int chunk_blocks = 32;                         // pairs of leaf blocks per chunk
constexpr int candidates_per_chunk = 64 * chunk_blocks;  // candidates per chunk

std::array<Vec3, 3> corners(const TriangleSet& set, int triangle) {
  const auto& [i, j, k] = set.triangles[triangle];
  return {set.positions[i], set.positions[j], set.positions[k]};
}

Triangle3 to_points(const std::array<Vec3, 3>& corner) {
  Triangle3 triangle;
  for (int i = 0; i < 3; ++i) triangle[i] = {corner[i].x(), corner[i].y(), corner[i].z()};
  return triangle;
}

// The narrow phase on one thread. Each call of sift() processes one chunk of candidates.
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
    narrow_phase_kernels().judge(pairs(candidates), margin_low_, margin_high_, verdict_.data());
    settle(candidates, hits, counters);
  }

  // Processes the candidates in `blocks`. Precondition: at most chunk_blocks pairs of blocks.
  void sift(const Pyramid& first, const Pyramid& second, bool self,
            std::span<const LeafBlockPair> blocks, TriangleHits& hits,
            NarrowPhaseCounters& counters) {
    listed_.resize(candidates_per_chunk + 16);
    const JudgedBlocks judged{&first.tree(), &second.tree(), blocks.data(),
                              static_cast<int>(blocks.size()), self};
    // Upper bound (m) of the change of a pair's distance when its vertices are rounded to float32,
    // as in half_margin().
    const double rounding = 0x1p-23 * (static_cast<double>(first.magnitude()) +
                                       static_cast<double>(second.magnitude())) +
                            0x1p-124;
    const auto low = static_cast<float>(options_.margin - rounding);
    const auto high = static_cast<float>(options_.margin + rounding);
    const int count = block_judge_kernels().judge(
        judged, std::max(0.0F, std::nextafter(low, -INFINITY)), std::nextafter(high, INFINITY),
        listed_.data(), verdict_.data());
    settle({listed_.data(), static_cast<std::size_t>(count)}, hits, counters);
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

  std::size_t select(std::span<const LeafPair> candidates, Verdict wanted,
                     std::vector<LeafPair>& to) const {
    return static_cast<std::size_t>(
        block_judge_kernels().select(candidates.data(), verdict_.data(),
                                     static_cast<int>(candidates.size()), wanted, to.data()));
  }

  // Appends the hits among the candidates. verdict_ holds the float32 verdict of each candidate.
  void settle(std::span<const LeafPair> candidates, TriangleHits& hits,
              NarrowPhaseCounters& counters) {
    counters.judged += static_cast<std::int64_t>(candidates.size());
    open_.resize(candidates.size() + 8);
    std::size_t open = 0;
    if (options_.distances) {
      for (std::size_t k = 0; k < candidates.size(); ++k) {
        open_[open] = candidates[k];
        open += needs_measuring(verdict_[k]) ? 1 : 0;
      }
    } else {
      open = select(candidates, Verdict::undecided, open_);
    }
    open_.resize(open);
    measure(counters);
    append(candidates, hits);
  }

  // Determines the float64 verdicts of the candidates in open_ and, if requested, their squared
  // distances (m^2).
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
    near_.resize(candidates.size() + 8);
    const std::size_t near = select(candidates, Verdict::near, near_);
    hits.pairs.insert(hits.pairs.end(), near_.begin(),
                      near_.begin() + static_cast<std::ptrdiff_t>(near));
    if (!options_.distances) return;
    // With distances requested, every near pair is among the measured ones.
    for (std::size_t k = 0; k < measured; ++k)
      if (open_verdict_[k] == Verdict::near) hits.distances.push_back(std::sqrt(squared_[k]));
  }

  const TriangleSet& first_;
  const TriangleSet& second_;
  const NarrowPhaseOptions& options_;
  float margin_low_ = 0, margin_high_ = 0;
  // The array has extra entries because kernels write past the end.
  std::array<Verdict, candidates_per_chunk + 16> verdict_{};
  std::array<Verdict, candidates_per_chunk> open_verdict_{};
  std::array<double, candidates_per_chunk> squared_{};
  std::array<bool, candidates_per_chunk> certain_{};
  std::vector<LeafPair> open_, listed_, near_;
};

// Calls `sift` for each chunk of up to `size` candidates. Chunks are shared among threads. Appends
// the hits in the order of the candidates.
template <class Candidate, class Sift>
void sift_chunks(const TriangleSet& first, const TriangleSet& second,
                 std::span<const Candidate> candidates, std::size_t size,
                 const NarrowPhaseOptions& options, TriangleHits& hits,
                 NarrowPhaseCounters& counters, const Sift& sift) {
  assert(options.margin >= 0);
  const int chunks = static_cast<int>((candidates.size() + size - 1) / size);
  const auto chunk = [&](int c) {
    const std::size_t start = static_cast<std::size_t>(c) * size;
    return candidates.subspan(start, std::min(size, candidates.size() - start));
  };
  const int threads =
      std::min(options.threads > 0 ? options.threads : omp_get_max_threads(), chunks);
  if (threads <= 1) {
    Sieve sieve(first, second, options);
    for (int c = 0; c < chunks; ++c) sift(sieve, chunk(c), hits, counters);
    return;
  }
  std::vector<TriangleHits> found(chunks);
  std::vector<NarrowPhaseCounters> cost(chunks);
#pragma omp parallel num_threads(threads)
  {
    Sieve sieve(first, second, options);
#pragma omp for schedule(dynamic)
    for (int c = 0; c < chunks; ++c) sift(sieve, chunk(c), found[c], cost[c]);
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

void sift_blocks(const PyramidTriangles& first, const PyramidTriangles& second, bool self,
                 std::span<const LeafBlockPair> candidates, const NarrowPhaseOptions& options,
                 TriangleHits& hits, NarrowPhaseCounters& counters) {
  assert(first.pyramid.tree().swept == 0 && second.pyramid.tree().swept == 0);
  sift_chunks(first.triangles, second.triangles, candidates, chunk_blocks, options, hits, counters,
              [&](Sieve& sieve, std::span<const LeafBlockPair> chunk, TriangleHits& found,
                  NarrowPhaseCounters& cost) {
                sieve.sift(first.pyramid, second.pyramid, self, chunk, found, cost);
              });
}

}  // namespace

void find_triangle_hits(const TriangleSet& first, const TriangleSet& second,
                        std::span<const LeafPair> candidates, const NarrowPhaseOptions& options,
                        TriangleHits& hits, NarrowPhaseCounters& counters) {
  sift_chunks(first, second, candidates, candidates_per_chunk, options, hits, counters,
              [](Sieve& sieve, std::span<const LeafPair> chunk, TriangleHits& found,
                 NarrowPhaseCounters& cost) { sieve.sift(chunk, found, cost); });
}

void find_triangle_hits(const PyramidTriangles& first, const PyramidTriangles& second,
                        std::span<const LeafBlockPair> candidates,
                        const NarrowPhaseOptions& options, TriangleHits& hits,
                        NarrowPhaseCounters& counters) {
  sift_blocks(first, second, false, candidates, options, hits, counters);
}

void find_triangle_hits(const PyramidTriangles& body, std::span<const LeafBlockPair> candidates,
                        const NarrowPhaseOptions& options, TriangleHits& hits,
                        NarrowPhaseCounters& counters) {
  sift_blocks(body, body, true, candidates, options, hits, counters);
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
  // Pairs without a common point are dropped. Their distance can still round to 0.
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
