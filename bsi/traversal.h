// Single, dual and self traversals of pyramids, which find the pairs of leaves that come near each
// other.
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
  // Distance (m) within which leaves count as near, >= 0 and finite.
  double margin = 0;
  Leaf leaf = Leaf::triangle;
  // Bounds other than `box` require the spheres of both pyramids (PyramidParts).
  Bound bound = Bound::box;
  // In a self traversal of a pyramid with PyramidParts::tangents, skip blocks that the tangent
  // certificate proves not to touch themselves or neighbouring blocks.
  bool certificate = true;
  // Number of threads; 0: the default of OpenMP. With several threads, the calling thread keeps
  // buffers of the size of its largest result.
  int threads = 0;
};

struct TraversalCounters {
  std::int64_t bound_tests = 0;        // pairs whose bounds are compared, absent children included
  std::int64_t certificate_tests = 0;  // blocks and rectangles of neighbouring blocks tested
  std::int64_t certified = 0;          // certificate tests that proved the absence of contact
};

// Returns half of the margin (m) in float32, increased to cover all rounding. If points of two
// float64 surfaces come within `margin`, the float32 boxes around them overlap when each is widened
// by the result. `magnitude_*` is Pyramid::magnitude() of the two bodies, m.
float half_margin(double margin, float magnitude_a, float magnitude_b);

// Returns an upper bound (m) of the distance between two boxes that overlap when each is widened by
// `half`. Along each axis the boxes are at most 2 `half` apart, plus the rounding of the four
// widened bounds. Spheres that are farther apart than the result cannot contain such boxes.
float sphere_reach(float half, float magnitude_a, float magnitude_b);

// Returns the distance (m) that the tangent certificate must prove. It is the margin plus an upper
// bound of the amount by which rounding can have shortened a distance.
double certificate_margin(double margin, float magnitude);

// The traversals of leaves find the pairs of leaves whose widened boxes overlap or touch. Self
// traversals leave out pairs that the certificate excludes, and pairs of triangles that share a
// particle. The bounds above the leaves do not change this result. The box of a leaf bounds its
// vertices rounded to float32, at both ends of the path in a swept pyramid. It is widened to
// low - h and high + h in float32, with h = half_margin(...). All pairs within the margin that are
// not left out are therefore found.
//
// Preconditions: the pyramids are built (Pyramid::is_built), each plain or swept. Results are
// appended, without repetition. Their order depends on the pyramids and the options, but not on the
// number of threads. Counters are increased. Thread-safe.

// Finds the leaves near a sphere around a point: all within `radius` + margin of the point (m), and
// possibly a few others. Preconditions: the point is finite and below Pyramid::coordinate_limit;
// `radius` is finite and >= 0.
void single_traversal(const Pyramid& pyramid, const Vec3& point, double radius,
                      const TraversalOptions& options, std::vector<int>& leaves,
                      TraversalCounters& counters);
// Finds the leaves near many points, as for one point. Appends pairs (index of the point, leaf),
// not ordered by point.
void single_traversal(const Pyramid& pyramid, std::span<const Vec3> points, double radius,
                      const TraversalOptions& options, std::vector<LeafPair>& pairs,
                      TraversalCounters& counters);

// Finds pairs (leaf of `first`, leaf of `second`).
void dual_traversal(const Pyramid& first, const Pyramid& second, const TraversalOptions& options,
                    std::vector<LeafPair>& pairs, TraversalCounters& counters);

// Finds unordered pairs of leaves of one body. Triangles: a < b, without pairs that share a
// particle. Quads: a <= b. Unless the certificate excludes them, neighbours are included, and so is
// each quad with itself, because a quad can fold.
//
// The certificate can exclude pairs of leaves within one block or in two neighbouring blocks. It
// proves that any two features (vertices, edges or triangles) of these leaves without a common
// vertex stay farther apart than the margin along their whole paths.
void self_traversal(const Pyramid& pyramid, const TraversalOptions& options,
                    std::vector<LeafPair>& pairs, TraversalCounters& counters);

// Find the same pairs in the same order, but store them as pairs of leaf blocks (see
// LeafBlockPair). The narrow phase reads this form fastest.
void dual_traversal(const Pyramid& first, const Pyramid& second, const TraversalOptions& options,
                    std::vector<LeafBlockPair>& blocks, TraversalCounters& counters);
void self_traversal(const Pyramid& pyramid, const TraversalOptions& options,
                    std::vector<LeafBlockPair>& blocks, TraversalCounters& counters);

// Finds pairs (leaf of `first`, leaf of `second`). `ends` holds the frame of the second body, or
// its frames at the start and the end of its path. The result is that for a pyramid rebuilt from
// the placed vertices R p + t: by rebuild() for one frame, by rebuild_swept() for two. The only
// difference is that half_margin() uses the magnitude of the placed box of the whole body.
void dual_traversal(const Pyramid& first, const RigidPyramid& second,
                    std::span<const RigidFrame> ends, const TraversalOptions& options,
                    std::vector<LeafPair>& pairs, TraversalCounters& counters);

std::size_t count_pairs(std::span<const LeafBlockPair> blocks);
// Convert pairs of leaf blocks to pairs of leaf indices and append these. The first overload takes
// the result of a dual traversal. The second takes the result of a self traversal and puts the
// smaller index of a pair first.
void append_pairs(const Pyramid& first, const Pyramid& second, Leaf leaf,
                  std::span<const LeafBlockPair> blocks, int threads, std::vector<LeafPair>& pairs);
void append_pairs(const Pyramid& pyramid, Leaf leaf, std::span<const LeafBlockPair> blocks,
                  int threads, std::vector<LeafPair>& pairs);

struct BlockPair {
  PatchBlock a, b;
  bool operator==(const BlockPair&) const = default;
};

// Approximate contact: find the pairs of blocks of one level whose widened bounds overlap. A patch
// without this level takes part with its last level. Pairs of whole patches are compared by boxes
// alone. options.leaf has no effect. A self traversal also pairs each block with itself, and
// returns each unordered pair once. It leaves out all pairs below a pair of blocks that the
// certificate excludes.
void dual_traversal_of_blocks(const Pyramid& first, const Pyramid& second, int level,
                              const TraversalOptions& options, std::vector<BlockPair>& pairs,
                              TraversalCounters& counters);
void self_traversal_of_blocks(const Pyramid& pyramid, int level, const TraversalOptions& options,
                              std::vector<BlockPair>& pairs, TraversalCounters& counters);

}  // namespace weft::bsi
