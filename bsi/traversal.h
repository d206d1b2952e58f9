// Single, dual and self traversal of pyramids: find pairs of leaves that come near each other.
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
  // In a self traversal, skip blocks that the tangent certificate proves not to touch themselves or
  // their neighbours.
  bool certificate = true;
  // Number of threads; 0: as many as OpenMP uses. With several threads, the calling thread keeps
  // the memory of its largest result.
  int threads = 0;
};

struct TraversalCounters {
  std::int64_t bound_tests = 0;        // pairs of spheres or boxes compared
  std::int64_t certificate_tests = 0;  // blocks and windows of neighbouring blocks tested
  std::int64_t certified = 0;          // number of these tests that proved the absence of contact
};

// Returns half of the margin in float32, increased to cover all rounding. If points of the float64
// surfaces come within `margin` of each other, their float32 boxes overlap when each is widened by
// the result. `magnitude_*` is Pyramid::magnitude() of the two bodies, m.
float half_margin(double margin, float magnitude_a, float magnitude_b);

// Returns an upper bound (m) of the distance between two boxes that overlap when each is widened by
// `half`. Along each axis the gap is at most 2 `half`, plus the rounding of the four widened
// bounds. Spheres farther apart than the result contain no such boxes.
float sphere_reach(float half, float magnitude_a, float magnitude_b);

// Returns the distance (m) that the tangent certificate must prove: the margin plus the largest
// amount by which rounding can have shortened a distance.
double certificate_margin(double margin, float magnitude);

// All traversals find the pairs of leaves whose widened boxes overlap or touch. (Self traversals
// leave out those that the certificate excludes.) The bounds above the leaves do not change this
// result. The box of a leaf bounds its vertices rounded to float32, at both ends of the path in a
// swept pyramid. It is widened to low - h and high + h in float32, with h = half_margin(...). Every
// pair within the margin is therefore found.
//
// Preconditions: the pyramids are built (Pyramid::is_built), each plain or swept. Results are
// appended, without repetition. Their order depends on the pyramids and the bound, not on the
// number of threads. Counters are increased. Thread-safe.

// Finds the leaves within radius + margin of a point. Precondition: the point is finite and below
// Pyramid::coordinate_limit.
void single_traversal(const Pyramid& pyramid, const Vec3& point, double radius,
                      const TraversalOptions& options, std::vector<int>& leaves,
                      TraversalCounters& counters);
// Finds the leaves near many points. Appends pairs (index of the point, leaf), not ordered by
// point. Runs on several threads, like the functions below.
void single_traversal(const Pyramid& pyramid, std::span<const Vec3> points, double radius,
                      const TraversalOptions& options, std::vector<LeafPair>& pairs,
                      TraversalCounters& counters);

// Finds pairs (leaf of `first`, leaf of `second`).
void dual_traversal(const Pyramid& first, const Pyramid& second, const TraversalOptions& options,
                    std::vector<LeafPair>& pairs, TraversalCounters& counters);

// Finds unordered pairs of leaves of one body. Triangles: a < b, without pairs that share a
// particle. Quads: a <= b, including neighbours and each quad with itself, because a quad can fold.
//
// The certificate skips pairs within one block or between two neighbouring blocks. It proves that
// their points stay farther apart than the margin along their whole paths, except points on
// triangles with a common vertex. Skipped features (vertex and triangle, two edges) without a
// common vertex are therefore not within the margin.
void self_traversal(const Pyramid& pyramid, const TraversalOptions& options,
                    std::vector<LeafPair>& pairs, TraversalCounters& counters);

// Find the same pairs in the same order, but store them as pairs of leaf blocks. Where bodies
// touch, this form takes a tenth of the memory. The narrow phase reads it fastest.
void dual_traversal(const Pyramid& first, const Pyramid& second, const TraversalOptions& options,
                    std::vector<LeafBlockPair>& blocks, TraversalCounters& counters);
void self_traversal(const Pyramid& pyramid, const TraversalOptions& options,
                    std::vector<LeafBlockPair>& blocks, TraversalCounters& counters);

// Finds pairs (leaf of `first`, leaf of `second`). `ends` holds the frame of the second body, or
// its frames at the start and the end of its path. The result is that of a pyramid rebuilt from the
// placed vertices R p + t, plain for one frame and swept for two. half_margin() uses the magnitude
// of the placed box of the whole body.
void dual_traversal(const Pyramid& first, const RigidPyramid& second,
                    std::span<const RigidFrame> ends, const TraversalOptions& options,
                    std::vector<LeafPair>& pairs, TraversalCounters& counters);

std::size_t count_pairs(std::span<const LeafBlockPair> blocks);
// Convert pairs of leaf blocks to pairs of leaf numbers and append these. The first overload takes
// the result of a dual traversal, the second that of a self traversal, whose pairs get the smaller
// number first.
void append_pairs(const Pyramid& first, const Pyramid& second, Leaf leaf,
                  std::span<const LeafBlockPair> blocks, int threads, std::vector<LeafPair>& pairs);
void append_pairs(const Pyramid& pyramid, Leaf leaf, std::span<const LeafBlockPair> blocks,
                  int threads, std::vector<LeafPair>& pairs);

struct BlockPair {
  PatchBlock a, b;
  bool operator==(const BlockPair&) const = default;
};

// Approximate contact: find the pairs of blocks of one level whose widened boxes overlap. A patch
// without this level takes part with its last one. options.leaf has no effect. A self traversal
// also pairs each block with itself, and returns each unordered pair once.
void dual_traversal_of_blocks(const Pyramid& first, const Pyramid& second, int level,
                              const TraversalOptions& options, std::vector<BlockPair>& pairs,
                              TraversalCounters& counters);
void self_traversal_of_blocks(const Pyramid& pyramid, int level, const TraversalOptions& options,
                              std::vector<BlockPair>& pairs, TraversalCounters& counters);

}  // namespace weft::bsi
