// The narrow phase in batches: selects the candidates within a margin and computes their distances.
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

// The triangles of a body: positions (m, finite) by particle, three particles per triangle.
struct TriangleSet {
  std::span<const Vec3> positions;
  std::span<const std::array<int, 3>> triangles;
};

struct NarrowPhaseOptions {
  double margin = 0;       // m, >= 0
  bool distances = false;  // also compute distances
  int threads = 0;         // 0: as many as OpenMP uses
};

// Pairs of triangles and, if requested, their distances (m; 0 if they have a common point).
struct TriangleHits {
  std::vector<LeafPair> pairs;
  std::vector<double> distances;
};

// Numbers of pairs that reach each stage. All pairs are judged in float32. Undecided pairs, and
// near ones whose distance is requested, are measured in float64. Pairs that are still uncertain go
// to scalar functions.
struct NarrowPhaseCounters {
  std::int64_t judged = 0, measured = 0, scalar = 0;
};

// Appends to `hits` the pairs (a of `first`, b of `second`, which may be the same body) whose
// distance is at most the margin. Hits are in the order of the candidates, for any number of
// threads and any instruction set.
//
// Every verdict is proved with bounds of its rounding (docs/theory.md, "The narrow phase"), with
// one exception. Where the distance is within rounding (1e-14 of the pair's size) of the margin,
// squared_triangle_distance() decides. Distances agree with that function within 1e-12 of
// themselves plus 1e-15 of the pair's size. With AVX-512 a candidate takes about 15 ns, and a hit
// 60 ns more if distances are requested (`weft bench narrow-phase`).
void find_triangle_hits(const TriangleSet& first, const TriangleSet& second,
                        std::span<const LeafPair> candidates, const NarrowPhaseOptions& options,
                        TriangleHits& hits, NarrowPhaseCounters& counters);

// The triangles of a body, and the pyramid built from the same positions by rebuild(), not by
// rebuild_swept().
struct PyramidTriangles {
  const Pyramid& pyramid;
  TriangleSet triangles;
};

// Find the same hits from candidates in the form of leaf-block pairs, as a dual traversal of two
// bodies or a self traversal returns them. Vertices are read block by block and in float32, which
// is a quarter faster. More pairs need float64 if the margin is not well above the rounding to
// float32 (2^-23 of the largest coordinate).
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
// intersections. Both are exact for coordinates as in exact_predicates.h. find_triangle_hits() with
// a margin of 0 selects the pairs, which are then intersected one by one. `threads` as in
// NarrowPhaseOptions.
void find_triangle_intersections(const TriangleSet& first, const TriangleSet& second,
                                 std::span<const LeafPair> candidates, int threads,
                                 std::vector<TriangleMeeting>& meetings,
                                 NarrowPhaseCounters& counters);

// Returns the squared distance of two triangles, m^2. It is 0 if they have a common point; that
// test is exact (coordinates as in exact_predicates.h). Otherwise it is the smallest of six
// vertex-triangle and nine edge-edge distances (proximity.h). Scalar: some 300 ns.
double squared_triangle_distance(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b);

}  // namespace weft::bsi
