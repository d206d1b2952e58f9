#include "bsi/sphere.h"

#include <Eigen/Core>
#include <algorithm>
#include <limits>

namespace weft::bsi {

double bounding_sphere_gap(const Sphere& first, const Sphere& second) {
  if (first.radius < 0 || second.radius < 0) return std::numeric_limits<double>::infinity();
  const auto centre_of = [](const Sphere& sphere) {
    return Eigen::Vector3d(sphere.x, sphere.y, sphere.z);
  };
  // Rounding changes the distance of the centres by less than 4 x 2^-53 of itself, and the sum of
  // the radii by less than 2^-53 of itself. The factor covers both.
  const double distance = (centre_of(first) - centre_of(second)).norm() * (1 - 0x1p-49);
  const double radii = static_cast<double>(first.radius) + static_cast<double>(second.radius);
  return std::max(0.0, distance - radii);
}

}  // namespace weft::bsi
