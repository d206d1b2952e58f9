// Pairs of leaves that come near each other: single, dual and self traversal of box pyramids.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bsi/leaf_pair.h"
#include "bsi/pyramid.h"
#include "bsi/rigid_pyramid.h"

namespace weft::bsi {

struct TraversalOptions {
  // Distance within which leaves count as near, m, >= 0 and finite.
  double margin = 0;
  Leaf leaf = Leaf::triangle;
  // Every bound but `box` needs the spheres of both pyramids (PyramidParts).
  Bound bound = Bound::box;
  // Self traversal: skip blocks that the tangent certificate proves not to touch themselves or
  // their neighbours.
  bool certificate = true;
  // 0: as many threads as OpenMP uses. With several threads, the calling thread keeps the memory of
  // its largest result.
  int threads = 0;
};

struct TraversalCounters {
  std::int64_t bound_tests = 0;        // pairs of spheres or boxes compared
  std::int64_t certificate_tests = 0;  // blocks and windows of neighbouring blocks tested
  std::int64_t certified = 0;          // of these, skipped
};

// Returns half of the margin in float32, rounded up to cover all rounding. Boxes of float32
// vertices, each widened by it, overlap if points of the float64 surfaces come within `margin` of
// each other. `magnitude_*` is Pyramid::magnitude of the two, m.
float half_margin(double margin, float magnitude_a, float magnitude_b);

// Returns the largest distance (m) between boxes that overlap when widened by `half`: twice `half`
// along each axis, plus the rounding of the four widened bounds. Spheres are widened by it.
float sphere_reach(float half, float magnitude_a, float magnitude_b);

// Returns the distance (m) that the tangent certificate must prove: the margin plus the most that
// rounding may have taken from a distance.
double certificate_margin(double margin, float magnitude);

// The leaves alone decide the result, so every implementation and every bound finds the same: all
// pairs of leaves whose widened boxes overlap or touch. The boxes bound the vertices rounded to
// float32, at both ends of the path in a swept pyramid. With h = half_margin(...) they are widened
// to low - h and high + h in float32. Every pair within the margin is among them.
//
// Preconditions: the pyramids are built (Pyramid::is_built), each plain or swept. Leaves are
// appended without repetition. Their order depends on the pyramids and the bound, not on the number
// of threads. Counters are added to. Thread-safe.

// Finds the leaves near a point, that is within radius + margin. Precondition: the point is finite
// and below Pyramid::coordinate_limit.
void single_traversal(const Pyramid& pyramid, const Vec3& point, double radius,
                      const TraversalOptions& options, std::vector<int>& leaves,
                      TraversalCounters& counters);
// Finds the leaves near many points. Appends pairs (number of the point, leaf), not ordered by
// point. Runs on several threads, like the functions below.
void single_traversal(const Pyramid& pyramid, std::span<const Vec3> points, double radius,
                      const TraversalOptions& options, std::vector<LeafPair>& pairs,
                      TraversalCounters& counters);

// Finds pairs (leaf of the first, leaf of the second).
void dual_traversal(const Pyramid& first, const Pyramid& second, const TraversalOptions& options,
                    std::vector<LeafPair>& pairs, TraversalCounters& counters);

// Finds unordered pairs of leaves of one body. Triangles: a < b, without those that share a
// particle. Quads: a <= b, with neighbours and each quad with itself, because a quad can fold.
//
// The certificate skips pairs in one block, or in two neighbouring ones, whose points are proved to
// stay farther apart than the margin, all along their paths. The proof excepts points on triangles
// that share a vertex. Features (vertex and triangle, two edges) without a common vertex are then
// not within the margin.
void self_traversal(const Pyramid& pyramid, const TraversalOptions& options,
                    std::vector<LeafPair>& pairs, TraversalCounters& counters);

// Finds the same pairs in the same order, but stores them as pairs of leaf blocks. Where bodies
// touch, this takes a tenth of the memory, and the narrow phase reads it fastest.
void dual_traversal(const Pyramid& first, const Pyramid& second, const TraversalOptions& options,
                    std::vector<LeafBlockPair>& blocks, TraversalCounters& counters);
void self_traversal(const Pyramid& pyramid, const TraversalOptions& options,
                    std::vector<LeafBlockPair>& blocks, TraversalCounters& counters);

// Finds pairs (leaf of the first, leaf of the second). The second is placed by one frame, or moves
// from the first of two frames to the second. The result is that of a pyramid rebuilt from the
// vertices R p + t, at both ends of the path (swept). Its magnitude is that of the placed box of
// the whole body.
void dual_traversal(const Pyramid& first, const RigidPyramid& second,
                    std::span<const RigidFrame> ends, const TraversalOptions& options,
                    std::vector<LeafPair>& pairs, TraversalCounters& counters);

std::size_t count_pairs(std::span<const LeafBlockPair> blocks);
// Appends the numbers of the leaves that a dual traversal found or, in the second overload, a self
// traversal. The latter puts the smaller number first.
void append_pairs(const Pyramid& first, const Pyramid& second, Leaf leaf,
                  std::span<const LeafBlockPair> blocks, int threads, std::vector<LeafPair>& pairs);
void append_pairs(const Pyramid& pyramid, Leaf leaf, std::span<const LeafBlockPair> blocks,
                  int threads, std::vector<LeafPair>& pairs);

struct BlockPair {
  PatchBlock a, b;
  bool operator==(const BlockPair&) const = default;
};

// Approximate contact: finds the pairs of blocks of one level whose widened boxes overlap. A patch
// without this level takes part with its last one. options.leaf has no effect. A self traversal
// also pairs each block with itself, and gives unordered pairs once.
void dual_traversal_of_blocks(const Pyramid& first, const Pyramid& second, int level,
                              const TraversalOptions& options, std::vector<BlockPair>& pairs,
                              TraversalCounters& counters);
void self_traversal_of_blocks(const Pyramid& pyramid, int level, const TraversalOptions& options,
                              std::vector<BlockPair>& pairs, TraversalCounters& counters);

}  // namespace weft::bsi
