// Vertex-triangle and edge-edge pairs in batches: finds pairs within reach, and paths that need the
// full continuous collision test.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "bsi/geometry_image.h"

namespace weft::bsi {

// The kind of a pair of features. Each pair has four points, in the order of
// closest_vertex_triangle() or closest_edge_edge() (proximity.h).
enum class FeatureKind { vertex_triangle, edge_edge };
using FourParticles = std::array<int, 4>;

// All functions below run on one thread and give the same bits with every instruction set.
// Precondition: positions (m, by particle) are finite. Callers with several threads split `pairs`.

struct PairInReach {
  int pair = 0;         // index in the list of pairs
  double distance = 0;  // m, lower bound along the paths
};

// Appends, in order, each pair whose distance at `positions` is at most `reach` + `path`, with
// distance - path (at least 0) as PairInReach::distance. `path` is twice the longest path length
// (m, by particle) of the four particles, or 0 if `path_lengths` is empty. The result therefore
// includes every pair that can come within `reach` when particles move no farther than their path
// lengths. 8 ns per pair out of reach.
void find_in_reach(FeatureKind kind, std::span<const Vec3> positions,
                   std::span<const double> path_lengths, std::span<const FourParticles> pairs,
                   double reach, std::vector<PairInReach>& in_reach);

// Appends, in order, the indices of the pairs that a single test does not prove safe. A safe pair
// stays farther apart than `separation` on the straight paths start -> end, and ends farther apart
// than `end_separation` (m, >= separation >= 0). 11 ns per pair.
void find_unproved_paths(FeatureKind kind, std::span<const Vec3> start, std::span<const Vec3> end,
                         std::span<const FourParticles> pairs, double separation,
                         double end_separation, std::vector<int>& unproved);

// Computes fraction[k], the safe fraction of pair k as defined in continuous_collision.h. The
// functions of that header run only if find_unproved_paths() does not prove the path safe.
void safe_fractions(FeatureKind kind, std::span<const Vec3> start, std::span<const Vec3> end,
                    std::span<const FourParticles> pairs, double minimum_separation,
                    std::span<double> fraction);

}  // namespace weft::bsi
