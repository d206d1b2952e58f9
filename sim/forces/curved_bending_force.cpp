// The bending of cloth whose stiffness depends on the curvature.
#include <memory>

#include "materials/curved_bending.h"
#include "sim/forces/force_arrays.h"
#include "sim/forces/quad_bending.h"
#include "sim/scene/cloth_laws.h"

namespace weft::sim {

namespace {

using materials::lane_count;
using materials::Lanes;
using materials::Vec3Of;
using Hinges = QuadBending::Hinges;
using Modulus = QuadBending::Modulus;

// The law of a batch of quads whose bending stiffness depends on the curvature
// (materials/curved_bending.h).
struct CurvedBendingBatch {
  static constexpr bool damps_like_stiffness = true;
  std::shared_ptr<const materials::CurvedBending> law;  // shared by all batches
  std::array<materials::StrainMapOf<Lanes>, 2> maps;
  Hinges rest_angles;

  Hinges moments(const Hinges& strains, const Lanes& damping_time, const Hinges& rates) const {
    const std::array<Modulus, 2> damping = viscosities(strains);
    return QuadBending::sum_of_triangles([&](int t) -> Vec3Of<Lanes> {
      return materials::law_slope(maps[t], *law, QuadBending::of_triangle(strains, t)) +
             damping_time * (damping[t] * QuadBending::of_triangle(rates, t));
    });
  }
  Hinges moments(const Hinges& strains) const {
    return QuadBending::sum_of_triangles([&](int t) {
      return materials::law_slope(maps[t], *law, QuadBending::of_triangle(strains, t));
    });
  }
  Lanes energy(const Hinges& strains) const {
    return materials::law_energy(maps[0], *law, QuadBending::of_triangle(strains, 0)) +
           materials::law_energy(maps[1], *law, QuadBending::of_triangle(strains, 1));
  }
  std::array<Modulus, 2> viscosities(const Hinges& strains) const {
    return {materials::law_viscosity(maps[0], *law, QuadBending::of_triangle(strains, 0)),
            materials::law_viscosity(maps[1], *law, QuadBending::of_triangle(strains, 1))};
  }
  std::array<Modulus, 2> joined(const Hinges& strains, Definiteness kind, double inverse_gamma,
                                const Lanes& damping_time) const {
    std::array<Modulus, 2> sum = viscosities(strains);
    for (int t = 0; t < 2; ++t) {
      const Modulus damping = sum[t].scaled(inverse_gamma * damping_time);
      if (kind == Definiteness::exact)
        sum[t] = materials::law_tangent(maps[t], *law, QuadBending::of_triangle(strains, t), false);
      sum[t] += damping;
    }
    return sum;
  }
};

std::vector<CurvedBendingBatch> curved_batches(const BendingQuads& quads,
                                               materials::CurvedBending law) {
  std::vector<CurvedBendingBatch> batches((quads.nodes.size() + lane_count - 1) / lane_count);
  const auto shared = std::make_shared<const materials::CurvedBending>(std::move(law));
  for (CurvedBendingBatch& batch : batches) batch.law = shared;
  for (std::size_t q = 0; q < quads.maps.size(); ++q) {
    for (int t = 0; t < 2; ++t) {
      materials::StrainMapOf<Lanes>& map = batches[q / lane_count].maps[t];
      for (int i = 0; i < 9; ++i)
        map.map.data()[i].values[q % lane_count] = quads.maps[q][t].map.data()[i];
      map.area.values[q % lane_count] = quads.maps[q][t].area;
    }
  }
  return batches;
}

}  // namespace

std::unique_ptr<Force> make_curved_bending_force(const Scene& scene, const MaterialCase& material) {
  const BendingQuads quads =
      bending_quads(scene, [&](const MaterialCase& each) { return each.name == material.name; });
  if (quads.nodes.empty()) return nullptr;
  return std::make_unique<BendingForce<CurvedBendingBatch>>(
      quads, curved_batches(quads, std::get<materials::CurvedBending>(*bending_law(material))),
      rest_positions(scene));
}

}  // namespace weft::sim
