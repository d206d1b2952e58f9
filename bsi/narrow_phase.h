// The narrow phase in batches: which of a traversal's candidates are near, and how near.
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
  bool distances = false;  // wanted too
  int threads = 0;         // 0: those of OpenMP
};

// Pairs of triangles, and the distance of each (m; 0 where they have a point in common) if wanted.
struct TriangleHits {
  std::vector<LeafPair> pairs;
  std::vector<double> distances;
};

// Numbers of pairs by arithmetic. All pairs are judged in float32. Pairs left open are measured
// in float64, and those still open by the scalar functions.
struct NarrowPhaseCounters {
  std::int64_t judged = 0, measured = 0, scalar = 0;
};

// Appends to `hits` the pairs (a of `first`, b of `second`, which may be the same) that are no more
// than the margin apart, in the order of the candidates, and so the same for every number of
// threads and every instruction set.
//
// Every verdict is proved with bounds of its rounding (docs/theory.md, "The narrow phase"), but for
// pairs whose distance is within rounding (1e-14 of their size) of the margin: there the result is
// that of squared_triangle_distance(). Distances are that function's within rounding (1e-12 of
// themselves and 1e-15 of the size of the pair). With AVX-512 it takes about 15 ns per candidate,
// and 60 ns more per hit if distances are wanted (`weft bench narrow-phase`).
void find_triangle_hits(const TriangleSet& first, const TriangleSet& second,
                        std::span<const LeafPair> candidates, const NarrowPhaseOptions& options,
                        TriangleHits& hits, NarrowPhaseCounters& counters);

// A body's triangles with the pyramid that was built of these positions, not swept.
struct PyramidTriangles {
  const Pyramid& pyramid;
  TriangleSet triangles;
};

// These find the same hits among the candidates between leaf blocks that a dual traversal of the
// two bodies, or a self traversal, found. Vertices are read a block at a time, and from float32: a
// quarter faster. Where rounding to float32 (2^-23 of the coordinates' size) is not far below the
// margin, more pairs are left to float64.
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

// Appends the pairs that have a point in common, in the order of the candidates, with what they
// have in common. Both are exact, for coordinates as in exact_predicates.h. The candidates are
// sifted as above with a margin of 0, and those that are left are intersected one by one.
void find_triangle_intersections(const TriangleSet& first, const TriangleSet& second,
                                 std::span<const LeafPair> candidates, int threads,
                                 std::vector<TriangleMeeting>& meetings,
                                 NarrowPhaseCounters& counters);

// Returns the squared distance of two triangles. It is 0 where they have a point in common, which
// is decided exactly (coordinates as in exact_predicates.h). Otherwise it is the least of the six
// of a vertex and a triangle and the nine of two edges (proximity.h). Scalar: some 300 ns.
double squared_triangle_distance(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b);

}  // namespace weft::bsi
