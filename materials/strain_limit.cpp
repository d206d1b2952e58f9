#include "materials/strain_limit.h"

#include <cassert>

#include "materials/membrane.h"

namespace weft::materials {

StrainLimit make_strain_limit(const Nodes3& rest, double limit, double stiffness) {
  assert(limit > 0 && stiffness > 0);
  const Vec3 one = rest.col(1) - rest.col(0), two = rest.col(2) - rest.col(0);
  const double length = one.norm(), double_area = one.cross(two).norm();
  assert(double_area > 0);
  // In axes along the first edge and across it, the nodes lie at (0, 0), (length, 0) and (foot,
  // height).
  const double foot = one.dot(two) / length, height = double_area / length;
  const double largest = (1 + limit) * (1 + limit);
  const double onset = (1 + 0.5 * limit) * (1 + 0.5 * limit);
  StrainLimit result;
  result.gradients = {{{1 / length, -foot / (length * height)}, {0, 1 / height}}};
  result.onset = onset;
  result.range = largest - onset;
  result.stiffness = 0.5 * double_area * stiffness * result.range * result.range / 8;
  return result;
}

}  // namespace weft::materials
