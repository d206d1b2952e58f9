#include "bsi/detail/feature_batches.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "bsi/continuous_collision.h"
#include "bsi/kernels/feature_kernels.h"
#include "bsi/proximity.h"

namespace weft::bsi {

namespace {

constexpr std::size_t pairs_per_chunk = 512;

FeatureBatch batch_of(std::span<const Vec3> positions, std::span<const FourParticles> pairs) {
  static_assert(sizeof(FourParticles) == sizeof(int[4]));
  return {positions.data()->data(), reinterpret_cast<const int(*)[4]>(pairs.data()),
          static_cast<int>(pairs.size())};
}

FourPoints points_of(std::span<const Vec3> x, const FourParticles& particles) {
  return {x[particles[0]], x[particles[1]], x[particles[2]], x[particles[3]]};
}

// Calls body(first, part) for every chunk of the pairs. `first` is the index of the chunk's first
// pair.
template <class Body>
void for_chunks(std::span<const FourParticles> pairs, const Body& body) {
  for (std::size_t first = 0; first < pairs.size(); first += pairs_per_chunk)
    body(first, pairs.subspan(first, std::min(pairs_per_chunk, pairs.size() - first)));
}

// The squared distances (m^2) of a chunk of pairs.
struct Measured {
  std::array<double, pairs_per_chunk> squared_distance;

  void measure(FeatureKind kind, std::span<const Vec3> positions,
               std::span<const FourParticles> pairs) {
    std::array<bool, pairs_per_chunk> certain;
    feature_kernels().measure[static_cast<int>(kind)](batch_of(positions, pairs),
                                                      squared_distance.data(), certain.data());
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      if (certain[k]) continue;
      const auto [x0, x1, x2, x3] = points_of(positions, pairs[k]);
      squared_distance[k] =
          (kind == FeatureKind::vertex_triangle ? closest_vertex_triangle(x0, x1, x2, x3)
                                                : closest_edge_edge(x0, x1, x2, x3))
              .squared_distance;
    }
  }
};

}  // namespace

void find_in_reach(FeatureKind kind, std::span<const Vec3> positions,
                   std::span<const FourParticles> pairs, double reach,
                   std::vector<PairInReach>& in_reach) {
  assert(reach >= 0);
  const float reach_above = std::nextafter(static_cast<float>(reach), INFINITY);
  std::array<bool, pairs_per_chunk> apart;
  std::vector<FourParticles> left;
  std::vector<int> place;
  Measured measured;
  for_chunks(pairs, [&](std::size_t first, std::span<const FourParticles> part) {
    feature_kernels().find_apart[static_cast<int>(kind)](batch_of(positions, part), reach_above,
                                                         apart.data());
    left.clear();
    place.clear();
    for (std::size_t k = 0; k < part.size(); ++k) {
      if (apart[k]) continue;
      left.push_back(part[k]);
      place.push_back(static_cast<int>(first + k));
    }
    if (left.empty()) return;
    measured.measure(kind, positions, left);
    for (std::size_t k = 0; k < left.size(); ++k) {
      if (!(measured.squared_distance[k] <= reach * reach)) continue;
      in_reach.push_back({place[k], std::sqrt(measured.squared_distance[k])});
    }
  });
}

void find_in_reach_on_paths(FeatureKind kind, std::span<const Vec3> start,
                            std::span<const Vec3> end, std::span<const FourParticles> pairs,
                            double reach, std::vector<PairInReach>& in_reach) {
  assert(reach >= 0);
  std::array<float, pairs_per_chunk> distance;
  for_chunks(pairs, [&](std::size_t first, std::span<const FourParticles> part) {
    feature_kernels().bound_paths[static_cast<int>(kind)](batch_of(start, part), end.data()->data(),
                                                          distance.data());
    for (std::size_t k = 0; k < part.size(); ++k) {
      const auto bound = static_cast<double>(distance[k]);
      if (bound <= reach) in_reach.push_back({static_cast<int>(first + k), bound});
    }
  });
}

void find_unproved_paths(FeatureKind kind, std::span<const Vec3> start, std::span<const Vec3> end,
                         std::span<const FourParticles> pairs, double separation,
                         double end_separation, std::vector<int>& unproved) {
  assert(separation >= 0 && end_separation >= separation);
  const float above = std::nextafter(static_cast<float>(separation), INFINITY);
  const float end_above = std::nextafter(static_cast<float>(end_separation), INFINITY);
  std::array<bool, pairs_per_chunk> safe;
  for_chunks(pairs, [&](std::size_t first, std::span<const FourParticles> part) {
    feature_kernels().find_safe[static_cast<int>(kind)](batch_of(start, part), end.data()->data(),
                                                        above, end_above, safe.data());
    for (std::size_t k = 0; k < part.size(); ++k) {
      if (!safe[k]) unproved.push_back(static_cast<int>(first + k));
    }
  });
}

void safe_fractions(FeatureKind kind, std::span<const Vec3> start, std::span<const Vec3> end,
                    std::span<const FourParticles> pairs, double minimum_separation,
                    std::span<double> fraction) {
  assert(fraction.size() == pairs.size());
  std::fill(fraction.begin(), fraction.end(), 1.0);
  std::vector<int> unproved;
  find_unproved_paths(kind, start, end, pairs, minimum_separation, minimum_separation, unproved);
  for (int k : unproved) {
    const FourPoints from = points_of(start, pairs[k]), to = points_of(end, pairs[k]);
    fraction[k] = kind == FeatureKind::vertex_triangle
                      ? safe_fraction_vertex_triangle(from, to, minimum_separation)
                      : safe_fraction_edge_edge(from, to, minimum_separation);
  }
}

}  // namespace weft::bsi
