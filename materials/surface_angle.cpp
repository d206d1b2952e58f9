#include "materials/surface_angle.h"

namespace weft::materials {

SurfaceAngle::Side::Side(const Vec3& direction, double length, const Vec3& tangent) {
  const double along = tangent.dot(direction);
  const Vec3 apart = tangent - along * direction;
  const double distance = apart.norm();
  if (!(distance > 0 && length > 0)) return;
  skew = along / length;
  height = distance;
  across = apart / distance;
  normal = direction.cross(across);
}

SurfaceAngle::SurfaceAngle(const Vec3& t, const Vec3& a, const Vec3& b)
    : direction_(t.normalized()),
      length_(t.norm()),
      a_(direction_, length_, a),
      b_(direction_, length_, b),
      cosine_(a_.across.dot(b_.across)),
      sine_(a_.normal.dot(b_.across)) {}

double SurfaceAngle::energy(const AngleLaw& law) const {
  const double cosine = cosine_ - law.cosine, sine = sine_ - law.sine;
  return 0.5 * law.stiffness * (cosine * cosine + sine * sine);
}

}  // namespace weft::materials
