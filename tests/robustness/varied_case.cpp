#include "tests/robustness/varied_case.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>
#include <random>
#include <stdexcept>
#include <variant>

namespace weft::robustness {

namespace {

using sim::Mat3;
using sim::Vec3;

constexpr double degree = std::numbers::pi / 180;

class Turner {
 public:
  Turner(std::uint32_t seed, bool turns) : random_(seed) {
    if (!turns) return;
    // Four normal numbers are a random rotation once they are a unit quaternion.
    std::normal_distribution<double> normal;
    double q[4];
    for (double& part : q) part = normal(random_);
    turn_ = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
  }

  Vec3 turned(const Vec3& direction) const { return turn_ * direction; }
  // Turns what a rotation vector (degrees) has rotated.
  Vec3 turned_pose(const Vec3& rotation_deg, const Vec3& more_rad) const {
    const Vec3 vector = degree * rotation_deg;
    const Eigen::AngleAxisd before(vector.norm(),
                                   vector.norm() > 0 ? vector.normalized() : Vec3::UnitX().eval());
    const Eigen::AngleAxisd more(
        more_rad.norm(), more_rad.norm() > 0 ? more_rad.normalized() : Vec3::UnitX().eval());
    const Eigen::AngleAxisd all(turn_ * more * before);
    return all.angle() / degree * all.axis();
  }
  void turn(Vec3& direction) const { direction = turned(direction); }
  void turn(sim::Varying<Vec3>& vector) const {
    std::visit([this](auto& form) { turn_form(form); }, vector.form);
  }
  void turn(std::optional<sim::MotionCase>& motion) const {
    if (!motion) return;
    turn(motion->velocity);
    turn(motion->angular_velocity_deg);
    if (motion->centre) turn(*motion->centre);
    for (sim::KeyframeCase& frame : motion->keyframes) {
      turn(frame.translation);
      turn(frame.rotation_deg);
    }
  }

  Vec3 small() {
    std::uniform_real_distribution<double> part(-jitter, jitter);
    const double x = part(random_), y = part(random_), z = part(random_);
    return {x, y, z};
  }

 private:
  void turn_form(Vec3& vector) const { turn(vector); }
  void turn_form(sim::CurveCase<Vec3>& curve) const {
    for (Vec3& value : curve.values) turn(value);
  }
  void turn_form(sim::GustCase& gust) const { turn(gust.mean); }

  std::mt19937 random_;
  Eigen::Quaterniond turn_ = Eigen::Quaterniond::Identity();
};

void refuse_regions(const sim::VertexSelection& vertices) {
  if (vertices.region_min || vertices.region_max)
    throw std::invalid_argument("a region of space cannot turn");
}

// Returns a length (m) of the order of the shape's size, or 0.1 m for shapes from files.
double size_of(const sim::ShapeCase& shape) {
  const double side = shape.size.empty() ? 0.1 : shape.size[0];
  return std::max({side, shape.radius.value_or(0), shape.outer_radius.value_or(0),
                   shape.major_radius.value_or(0)});
}

// True if the body is a shell. Without a name, the material is the only one of the case.
bool is_shell(const sim::Case& source, const sim::BodyCase& body) {
  return std::ranges::any_of(source.material, [&](const sim::MaterialCase& material) {
    return material.is_shell() && (body.material.empty() || material.name == body.material);
  });
}

void vary(sim::BodyCase& body, bool can_stretch, Turner& turner) {
  body.position = turner.turned(body.position) + size_of(body.shape) * turner.small();
  body.rotation_deg = turner.turned_pose(body.rotation_deg, turner.small());
  if (can_stretch) body.stretch = body.stretch.cwiseProduct(Vec3::Ones() + turner.small());
  turner.turn(body.velocity);
  turner.turn(body.angular_velocity_deg);
  for (sim::PinCase& pin : body.pin) {
    refuse_regions(pin.vertices);
    if (!pin.axes.empty()) throw std::invalid_argument("the axes of a pin cannot turn");
    if (pin.symmetry) turner.turn(*pin.symmetry);
    turner.turn(pin.motion);
  }
}

}  // namespace

sim::Case varied(const sim::Case& source, std::uint32_t seed) {
  sim::Case result = source;
  // The places of particles have the directions of the axes, so cases with particles do not turn.
  Turner turner(seed, source.particles.empty());
  turner.turn(result.world.gravity);
  turner.turn(result.world.wind);
  for (sim::BodyCase& body : result.body) vary(body, !is_shell(source, body), turner);
  for (sim::ObstacleCase& obstacle : result.obstacle) {
    turner.turn(obstacle.position);
    obstacle.rotation_deg = turner.turned_pose(obstacle.rotation_deg, Vec3::Zero());
    turner.turn(obstacle.motion);
  }
  for (sim::LoadCase& load : result.load) {
    refuse_regions(load.vertices);
    turner.turn(load.force);
  }
  for (const sim::TieCase& tie : result.tie) refuse_regions(tie.vertices);
  return result;
}

}  // namespace weft::robustness
