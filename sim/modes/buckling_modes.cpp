#include "sim/modes/buckling_modes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/case/case_error.h"
#include "sim/case/case_text.h"
#include "sim/modes/case_equilibrium.h"
#include "sim/modes/largest_eigenpairs.h"
#include "sim/modes/mode_shape.h"
#include "sim/motion/dynamics.h"
#include "sim/scene/scene.h"

namespace weft::sim {

namespace {

using Matrix = Eigen::SparseMatrix<double>;
using Vector = Eigen::VectorXd;

// Largest displacement of the finite differences, as a fraction of the size of the bodies. Its
// square is the relative error that rotations of this size cause. The relative error of rounding is
// 1e-16 divided by this fraction.
constexpr double difference_part = 1e-5;
// Pivots of the stiffness below this fraction of their diagonal entries may have either sign by
// rounding.
constexpr double undecided_pivot = 1e-11;
// K is singular if the energy of its weakest direction is at most this number of rounding errors,
// plus what rounded positions may cause (PositionRounding).
constexpr double singular_roundings = 32;
// A change of energy along a mode counts as noise if it is at most this number of rounding errors.
constexpr double energy_roundings = 100;

class Buckling {
 public:
  Buckling(Dynamics& dynamics, double time, std::span<const double> state, double load_factor)
      : dynamics_(dynamics),
        scene_(dynamics.scene()),
        unknowns_(scene_),
        time_(time),
        state_(state),
        load_factor_(load_factor) {}

  BucklingModes find(int count) {
    result_.unknowns = static_cast<int>(unknowns_.count());
    if (result_.unknowns == 0) return fail("all particles are held");
    set_load_factor(load_factor_);
    auto stiffness = unknowns_.stiffness(dynamics_, time_, state_, fault_);
    if (!stiffness) return fail(fault_);
    stiffness_.swap(*stiffness);
    if (!is_stable()) return result_;
    if (!find_change()) return fail(fault_);
    const auto pairs = largest_eigenpairs(-change_, stiffness_, factors_, count);
    if (!pairs) return fail("the search for eigenvalues does not converge");
    for (const Eigenpair& pair : *pairs) add_mode(pair);
    if (result_.modes.empty())
      return fail("the loads cause no stress that could make the equilibrium unstable");
    return result_;
  }

 private:
  BucklingModes fail(const std::string& text, int particle = -1) {
    result_.failure = Failure{Failure::Kind::solver, time_, particle, text};
    return result_;
  }
  void set_load_factor(double factor) {
    dynamics_.set_load_factor(factor);
    if (scales_gravity()) dynamics_.set_load(factor);
  }
  bool scales_gravity() const { return scene_.source.equilibria.scale_gravity; }

  // Factorises K. Returns true if K is positive definite, otherwise sets the failure.
  bool is_stable() {
    const bool has_factors = factors_.factorise(stiffness_);
    const bool is_undecided =
        factors_.negative_pivots() > 0 && factors_.smallest_pivot() < undecided_pivot;
    if (!has_factors || is_undecided || is_weakest_noise()) {
      const int weakest = unknowns_.particle(factors_.weakest());
      fail("the tangent stiffness of the equilibrium is singular; it is weakest at " +
               scene_.describe_particle(weakest),
           weakest);
    } else if (factors_.negative_pivots() > 0) {
      fail("the equilibrium at load factor " + rounded_text(load_factor_) +
           " is unstable: its tangent stiffness has " +
           counted(factors_.negative_pivots(), "negative direction", "negative directions"));
    }
    return !result_.failure;
  }

