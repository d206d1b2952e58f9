#include "materials/fabric_membrane.h"

#include <cassert>

#include "materials/orthotropic_membrane.h"

namespace weft::materials {

FabricMembrane make_fabric_membrane(const Nodes3& rest, const Vec3& warp, double damping_time) {
  const Nodes3 edges = opposite_edges(rest);
  FabricMembrane membrane;
  membrane.rest_squared_length = squared_lengths(edges);
  membrane.strains.map = green_strain_map(rest, warp);
  membrane.strains.area = 0.5 * edges.col(0).cross(edges.col(1)).norm();
  membrane.damping_time = damping_time;
  assert(membrane.strains.area > 0);
  return membrane;
}

}  // namespace weft::materials
