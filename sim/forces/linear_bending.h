// Bending whose moments are linear in the changes of the angles.
#pragma once

#include <array>
#include <vector>

#include "sim/forces/quad_bending.h"

namespace weft::sim {

// The law of a batch of quads whose moments are linear in the strains.
struct LinearBending {
  using Lanes = materials::Lanes;
  using Hinges = QuadBending::Hinges;
  using Modulus = QuadBending::Modulus;

  static constexpr bool damps_like_stiffness = true;
  std::array<Modulus, 2> own;
  Hinges rest_angles;

  Hinges moments(const Hinges& strains, const Lanes& damping_time, const Hinges& rates) const {
    Hinges sum = strains;
    for (int h = 0; h < hinge_count; ++h) sum[h] += damping_time * rates[h];
    return moments(sum);
  }
  Hinges moments(const Hinges& strains) const {
    return QuadBending::sum_of_triangles(
        [&](int t) { return own[t] * QuadBending::of_triangle(strains, t); });
  }
  Lanes energy(const Hinges& strains) const {
    Lanes sum = 0;
    for (int t = 0; t < 2; ++t) {
      const materials::Vec3Of<Lanes> angles = QuadBending::of_triangle(strains, t);
      sum += 0.5 * materials::dot(angles, own[t] * angles);
    }
    return sum;
  }
  const std::array<Modulus, 2>& viscosities(const Hinges& /*strains*/) const { return own; }
  std::array<Modulus, 2> joined(const Hinges& /*strains*/, Definiteness /*kind*/,
                                double inverse_gamma, const Lanes& damping_time) const {
    const Lanes factor = 1.0 + inverse_gamma * damping_time;
    return {own[0].scaled(factor), own[1].scaled(factor)};
  }
};

// Returns the laws of all batches of quads, without rest angles. Lanes beyond the last quad have no
// stiffness, and never yield.
template <class Batch>
std::vector<Batch> linear_batches(const BendingQuads& quads) {
  std::vector<Batch> batches((quads.nodes.size() + materials::lane_count - 1) /
                             materials::lane_count);
  for (std::size_t q = 0; q < materials::lane_count * batches.size(); ++q) {
    for (int t = 0; t < 2; ++t) {
      const materials::Mat3 modulus =
          q < quads.moduli.size() ? quads.moduli[q][t] : materials::Mat3(materials::Mat3::Zero());
      QuadBending::Modulus& own = batches[q / materials::lane_count].own[t];
      for (int i = 0; i < 3; ++i) {
        for (int j = i; j < 3; ++j) own(i, j).values[q % materials::lane_count] = modulus(i, j);
      }
    }
  }
  return batches;
}

}  // namespace weft::sim
