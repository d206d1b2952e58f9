// Which leaves come near what, found on the device: single, dual and self traversal of the pyramids
// of a ComputePyramid, breadth-first, many at once.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "bsi/traversal.h"
#include "gpu/compute_pyramid.h"

namespace weft::gpu {

using bsi::Leaf;

// A query of two bodies, or of one with itself (a == b).
struct PairQuery {
  int body_a = 0;
  int body_b = 0;
  double margin = 0;  // m, >= 0
  // For a body with itself: leave out what the tangent certificate proves not to touch; the body
  // must have been rebuilt with BodyImage::tangents.
  bool certificate = true;
  // Pairs of quads are left out that a plane proves to end farther apart than the margin and twice
  // the longest path of their corners. Fewer come back from the device.
  bool distance_filter = false;
};

struct Ball {
  Vec3 centre{0, 0, 0};  // m, finite and below bsi::Pyramid::coordinate_limit
  double radius = 0;     // m, >= 0
};

// A pair of leaves that a query found, in the atlas' numbers (triangle t belongs to quad t / 2).
// `a` and `b` belong to the query's bodies; for a body with itself a < b (quads: a <= b). For a
// ball, `query` and `a` are its number, and `b` is the leaf.
struct Candidate {
  std::uint32_t query = 0;
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  bool operator==(const Candidate&) const = default;
};

// The candidates are those of the traversals of bsi/ (bsi/traversal.h) that the filter of the query
// leaves, in any order.
//
// A search makes one dispatch for every level of the deepest pyramid, and one for the leaves. Only
// the lengths of the lists and the candidates come back. A list that outgrew its memory is enlarged
// and the work done again, so that nothing is lost. Memory is kept from call to call.
//
// All functions make the context current on the calling thread, and throw std::runtime_error with
// the reason when OpenGL fails (memory, a buffer beyond what the device allows).
class ComputeTraversal {
 public:
  // The pyramids must outlive this. Every bound but `box` needs the spheres of all bodies asked for
  // (BodyImage::spheres).
  explicit ComputeTraversal(ComputePyramid& pyramids, bsi::Bound bound = bsi::Bound::box);
  ~ComputeTraversal();
  ComputeTraversal(const ComputeTraversal&) = delete;
  ComputeTraversal& operator=(const ComputeTraversal&) = delete;

  // Runs dual and self traversals. The span is valid until the next call.
  std::span<const Candidate> find_pairs(std::span<const PairQuery> queries, Leaf leaf);
  // Runs single traversals of one body.
  std::span<const Candidate> find_leaves(int body, std::span<const Ball> balls, double margin,
                                         Leaf leaf);
  // Returns how often lists were enlarged and the work done again, since this was made.
  int reruns() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::gpu
