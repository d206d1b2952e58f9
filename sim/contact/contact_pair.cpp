#include "sim/contact/contact_pair.h"

#include <Eigen/Geometry>
#include <cmath>

#include "materials/contact.h"

namespace weft::sim {

namespace {

// Two directions on a surface count as parallel if the squared sine of their angle is smaller than
// this. They then do not determine the rotation of the surface.
constexpr double parallel_squared_sine = 1e-12;

// Returns turn_1 and turn_2 of a surface spanned by e1 and e2. They give its angular velocity from
// the rates of e1 and e2:
//   omega = turn_1 e1' + turn_2 e2',
// the rotation of the normal m plus half the vorticity of the motion in the plane. This is exact if
// the motion is rigid. There is no result if e1 and e2 are nearly parallel. With the dual vectors
// g_k of e_k in the plane and q_k = m x g_k:
//   m' = -sum_k g_k (m . e_k'),  omega = m x m' + 1/2 m sum_k (q_k . e_k').
std::optional<std::array<Mat3, 2>> turning(const Vec3& e1, const Vec3& e2) {
  const Vec3 across = e1.cross(e2);
  const double squared_area = across.squaredNorm();
  if (!(squared_area > parallel_squared_sine * e1.squaredNorm() * e2.squaredNorm()))
    return std::nullopt;
  const double area = std::sqrt(squared_area);
  const Vec3 m = across / area, q1 = e2 / area, q2 = -e1 / area;
  return std::array<Mat3, 2>{Mat3(0.5 * m * q1.transpose() - q1 * m.transpose()),
                             Mat3(0.5 * m * q2.transpose() - q2 * m.transpose())};
}

// Returns Sliding::lever for two dynamic features, or nothing if they do not span a surface. A
// triangle rotates with the two edges at its first corner. Two edges rotate with the plane that
// both span.
std::optional<std::array<Mat3, 4>> sliding_levers(bsi::FeatureKind kind,
                                                  const bsi::Closest& closest,
                                                  const bsi::FourPoints& x, const Vec3& normal) {
  const bool edges = kind == bsi::FeatureKind::edge_edge;
  const auto turn = turning(edges ? x[1] - x[0] : x[2] - x[1], x[3] - x[edges ? 2 : 1]);
  if (!turn) return std::nullopt;
  const Mat3 arm = cross_matrix(closest.separation);
  const Mat3 first = arm * (*turn)[0], second = arm * (*turn)[1];
  std::array<Mat3, 4> lever;
  for (int i = 0; i < 4; ++i) lever[i] = closest.weight[i] * Mat3::Identity();
  if (edges) {
    lever[0] -= first;
    lever[1] += first;
    lever[2] -= second;
  } else {
    lever[1] -= first + second;
    lever[2] += first;
  }
  lever[3] += second;
  const Mat3 across = Mat3::Identity() - normal * normal.transpose();
  for (Mat3& matrix : lever) matrix = (across * matrix).eval();
  return lever;
}

}  // namespace

Mat3 cross_matrix(const Vec3& v) {
  Mat3 matrix;
  matrix << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return matrix;
}

double apply_push(const ContactLaw& law, double thickness, double mollifier,
                  const bsi::Closest& closest, std::span<const Vec3> velocity, ContactPair& pair) {
  const double distance = std::sqrt(closest.squared_distance);
  pair.weight = closest.weight;
  pair.normal = closest.separation / distance;
  pair.gap = distance - thickness;
  const materials::BarrierDerivatives barrier =
      materials::barrier(pair.gap, law.range, mollifier * law.stiffness);
  Vec3 relative = Vec3::Zero();
  for (int i = 0; i < 4; ++i) relative += closest.weight[i] * velocity[pair.nodes[i]];
  const double rate = pair.normal.dot(relative);
  const materials::DampedPush push =
      law.settling_speed > 0
          ? materials::bouncing_push(barrier, law.restitution, law.settling_speed, rate)
          : materials::damped_push(barrier, pair.gap, law.range, law.damping_time, rate);
  pair.energy = pair.coefficient * barrier.value;
  pair.push = pair.coefficient * push.force;
  pair.stiffness = pair.coefficient * push.stiffness;
  pair.damping = pair.coefficient * push.damping;
  // A bounce takes the friction of its whole push, or else parts of impacts would count twice.
  return law.settling_speed > 0 ? pair.push : -pair.coefficient * barrier.first;
}

Vec3 rigid_spin(const std::array<Vec3, 3>& position, const std::array<Vec3, 3>& velocity) {
  const auto turn = turning(position[1] - position[0], position[2] - position[0]);
  if (!turn) return Vec3::Zero();
  return (*turn)[0] * (velocity[1] - velocity[0]) + (*turn)[1] * (velocity[2] - velocity[0]);
}

std::optional<Sliding> friction_of(const ContactLaw& law, double barrier_push,
                                   const SlidingFeatures& features, const ContactPair& pair) {
  const double limit = law.friction * barrier_push;
  if (limit == 0) return std::nullopt;
  const bsi::Closest& closest = features.closest;
  Sliding sliding;
  Vec3 u = Vec3::Zero();
  if (features.obstacle_spin) {
    const Mat3 across = Mat3::Identity() - pair.normal * pair.normal.transpose();
    for (int i = 0; i < 4; ++i) sliding.lever[i] = closest.weight[i] * across;
    u = -across * features.obstacle_spin->cross(closest.separation);
  } else {
    const auto lever = sliding_levers(features.kind, closest, features.points, pair.normal);
    if (!lever) return std::nullopt;
    sliding.lever = *lever;
  }
  for (int i = 0; i < 4; ++i) u += sliding.lever[i] * features.velocity[pair.nodes[i]];
  sliding.spins = features.spins;
  for (const SpinArm& spin : features.spins) {
    if (spin.point >= 0) u += spin.arm * pair.normal.cross(features.velocity[spin.point]);
  }
  sliding.limit = {limit, limit, law.friction * pair.stiffness, 0};
  if (law.settling_speed > 0) sliding.limit.per_rate = law.friction * pair.damping;
  if (features.from_anchor != nullptr) {
    sliding.hold_rate = law.hold_rate;
    const Vec3& offset = *features.from_anchor;
    u += law.hold_rate * (offset - pair.normal.dot(offset) * pair.normal);
  }
  sliding.velocity = u;
  const double speed = u.norm();
  const materials::FrictionFactor factor = materials::friction_factor(speed, law.friction_speed);
  sliding.force = -limit * factor.over_speed * u;
  sliding.slope =
      limit * factor.over_speed * (Mat3::Identity() - pair.normal * pair.normal.transpose());
  if (speed > 0) {
    const Vec3 along = u / speed;
    sliding.slope += limit * (factor.slope - factor.over_speed) * along * along.transpose();
  }
  if (features.from_anchor != nullptr) sliding.stiffness = law.hold_rate * sliding.slope;
  return sliding;
}

double follow_step(const SlidingEnd& end, const Vec3& normal, bool is_subtracted,
                   double friction_speed, Sliding& sliding) {
  const Vec3& u = end.velocity;
  const double speed = u.norm();
  const Vec3 before = sliding.force - sliding.slope * (u - sliding.velocity);
  const double over_speed = materials::friction_factor(speed, friction_speed).over_speed;
  const bool slides_on = std::abs(before.dot(u)) > std::abs(end.limit) * speed ||
                         (end.slowing < speed && friction_speed < speed);
  const double secant = end.limit * (slides_on ? 1 / speed : over_speed);
  const Vec3 after = -secant * u;
  sliding.slope.setZero();
  if (!is_subtracted) {
    sliding.slope = secant * (Mat3::Identity() - normal * normal.transpose());
    if (slides_on) sliding.slope -= secant / (speed * speed) * u * u.transpose();
  }
  sliding.stiffness = sliding.hold_rate * sliding.slope;
  sliding.force = after + sliding.slope * (u - sliding.velocity);
  sliding.limit.now = end.limit;
  return (after - before).norm();
}

}  // namespace weft::sim
