// Which leaves come near what: single, dual and self traversal of box pyramids.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bsi/leaf_pair.h"
#include "bsi/pyramid.h"

namespace weft::bsi {

struct TraversalOptions {
  // Metres, >= 0 and finite.
  double margin = 0;
  Leaf leaf = Leaf::triangle;
  // What is not `box` needs the spheres of both pyramids (PyramidParts).
  Bound bound = Bound::box;
  // Self traversal: leave out what the tangent certificate proves not to touch.
  bool certificate = true;
  // 0: those of OpenMP. Beyond one, the calling thread keeps as much memory as its largest answer.
  int threads = 0;
};

struct TraversalCounters {
  std::int64_t bound_tests = 0;        // pairs of spheres or boxes looked at
  std::int64_t certificate_tests = 0;  // blocks and windows of neighbouring blocks looked at
  std::int64_t certified = 0;          // of these, left out
};

// Half of the margin in float32, widened so that boxes of rounded vertices, each widened by it,
// overlap where the points of the float64 surfaces come within `margin` of each other, whatever the
// rounding. `magnitude_*`: Pyramid::magnitude of the two, m.
float half_margin(double margin, float magnitude_a, float magnitude_b);

// Boxes that overlap when `half` widens them lie apart by no more than this, m: twice the half
// along each axis, and what rounding the four widened bounds may add. By so much spheres are
// widened.
float sphere_reach(float half, float magnitude_a, float magnitude_b);

// The distance that the tangent certificate proves points of a body to keep: the margin and what
// rounding may have taken from it, m.
double certificate_margin(double margin, float magnitude);

// What is found is settled by the leaves alone, so that every implementation and every bound finds
// the same: pairs
// of leaves whose boxes (of the vertices rounded to float32, at both ends of the path in a swept
// pyramid), widened by h = half_margin(...) to low - h and high + h in float32, overlap or touch.
// Every pair that comes within the margin is among them.
//
// The pyramids must be built (Pyramid::is_built), plain or swept each. Found leaves are
// appended in an order that depends on the pyramids and the bound, not on the number of threads,
// none twice; counters are added to. Thread-safe.

// Leaves near a point (a particle of some radius: radius + margin). The point must be finite and
// below Pyramid::coordinate_limit.
void single_traversal(const Pyramid& pyramid, const Vec3& point, double radius,
                      const TraversalOptions& options, std::vector<int>& leaves,
                      TraversalCounters& counters);
// The same for many points: pairs (number of the point, leaf), not in the order of the points. On
// several threads, like what follows.
void single_traversal(const Pyramid& pyramid, std::span<const Vec3> points, double radius,
                      const TraversalOptions& options, std::vector<LeafPair>& pairs,
                      TraversalCounters& counters);

// Pairs (leaf of the first, leaf of the second).
void dual_traversal(const Pyramid& first, const Pyramid& second, const TraversalOptions& options,
                    std::vector<LeafPair>& pairs, TraversalCounters& counters);

// Unordered pairs of leaves of one body. Triangles: a < b, those that share a particle left out.
// Quads: a <= b, neighbours and the quad with itself included, for a quad can fold. With the
// certificate, pairs are left out that lie in a block, or in two neighbouring ones, whose points
// are proved to stay farther apart than the margin, all along their paths, except on triangles that
// share a vertex: features (vertex and triangle, two edges) without a common vertex are then not
// within the margin.
void self_traversal(const Pyramid& pyramid, const TraversalOptions& options,
                    std::vector<LeafPair>& pairs, TraversalCounters& counters);

// The same pairs, in the same order, as they are found, by pairs of leaf blocks: where bodies touch
// they take a tenth of the memory, and the narrow phase likes them best.
void dual_traversal(const Pyramid& first, const Pyramid& second, const TraversalOptions& options,
                    std::vector<LeafBlockPair>& blocks, TraversalCounters& counters);
void self_traversal(const Pyramid& pyramid, const TraversalOptions& options,
                    std::vector<LeafBlockPair>& blocks, TraversalCounters& counters);

std::size_t count_pairs(std::span<const LeafBlockPair> blocks);
// Appends the numbers of the leaves that a dual traversal found; or a self traversal, the smaller
// one first.
void append_pairs(const Pyramid& first, const Pyramid& second, Leaf leaf,
                  std::span<const LeafBlockPair> blocks, int threads, std::vector<LeafPair>& pairs);
void append_pairs(const Pyramid& pyramid, Leaf leaf, std::span<const LeafBlockPair> blocks,
                  int threads, std::vector<LeafPair>& pairs);

struct BlockPair {
  PatchBlock a, b;
  bool operator==(const BlockPair&) const = default;
};

// Approximate contact: the pairs of blocks of one level (of its last level, for a patch that has no
// such level) whose widened boxes overlap. options.leaf counts for nothing. In a self traversal a
// block is paired with itself too, and unordered pairs come once.
void dual_traversal_of_blocks(const Pyramid& first, const Pyramid& second, int level,
                              const TraversalOptions& options, std::vector<BlockPair>& pairs,
                              TraversalCounters& counters);
void self_traversal_of_blocks(const Pyramid& pyramid, int level, const TraversalOptions& options,
                              std::vector<BlockPair>& pairs, TraversalCounters& counters);

}  // namespace weft::bsi
