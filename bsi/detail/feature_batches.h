// Tests of vertex-triangle and edge-edge pairs in batches, which find the pairs within reach and
// the paths that need the full continuous collision test.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "bsi/geometry_image.h"

namespace weft::bsi {

// The kind of a pair of features. A pair has four particles, in the order of the points of
// closest_vertex_triangle() or closest_edge_edge() (proximity.h).
enum class FeatureKind { vertex_triangle, edge_edge };
using FourParticles = std::array<int, 4>;

// All functions below run on one thread and give the same bits with every instruction set.
// Precondition: positions (m, by particle) are finite.

struct PairInReach {
  int pair = 0;         // index in `pairs`
  double distance = 0;  // m
};

// Appends, in order, each pair whose distance at `positions` is at most `reach`, m. 8 ns per pair
// out of reach.
void find_in_reach(FeatureKind kind, std::span<const Vec3> positions,
                   std::span<const FourParticles> pairs, double reach,
                   std::vector<PairInReach>& in_reach);
// Appends, in order, each pair that may come within `reach` (m) on the straight paths start -> end,
// with a lower bound of its distance along them. The bounds are close where the features do not
// turn about each other. 20 ns per pair.
void find_in_reach_on_paths(FeatureKind kind, std::span<const Vec3> start,
                            std::span<const Vec3> end, std::span<const FourParticles> pairs,
                            double reach, std::vector<PairInReach>& in_reach);

// Appends, in order, the indices of the pairs that a single test does not prove safe. A safe pair
// stays farther apart than `separation` on the straight paths start -> end. At the ends of the
// paths it is farther apart than `end_separation` (m, >= `separation` >= 0). 11 ns per pair.
void find_unproved_paths(FeatureKind kind, std::span<const Vec3> start, std::span<const Vec3> end,
                         std::span<const FourParticles> pairs, double separation,
                         double end_separation, std::vector<int>& unproved);

// Sets fraction[k] to the safe fraction of pair k, as defined in continuous_collision.h. The full
// test of that header runs only for pairs that find_unproved_paths() does not prove safe.
void safe_fractions(FeatureKind kind, std::span<const Vec3> start, std::span<const Vec3> end,
                    std::span<const FourParticles> pairs, double minimum_separation,
                    std::span<double> fraction);

}  // namespace weft::bsi
