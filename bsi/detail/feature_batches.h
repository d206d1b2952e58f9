// Vertex-triangle and edge-edge pairs in batches: distances, those within reach, and the paths that
// continuous collision must look at.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "bsi/geometry_image.h"

namespace weft::bsi {

// Which four points make a pair: as in closest_vertex_triangle and closest_edge_edge (proximity.h).
enum class FeatureKind { vertex_triangle, edge_edge };
using FourParticles = std::array<int, 4>;

// Everything below works on one thread, gives the same bits with every instruction set, and wants
// finite positions (m), by particle. Work on many threads by splitting `pairs`.

// The squared distances (m^2): those of the scalar functions within rounding (a distance within
// 1e-12 of itself and 1e-15 of the size of the pair). 12 ns a pair with AVX-512.
void squared_distances(FeatureKind kind, std::span<const Vec3> positions,
                       std::span<const FourParticles> pairs, std::span<double> squared_distance);

struct PairInReach {
  int pair = 0;         // its place in the list
  double distance = 0;  // m: no less on the paths
};

// Appends, in order, the pairs whose distance at `positions` is within `reach` plus `path`, with
// that distance less `path` (but not below 0). `path` is 0 where `path_lengths` is empty; else it
// is twice the longest of the four particles' (m, by particle), so that all pairs are kept that
// come within reach when every particle moves that far. 8 ns a pair that is out of reach.
void find_in_reach(FeatureKind kind, std::span<const Vec3> positions,
                   std::span<const double> path_lengths, std::span<const FourParticles> pairs,
                   double reach, std::vector<PairInReach>& in_reach);

// Appends, in order, the places of the pairs that are not proved, by one look at each, to stay
// further apart than `separation` on the straight paths start -> end and to end further apart than
// `end_separation` (m, >= separation >= 0). 11 ns a pair.
void find_unproved_paths(FeatureKind kind, std::span<const Vec3> start, std::span<const Vec3> end,
                         std::span<const FourParticles> pairs, double separation,
                         double end_separation, std::vector<int>& unproved);

// The safe fractions of continuous_collision.h, which is asked where the look above does not prove
// the path safe.
void safe_fractions(FeatureKind kind, std::span<const Vec3> start, std::span<const Vec3> end,
                    std::span<const FourParticles> pairs, double minimum_separation,
                    std::span<double> fraction);

}  // namespace weft::bsi
