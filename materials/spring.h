// A spring between two nodes with Kelvin-Voigt damping: W = k/2 (l - L)^2, dissipation k beta l'^2
// / 2.
#pragma once

#include "materials/types.h"

namespace weft::materials {

struct Spring {
  double rest_length = 0;   // L, m
  double stiffness = 0;     // k, N/m
  double damping_time = 0;  // beta, s
};

// J
double spring_energy(const Spring& spring, const Vec3& x0, const Vec3& x1);
// Force on node 0, N; node 1 gets the opposite one. Zero for coincident nodes.
Vec3 spring_force(const Spring& spring, const Vec3& x0, const Vec3& x1, const Vec3& v0,
                  const Vec3& v1);
// -d force0 / d x0 at constant velocity of extension (exact without damping), N/m. Node pairs: [K
// -K; -K K].
Mat3 spring_stiffness(const Spring& spring, const Vec3& x0, const Vec3& x1, const Vec3& v0,
                      const Vec3& v1);
// -d force0 / d v0, N s/m; exact.
Mat3 spring_damping(const Spring& spring, const Vec3& x0, const Vec3& x1);

}  // namespace weft::materials
