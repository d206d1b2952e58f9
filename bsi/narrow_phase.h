// The narrow phase in batches: selects the pairs of triangles within a margin and computes their
// distances.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "bsi/geometry_image.h"
#include "bsi/leaf_pair.h"
#include "bsi/pyramid.h"
#include "bsi/triangle_intersection.h"

namespace weft::bsi {

// The triangles of a body: the positions (m, finite) of its particles, and three particles per
// triangle.
struct TriangleSet {
  std::span<const Vec3> positions;
  std::span<const std::array<int, 3>> triangles;
};

struct NarrowPhaseOptions {
  double margin = 0;       // largest distance of a hit, m, >= 0
  bool distances = false;  // also compute the distances of hits
  int threads = 0;         // number of threads; 0: the default of OpenMP
};

// The pairs of triangles within the margin and, if requested, their distances (m; 0 if the
// triangles have a common point).
struct TriangleHits {
  std::vector<LeafPair> pairs;
  std::vector<double> distances;
};

// Numbers of pairs that reach each stage. `judged`: all pairs, in float32. `measured`: undecided
// pairs, and near pairs whose distance is requested, in float64. `scalar`: pairs that are still
// uncertain, by scalar functions.
struct NarrowPhaseCounters {
  std::int64_t judged = 0, measured = 0, scalar = 0;
};

// Appends to `hits` the pairs whose distance is at most the margin. Leaf `a` of a candidate is a
// triangle of `first`, leaf `b` one of `second`, which may be the same body. Hits are in the order
// of the candidates, for any number of threads and any instruction set.
//
// Verdicts are proved with bounds of their rounding (docs/theory.md, "The narrow phase"). A pair
// remains undecided in float64 if its distance is within rounding (about 1e-14 of the pair's size)
// of the margin. squared_triangle_distance() then decides. Distances agree with that function
// within 1e-12 of themselves plus 1e-15 of the pair's size. With AVX-512 a candidate takes about 15
// ns, and a hit 60 ns more if distances are requested (`weft bench narrow-phase`).
void find_triangle_hits(const TriangleSet& first, const TriangleSet& second,
                        std::span<const LeafPair> candidates, const NarrowPhaseOptions& options,
                        TriangleHits& hits, NarrowPhaseCounters& counters);

// The triangles of a body and its pyramid. Precondition: rebuild(), not rebuild_swept(), has built
// the pyramid from the positions of the triangles.
struct PyramidTriangles {
  const Pyramid& pyramid;
  TriangleSet triangles;
};

// Find the hits among pairs of leaf blocks, from a dual traversal (first function) or a self
// traversal (second function). Vertices are read block by block and in float32, which is a quarter
// faster than from a list of pairs. More pairs need float64 if the margin is not well above the
// rounding to float32 (2^-23 of the largest coordinate).
void find_triangle_hits(const PyramidTriangles& first, const PyramidTriangles& second,
                        std::span<const LeafBlockPair> candidates,
                        const NarrowPhaseOptions& options, TriangleHits& hits,
                        NarrowPhaseCounters& counters);
void find_triangle_hits(const PyramidTriangles& body, std::span<const LeafBlockPair> candidates,
                        const NarrowPhaseOptions& options, TriangleHits& hits,
                        NarrowPhaseCounters& counters);

struct TriangleMeeting {
  LeafPair pair;
  TriangleIntersection intersection;  // never of kind none
};

// Appends the pairs that have a common point, in the order of the candidates, with their
// intersections. Pairs and kinds of intersection are exact for coordinates as in
// exact_predicates.h. find_triangle_hits() with a margin of 0 selects pairs, which are then
// intersected one by one. `threads` as in NarrowPhaseOptions.
void find_triangle_intersections(const TriangleSet& first, const TriangleSet& second,
                                 std::span<const LeafPair> candidates, int threads,
                                 std::vector<TriangleMeeting>& meetings,
                                 NarrowPhaseCounters& counters);

// Returns the squared distance (m^2) of two triangles. It is 0 if they have a common point, which
// is decided exactly. Otherwise it is the smallest of six
// vertex-triangle and nine edge-edge distances, squared. Precondition: points as in proximity.h.
// Takes about 300 ns.
double squared_triangle_distance(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b);

}  // namespace weft::bsi
