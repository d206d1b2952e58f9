// Single, dual and self traversal of the pyramids of a ComputePyramid on the device: breadth-first,
// for many queries at once.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "bsi/traversal.h"
#include "gpu/compute_pyramid.h"

namespace weft::gpu {

using bsi::Leaf;

// A query of two bodies, or of one body with itself (body_a == body_b).
struct PairQuery {
  int body_a = 0;
  int body_b = 0;
  double margin = 0;  // m, >= 0
  // For body_a == body_b: skip pairs that the tangent certificate proves not to touch. The body
  // must have been rebuilt with BodyImage::tangents.
  bool certificate = true;
  // Skip pairs of quads that a plane proves to be too far apart at the ends of their paths: farther
  // than the margin plus twice the longest path of their corners. Fewer candidates are then copied
  // to the host.
  bool distance_filter = false;
};

struct Ball {
  Vec3 centre{0, 0, 0};  // m, finite and below bsi::Pyramid::coordinate_limit
  double radius = 0;     // m, >= 0
};

// A pair of leaves that a query found, in the numbers of the atlas (triangle t belongs to quad t /
// 2). `a` is a leaf of body_a and `b` a leaf of body_b. Within one body a < b for triangles and a
// <= b for quads. For a ball, `query` and `a` are the ball's number, and `b` is the leaf.
struct Candidate {
  std::uint32_t query = 0;
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  bool operator==(const Candidate&) const = default;
};

// Traversals on the device. The candidates are those of bsi/traversal.h that pass the query's
// filter, in any order. A device that does not round like the CPU may also find pairs that only the
// CPU's tangent certificate excludes.
//
// A search makes one dispatch for the leaves, and one per level of the queried bodies: the most
// levels of groups plus the most levels of a patch. Only the lengths of the lists and the
// candidates are copied to the host. If a list outgrows its memory, the list is enlarged and the
// search repeated, so that no candidate is lost. Memory is kept between calls.
//
// The constructor and the searches make the context current on the calling thread. They throw
// std::runtime_error with the reason if OpenGL fails, has no memory, or limits a buffer to less
// than its list needs.
class ComputeTraversal {
 public:
  // The pyramids must outlive this object. Every bound except `box` needs the spheres of all
  // queried bodies (BodyImage::spheres).
  explicit ComputeTraversal(ComputePyramid& pyramids, bsi::Bound bound = bsi::Bound::box);
  ~ComputeTraversal();
  ComputeTraversal(const ComputeTraversal&) = delete;
  ComputeTraversal& operator=(const ComputeTraversal&) = delete;

  // Runs dual and self traversals of bodies. The span is valid until the next search.
  std::span<const Candidate> find_pairs(std::span<const PairQuery> queries, Leaf leaf);
  // Runs single traversals of one body, one per ball. Finds all leaves within radius + margin (m)
  // of the ball's centre, and possibly a few others near it. The span is valid until the next
  // search.
  std::span<const Candidate> find_leaves(int body, std::span<const Ball> balls, double margin,
                                         Leaf leaf);
  // Returns the number of pairs of blocks, including blocks of groups, in the lists of the latest
  // search.
  std::size_t pairs_followed() const;
  // Returns the number of repetitions of searches since construction.
  int reruns() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::gpu
