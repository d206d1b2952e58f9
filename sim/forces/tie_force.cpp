// The forces of the springs of ties and seams. A force acts along its spring. At a point of a
// triangle it is split among the nodes by the weights of the point, which conserves momentum and
// angular momentum.
#include "sim/forces/force_arrays.h"
#include "sim/forces/tie_springs.h"

namespace weft::sim {

namespace {

class TieForce final : public Force {
 public:
  // Springs of seams stand for a constraint, those of ties have the stiffness that the case gives.
  enum class Joint { tie, seam };
  TieForce(Joint joint, TieSprings springs) : joint_(joint), springs_(std::move(springs)) {}

  std::string_view name() const override { return joint_ == Joint::tie ? "ties" : "seams"; }
  bool is_constraint() const override { return joint_ == Joint::seam; }
  bool has_damping() const override { return false; }
  bool varies() const override { return springs_.vary(); }
  bool has_moving_points() const override { return springs_.vary(); }
  void set_time(const Instant& now) override { springs_.set_time(now); }
  double evaluation_work() const override { return 0.1; }

  double energy(const Kinematics& state, int /*threads*/) override {
    double sum = 0;
    for (const SpringEnds& spring : springs_.springs()) {
      const double strain = springs_.between(spring, state.position).norm() - spring.length;
      sum += 0.5 * spring.stiffness * strain * strain;
    }
    return sum;
  }

  double power_of_moving_points(const Kinematics& state) override {
    double power = power_of_closing_seams(state);
    for (const SpringEnds& spring : springs_.springs()) {
      if (spring.anchor < 0) continue;
      power += spring.anchor_coefficient *
               slope(spring, state.position).dot(springs_.anchors().velocity(spring.anchor));
    }
    return power;
  }

  double power_of_closing_seams(const Kinematics& state) override {
    double power = 0;
    for (const SpringEnds& spring : springs_.springs()) {
      if (spring.length_rate == 0) continue;
      const double strain = springs_.between(spring, state.position).norm() - spring.length;
      power -= spring.stiffness * strain * spring.length_rate;
    }
    return power;
  }

  void list_outer_forces(const Kinematics& state, std::vector<OuterForce>& all) override {
    for (const SpringEnds& spring : springs_.springs()) {
      const Vec3 pull = slope(spring, state.position);
      if (spring.tie >= 0) list_tie(spring, pull, state, all);
      if (spring.anchor < 0) continue;
      OuterForce& body = all.emplace_back();
      body.by = OuterForce::By::tied_body;
      body.body = spring.anchor_body;
      body.place = springs_.anchors().position(spring.anchor);
      body.force = spring.anchor_coefficient * pull;
    }
  }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int /*threads*/) override {
    for (const SpringEnds& spring : springs_.springs()) {
      const Vec3 pull = slope(spring, state.position);
      for (int i = 0; i < spring.count; ++i)
        force[spring.particle[i]] -= spring.coefficient[i] * pull;
    }
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    for (const SpringEnds& spring : springs_.springs()) {
      for (int a = 0; a < spring.count; ++a) {
        for (int b = 0; b < spring.count; ++b)
          neighbours[spring.particle[a]].push_back(spring.particle[b]);
      }
    }
  }
  void attach(const BlockPattern& /*pattern*/) override {}

  // Adds the second derivative of W by the vector d of each spring, with n = d / |d|:
  //   d^2 W / dd dd = k (n n^T + (1 - L/|d|) (I - n n^T)).
  // Under compression the factor 1 - L/|d| is negative. The semi-definite form replaces it by zero.
  // If d = 0, the derivative counts as k I.
  void add_derivatives(const Kinematics& state, const Derivatives& into, Definiteness definiteness,
                       int /*threads*/) override {
    const BlockPattern& pattern = into.stiffness.pattern();
    for (const SpringEnds& spring : springs_.springs()) {
      const Mat3 stiffness = curvature(spring, state.position, definiteness);
      for (int a = 0; a < spring.count; ++a) {
        for (int b = 0; b < spring.count; ++b) {
          const int row = spring.particle[a], column = spring.particle[b];
          if (row > column) continue;
          into.stiffness.upper_block(pattern.upper(row, pattern.slot(row, column))) +=
              spring.coefficient[a] * spring.coefficient[b] * stiffness;
        }
      }
    }
  }

 private:
  void list_tie(const SpringEnds& spring, const Vec3& pull, const Kinematics& state,
                std::vector<OuterForce>& all) const {
    OuterForce& tie = all.emplace_back();
    tie.by = OuterForce::By::tie;
    tie.tie = spring.tie;
    tie.force = -pull;
    if (spring.anchor < 0 || spring.anchor_coefficient < 0) {
      tie.place = state.position[spring.particle[0]];
    } else {
      tie.place = springs_.anchors().position(spring.anchor);
    }
  }

  // Returns dW/dd, N. It is zero if the ends of the spring coincide.
  Vec3 slope(const SpringEnds& spring, std::span<const Vec3> position) const {
    const Vec3 d = springs_.between(spring, position);
    if (spring.length == 0) return spring.stiffness * d;
    const double distance = d.norm();
    if (distance == 0) return Vec3::Zero();
    return spring.stiffness * (1 - spring.length / distance) * d;
  }

  Mat3 curvature(const SpringEnds& spring, std::span<const Vec3> position,
                 Definiteness definiteness) const {
    if (spring.length == 0) return spring.stiffness * Mat3::Identity();
    const Vec3 d = springs_.between(spring, position);
    const double distance = d.norm();
    if (distance == 0) return spring.stiffness * Mat3::Identity();
    const double across = 1 - spring.length / distance;
    const bool leaves_out = across < 0 && definiteness == Definiteness::semi_definite;
    const Vec3 n = d / distance;
    const Mat3 along = n * n.transpose();
    return spring.stiffness * (along + (leaves_out ? 0.0 : across) * (Mat3::Identity() - along));
  }

  Joint joint_;
  TieSprings springs_;
};

}  // namespace

// Returns null only if the case has no ties. If all ties are broken or between sleeping bodies, the
// force has no springs, and the trajectory still records its energy.
std::unique_ptr<Force> make_tie_force(const Scene& scene) {
  if (scene.source.tie.empty()) return nullptr;
  return std::make_unique<TieForce>(TieForce::Joint::tie, TieSprings(scene, scene.ties));
}

// Likewise while all sewn bodies sleep.
std::unique_ptr<Force> make_seam_force(const Scene& scene) {
  if (scene.seams.empty()) return nullptr;
  return std::make_unique<TieForce>(TieForce::Joint::seam, TieSprings(scene, scene.seams));
}

}  // namespace weft::sim
