#include "materials/surface_load.h"

namespace weft::materials {

namespace {

SurfaceForceSlopes no_slopes() {
  SurfaceForceSlopes slopes;
  slopes.by_u.fill(Mat3::Zero());
  slopes.by_v.fill(Mat3::Zero());
  return slopes;
}

}  // namespace

Mat3 cross_matrix(const Vec3& a) {
  Mat3 matrix;
  matrix << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return matrix;
}

Mat3 frame_of(const Tangents& tangents) {
  Mat3 frame;
  frame.col(0) = tangents.u.normalized();
  frame.col(2) = tangents.u.cross(tangents.v).normalized();
  frame.col(1) = frame.col(2).cross(frame.col(0));
  return frame;
}

SurfaceForce pressure_load(const Tangents& tangents, double pressure) {
  return {.position = pressure * tangents.u.cross(tangents.v)};
}

SurfaceForceSlopes pressure_load_slopes(const Tangents& tangents, double pressure) {
  SurfaceForceSlopes slopes = no_slopes();
  slopes.by_u[0] = -pressure * cross_matrix(tangents.v);
  slopes.by_v[0] = pressure * cross_matrix(tangents.u);
  return slopes;
}

SurfaceForce turning_load(const Tangents& tangents, const Vec3& components) {
  return {.position = frame_of(tangents) * components};
}

SurfaceForceSlopes turning_load_slopes(const Tangents& tangents, const Vec3& components) {
  const Mat3 frame = frame_of(tangents);
  const Vec3 along = frame.col(0), beside = frame.col(1), normal = frame.col(2);
  const double length = tangents.u.norm(), height = tangents.v.dot(beside);
  const Mat3 turn_by_u = (normal * beside.transpose() - beside * normal.transpose() -
                          tangents.v.dot(along) / height * along * normal.transpose()) /
                         length;
  const Mat3 turn_by_v = along * normal.transpose() / height;
  const Mat3 force = cross_matrix(frame * components);
  SurfaceForceSlopes slopes = no_slopes();
  slopes.by_u[0] = -force * turn_by_u;
  slopes.by_v[0] = -force * turn_by_v;
  return slopes;
}

SurfaceForce edge_moment(const Tangents& tangents, double moment) {
  const Vec3 across = tangents.u.cross(tangents.v);
  const double length = tangents.u.norm();
  const Vec3 pull = moment * across / across.squaredNorm();
  return {.along_u = tangents.u.dot(tangents.v) / length * pull, .along_v = -length * pull};
}

SurfaceForceSlopes edge_moment_slopes(const Tangents& tangents, double moment) {
  const Vec3 across = tangents.u.cross(tangents.v);
  const double length = tangents.u.norm(), square = across.squaredNorm();
  const double shear = tangents.u.dot(tangents.v) / length;
  const Vec3 along = tangents.u / length, pull = moment * across / square;
  // of_pull is the derivative of `pull` by `across`. pull_by_u and pull_by_v are its derivatives by
  // the tangents.
  const Mat3 of_pull =
      moment / square * (Mat3::Identity() - 2 * across * across.transpose() / square);
  const Mat3 pull_by_u = -of_pull * cross_matrix(tangents.v);
  const Mat3 pull_by_v = of_pull * cross_matrix(tangents.u);
  SurfaceForceSlopes slopes = no_slopes();
  slopes.by_u[1] =
      pull * (tangents.v / length - shear / length * along).transpose() + shear * pull_by_u;
  slopes.by_v[1] = pull * along.transpose() + shear * pull_by_v;
  slopes.by_u[2] = -pull * along.transpose() - length * pull_by_u;
  slopes.by_v[2] = -length * pull_by_v;
  return slopes;
}

}  // namespace weft::materials
