// The narrow phase in batches: the candidates of a traversal that are near, and their distances.
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

// Pairs of triangles and, if requested, their distances (m; 0 if they have a point in common).
struct TriangleHits {
  std::vector<LeafPair> pairs;
  std::vector<double> distances;
};

// Numbers of pairs by the arithmetic they reached. All pairs are judged in float32. Pairs left open
// are measured in float64, and those still open by scalar functions.
struct NarrowPhaseCounters {
  std::int64_t judged = 0, measured = 0, scalar = 0;
};

// Appends to `hits` the pairs (a of `first`, b of `second`, which may be the same body) that are at
// most the margin apart. They keep the order of the candidates, for any number of threads and any
// instruction set.
//
// Every verdict is proved with bounds of its rounding (docs/theory.md, "The narrow phase"), with
// one exception. Where the distance is within rounding (1e-14 of the pair's size) of the margin,
// squared_triangle_distance() decides. Distances equal that function's within rounding (1e-12 of
// themselves and 1e-15 of the size of the pair). With AVX-512 a candidate takes about 15 ns, and a
// hit 60 ns more if distances are requested (`weft bench narrow-phase`).
void find_triangle_hits(const TriangleSet& first, const TriangleSet& second,
                        std::span<const LeafPair> candidates, const NarrowPhaseOptions& options,
                        TriangleHits& hits, NarrowPhaseCounters& counters);

// A body's triangles, and the pyramid built from their positions, not swept.
struct PyramidTriangles {
  const Pyramid& pyramid;
  TriangleSet triangles;
};

// Finds the same hits among the candidates that a dual traversal of the two bodies, or a self
// traversal, found as pairs of leaf blocks. Vertices are read block by block and in float32, which
// is a quarter faster. If the margin is not well above the rounding to float32 (2^-23 of the
// coordinates' size), more pairs are left to float64.
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

// Appends the pairs that have a point in common, in the order of the candidates, with their
// intersections. Both are exact for coordinates as in exact_predicates.h. The candidates are judged
// as above with a margin of 0; the remaining ones are intersected one by one.
void find_triangle_intersections(const TriangleSet& first, const TriangleSet& second,
                                 std::span<const LeafPair> candidates, int threads,
                                 std::vector<TriangleMeeting>& meetings,
                                 NarrowPhaseCounters& counters);

// Returns the squared distance of two triangles. It is 0 if they have a point in common, which is
// decided exactly (coordinates as in exact_predicates.h). Otherwise it is the least of six
// vertex-triangle and nine edge-edge distances (proximity.h). Scalar: some 300 ns.
double squared_triangle_distance(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b);

}  // namespace weft::bsi
