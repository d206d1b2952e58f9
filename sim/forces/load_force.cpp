// Applied loads: forces, pressures and moments (materials/surface_load.h).
#include <algorithm>

#include "sim/forces/force_arrays.h"
#include "sim/forces/load_elements.h"
#include "sim/scene/time_curve.h"

namespace weft::sim {

namespace {

class LoadForce final : public Force {
 public:
  explicit LoadForce(const Scene& scene) {
    for (int b = 0; b < scene.dynamic_bodies; ++b) {
      for (const SurfaceLoad& load : scene.bodies[b].loads)
        add(scene.source.load[load.number], *load.points, scene.bodies[b]);
    }
    visit([&](auto& elements) { elements.finish(scene.dynamic_particles); });
    values_.resize(curves_.size());
    set_time({});
  }

  bool is_empty() const { return cells_.is_empty() && quadratic_.is_empty() && cubic_.is_empty(); }
  std::string_view name() const override { return "load"; }
  bool has_damping() const override { return false; }
  bool is_external() const override { return true; }
  bool is_load() const override { return true; }
  void set_load_factor(double factor) override {
    factor_ = factor;
    scale();
  }
  bool varies() const override {
    return std::ranges::any_of(
        curves_, [](const Curves& each) { return each.force.varies() || each.scalar.varies(); });
  }
  void set_time(const Instant& now) override {
    for (std::size_t i = 0; i < curves_.size(); ++i) {
      curves_[i].value.force = curves_[i].force.at(now);
      curves_[i].value.scalar = curves_[i].scalar.at(now);
    }
    scale();
  }
  double evaluation_work() const override { return 0.6; }
  // Loads store no energy in the simulation.
  double energy(const Kinematics&, int) override { return 0; }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) override {
    visit([&](auto& elements) { elements.add_forces(values_, state.position, force, threads); });
  }
  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    cells_.add_couplings(neighbours);
    quadratic_.add_couplings(neighbours);
    cubic_.add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) override {
    visit([&](auto& elements) { elements.attach(pattern); });
  }
  // The semi-definite form leaves out the stiffness of loads, which may be indefinite.
  void add_derivatives(const Kinematics& state, const Derivatives& into, Definiteness definiteness,
                       int threads) override {
    if (definiteness == Definiteness::semi_definite) return;
    visit([&](auto& elements) {
      elements.add_stiffness(values_, state.position, into.stiffness, threads);
    });
  }

 private:
  struct Curves {
    LoadValue value;  // at the time of set_time(), before multiplication by factor_
    TimeCurve<Vec3> force;
    TimeCurve<double> scalar;
  };

  void add(const LoadCase& load, std::span<const LoadPoint> points, const SceneBody& body) {
    const int number = static_cast<int>(curves_.size());
    curves_.push_back(
        {LoadValue{.type = load.type, .follower = load.follower}, TimeCurve<Vec3>(load.force),
         TimeCurve<double>(load.type == LoadType::moment ? load.moment : load.pressure)});
    for (const LoadPoint& point : points) {
      const int nodes = nodes_per_load_point(body);
      if (nodes == 4) cells_.add(number, body.first_particle, point);
      if (nodes == 9) quadratic_.add(number, body.first_particle, point);
      if (nodes == 16) cubic_.add(number, body.first_particle, point);
    }
  }
  void scale() {
    for (std::size_t i = 0; i < curves_.size(); ++i) {
      values_[i] = curves_[i].value;
      values_[i].force *= factor_;
      values_[i].scalar *= factor_;
    }
  }
  template <class Visit>
  void visit(const Visit& with) {
    if (!cells_.is_empty()) with(cells_);
    if (!quadratic_.is_empty()) with(quadratic_);
    if (!cubic_.is_empty()) with(cubic_);
  }

  LoadElements<4> cells_;
  LoadElements<9> quadratic_;
  LoadElements<16> cubic_;
  std::vector<Curves> curves_;  // one entry per dynamic body and load on it
  // For each entry of curves_, the value at the time of set_time(), multiplied by factor_.
  std::vector<LoadValue> values_;
  double factor_ = 1;
};

}  // namespace

std::unique_ptr<Force> make_load_force(const Scene& scene) {
  auto force = std::make_unique<LoadForce>(scene);
  if (force->is_empty()) return nullptr;
  return force;
}

}  // namespace weft::sim