  // True if rounding errors may account for the energy of the direction z with K z = e, where e is
  // the unit vector of the weakest pivot. Rounding may make the pivot of a singular K positive. A
  // limit for pivots alone would refuse thin shells, whose bending is weak beside their stretching
  // but not beside the errors of its own sum. Precondition: K has been factorised.
  bool is_weakest_noise() const {
    Vector unit = Vector::Zero(stiffness_.rows());
    unit[factors_.weakest()] = 1;
    const Vector weakest = factors_.solve(unit);
    std::vector<Vec3> way(dynamics_.particle_count());
    unknowns_.scatter(weakest, way);
    const PositionRounding rounding(dynamics_.stiffness(), StateView::of(state_).position);
    const double energy =
        std::abs(weakest.dot(stiffness_.selfadjointView<Eigen::Lower>() * weakest));
    // A direction that overflows is not a number: it counts as noise, too.
    return !(energy > singular_roundings * std::numeric_limits<double>::epsilon() *
                              rounding_scale(stiffness_, weakest) +
                          rounding.energy(way));
  }

  // Sets change_ to G. Returns false, and sets fault_ to the reason, if the loads cause no
  // displacement or forces cannot be evaluated.
  bool find_change() {
    std::vector<Vec3> load(dynamics_.particle_count()), way(dynamics_.particle_count());
    set_load_factor(1);
    dynamics_.applied_loads(time_, state_, scales_gravity(), load);
    unknowns_.scatter(factors_.solve(unknowns_.gather(load)), way);
    double farthest = 0;
    for (const Vec3& each : way) farthest = std::max(farthest, each.norm());
    fault_ = "the loads move nothing";
    if (!(farthest > 0)) return false;
    step_ = difference_part * size() / farthest;
    const std::optional<Matrix> before = stiffness_along(way, -step_),
                                after = stiffness_along(way, step_);
    set_load_factor(load_factor_);
    if (!before || !after) return false;
    change_ = (*after - *before) / (2 * step_);
    return true;
  }
  std::optional<Matrix> stiffness_along(std::span<const Vec3> way, double step) {
    std::vector<double> y(state_.begin(), state_.end());
    auto* const x = reinterpret_cast<Vec3*>(y.data());
    for (std::size_t i = 0; i < way.size(); ++i) x[i] += step * way[i];
    set_load_factor(load_factor_ + step);
    return unknowns_.stiffness(dynamics_, time_, y, fault_);
  }
  double size() const {
    Eigen::AlignedBox3d box;
    for (const Vec3& each : StateView::of(state_).position) box.extend(each);
    return box.diagonal().norm();
  }

  void add_mode(const Eigenpair& pair) {
    const double rounding = energy_roundings * std::numeric_limits<double>::epsilon() / step_ *
                            rounding_scale(stiffness_, pair.vector);
    if (!(std::abs(pair.value) > rounding)) return;
    BucklingMode& mode = result_.modes.emplace_back();
    mode.load_factor = load_factor_ + 1 / pair.value;
    mode.error = equation_error(stiffness_, -change_, 1 / pair.value, pair.vector);
    mode.shape = shape_of(unknowns_, pair.vector);
  }

  Dynamics& dynamics_;
  const Scene& scene_;
  ModeUnknowns unknowns_;
  double time_;  // s
  std::span<const double> state_;
  double load_factor_;
  Matrix stiffness_, change_;
  SymmetricFactors factors_;
  double step_ = 0;  // increment of the load factor
  std::string fault_;
  BucklingModes result_;
};

bool is_zero(const LoadCase& load) {
  switch (load.type) {
    case LoadType::pressure:
      return load.pressure.is_zero();
    case LoadType::moment:
      return load.moment.is_zero();
    default:
      return load.force.is_zero();
  }
}

}  // namespace

void require_load(const Case& source) {
  refuse_particles(source);
  if (source.equilibria.scale_gravity && !source.world.gravity.is_zero()) return;
  if (!std::ranges::all_of(source.load, is_zero)) return;
  const bool is_empty = source.load.empty();
  throw CaseError(is_empty ? source.body.front().location : source.load.front().location,
                  is_empty ? "nothing loads the case: buckling is sought at multiples of its loads"
                           : "the loads are zero: buckling is sought at multiples of them",
                  "expected a [[load]], or gravity with static.scale_gravity = true");
}

BucklingModes find_buckling_modes(Dynamics& dynamics, double time, std::span<const double> state,
                                  double load_factor, int count) {
  return Buckling(dynamics, time, state, load_factor).find(count);
}

}  // namespace weft::sim
