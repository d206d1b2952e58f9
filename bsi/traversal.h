// Which leaves come near what: single, dual and self traversal of box pyramids.
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
  // Metres, >= 0 and finite.
  double margin = 0;
  Leaf leaf = Leaf::triangle;
  // Every bound but `box` needs the spheres of both pyramids (PyramidParts).
  Bound bound = Bound::box;
  // Self traversal: leave out what the tangent certificate proves not to touch.
  bool certificate = true;
  // 0 means the threads of OpenMP. With more than one thread, the calling thread keeps as much
  // memory as its largest answer takes.
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

// Returns how far apart, in metres, boxes may lie that overlap when `half` widens them: twice the
// half along each axis, and what rounding the four widened bounds may add. Spheres are widened by
// it.
float sphere_reach(float half, float magnitude_a, float magnitude_b);

// Returns the distance, in metres, that the tangent certificate proves points of a body to keep:
// the margin and what rounding may have taken from it.
double certificate_margin(double margin, float magnitude);

// The leaves alone settle what is found, so that every implementation and every bound finds the
// same: all pairs of leaves whose widened boxes overlap or touch. The boxes bound the vertices
// rounded to float32, at both ends of the path in a swept pyramid. With h = half_margin(...) they
// are widened to low - h and high + h in float32. Every pair that comes within the margin is among
// them.
//
// The pyramids must be built (Pyramid::is_built), each plain or swept. Found leaves are appended in
// an order that depends on the pyramids and the bound, not on the number of threads, and none
// twice; counters are added to. Thread-safe.

// Finds the leaves near a point (a particle of some radius: radius + margin). The point must be
// finite and below Pyramid::coordinate_limit.
void single_traversal(const Pyramid& pyramid, const Vec3& point, double radius,
                      const TraversalOptions& options, std::vector<int>& leaves,
                      TraversalCounters& counters);
// Finds the leaves near many points. Appends pairs (number of the point, leaf), not in the order of
// the points. Runs on several threads, like the functions below.
void single_traversal(const Pyramid& pyramid, std::span<const Vec3> points, double radius,
                      const TraversalOptions& options, std::vector<LeafPair>& pairs,
                      TraversalCounters& counters);

// Finds pairs (leaf of the first, leaf of the second).
void dual_traversal(const Pyramid& first, const Pyramid& second, const TraversalOptions& options,
                    std::vector<LeafPair>& pairs, TraversalCounters& counters);

// Finds unordered pairs of leaves of one body. Triangles: a < b, those that share a particle left
// out. Quads: a <= b, neighbours and the quad with itself included, for a quad can fold.
//
// The certificate leaves out pairs in a block, or in two neighbouring ones, whose points are proved
// to stay farther apart than the margin, all along their paths. Points on triangles that share a
// vertex are excepted from the proof. Features (vertex and triangle, two edges) without a common
// vertex are then not within the margin.
void self_traversal(const Pyramid& pyramid, const TraversalOptions& options,
                    std::vector<LeafPair>& pairs, TraversalCounters& counters);

// These find the same pairs in the same order, but store them by pairs of leaf blocks, as they are
// found. Where bodies touch that takes a tenth of the memory, and the narrow phase is fastest on
// it.
void dual_traversal(const Pyramid& first, const Pyramid& second, const TraversalOptions& options,
                    std::vector<LeafBlockPair>& blocks, TraversalCounters& counters);
void self_traversal(const Pyramid& pyramid, const TraversalOptions& options,
                    std::vector<LeafBlockPair>& blocks, TraversalCounters& counters);

// Finds pairs (leaf of the first, leaf of the second) where the second has been moved rigidly: by
// one frame, or from the first of two to the second. They are those of a pyramid that is rebuilt
// from the vertices R p + t, at both ends of the path (swept), its magnitude being that of the
// placed box of the whole body.
void dual_traversal(const Pyramid& first, const RigidPyramid& second,
                    std::span<const RigidFrame> ends, const TraversalOptions& options,
                    std::vector<LeafPair>& pairs, TraversalCounters& counters);

std::size_t count_pairs(std::span<const LeafBlockPair> blocks);
// Appends the numbers of the leaves that a dual traversal found, or a self traversal, where the
// smaller one goes first.
void append_pairs(const Pyramid& first, const Pyramid& second, Leaf leaf,
                  std::span<const LeafBlockPair> blocks, int threads, std::vector<LeafPair>& pairs);
void append_pairs(const Pyramid& pyramid, Leaf leaf, std::span<const LeafBlockPair> blocks,
                  int threads, std::vector<LeafPair>& pairs);

struct BlockPair {
  PatchBlock a, b;
  bool operator==(const BlockPair&) const = default;
};

// Approximate contact: finds the pairs of blocks of one level whose widened boxes overlap. A patch
// that has no such level takes part with its last one. options.leaf has no effect. In a self
// traversal a block is paired with itself too, and unordered pairs come once.
void dual_traversal_of_blocks(const Pyramid& first, const Pyramid& second, int level,
                              const TraversalOptions& options, std::vector<BlockPair>& pairs,
                              TraversalCounters& counters);
void self_traversal_of_blocks(const Pyramid& pyramid, int level, const TraversalOptions& options,
                              std::vector<BlockPair>& pairs, TraversalCounters& counters);

}  // namespace weft::bsi
