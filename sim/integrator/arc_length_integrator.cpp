#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "sim/case/case_text.h"
#include "sim/integrator/equilibrium_newton.h"
#include "sim/integrator/integrator_makers.h"
#include "sim/integrator/one_step_integrator.h"

namespace weft::sim {

namespace {

// Largest number of corrections per trial of a point.
constexpr int most_corrections = 12;
// Number of corrections per point below which the arc grows.
constexpr int wanted_corrections = 5;
// Largest factor by which the arc grows or shrinks after a point is found.
constexpr double largest_change = 2;
// Longest arc as a multiple of the first arc, unless the case sets the longest arc.
constexpr double default_largest_arc = 5;
// Shortest arc, as a multiple of the first arc. Shorter arcs end the run.
constexpr double smallest_arc = 1e-6;
// A trial of a point ends if a correction moves a particle by more than this multiple of arc *
// sqrt(number of free particles). Such a correction leads away from the path.
constexpr double longest_arc_correction = 5;

// Follows the path of equilibria F(x) + lambda q(x) = 0 by points that lie one arc apart (Crisfield
// 1981). The arc length is cylindrical: the RMS displacement of free particles. Each correction
// solves the linearised equilibrium and the constraint on the arc length together, by two solves
// with one factorisation. The predictor is the displacement per load factor, scaled to one arc. Its
// sign makes its product with the last step not negative. Without a last step, the load factor
// increases.
class ArcLengthIntegrator final : public OneStepIntegrator {
 public:
  ArcLengthIntegrator(const Scene& scene, Dynamics& dynamics)
      : OneStepIntegrator(scene, dynamics),
        options_(scene.source.equilibria),
        newton_(scene, dynamics),
        path_(dynamics),
        load_(dynamics.particle_count()),
        by_load_(dynamics.particle_count()),
        by_residual_(dynamics.particle_count()),
        step_(dynamics.particle_count()) {
    for (int i = 0; i < scene.dynamic_particles; ++i) free_ += scene.is_free(i) ? 1 : 0;
    set_factor(0);
  }

  int last_order() const override { return 0; }
  void transfer(StateArchive& archive) override {
    transfer_steps(archive);
    newton_.transfer(archive);
    archive(factor_, arc_, first_arc_, longest_arc_, direction_, start_, negative_, has_ended_,
            corrections_);
    if (archive.reads()) set_factor(factor_);
  }
  IntegratorCounts counts() const override {
    IntegratorCounts counts = OneStepIntegrator::counts();
    counts.newton_iterations = newton_.iterations() + corrections_;
    counts.linear_setups = newton_.factorisations();
    return counts;
  }
  std::optional<PathPoint> path_point() const override { return PathPoint{factor_, negative_}; }
  bool has_ended() const override { return has_ended_; }

 private:
  bool checks_its_own_path() const override { return true; }
  void forget() override { direction_.clear(); }

  void set_factor(double factor) {
    dynamics().set_load_factor(factor);
    dynamics().set_load(options_.scale_gravity ? factor : 1);
  }

  Trouble attempt(double& end, std::span<double> y) override {
    Trouble trouble = Trouble::none;
    if (first_arc_ == 0) {
      trouble = begin_path(end, y);
      if (trouble != Trouble::none) {
        end = time();
        return trouble;
      }
    }
    while (!should_stop()) {
      trouble = find_point(end, y);
      if (trouble == Trouble::none) return trouble;
      arc_ /= 2;
      if (arc_ < smallest_arc * first_arc_) break;
    }
    set_factor(factor_);
    end = time();  // ends the run: a step of length 0 cannot be halved
    return trouble;
  }

  // Finds the equilibrium at load factor 0 and the length of the first arc.
  Trouble begin_path(double end, std::span<double> y) {
    for (const bool careful : {false, true}) {
      begin_trial(y);
      const auto found = newton_.solve({end, careful, [this] { return should_stop(); }}, y, path_);
      if (found != EquilibriumNewton::End::converged) continue;
      start_.assign(y.begin(), y.end());
      if (!find_load_direction(end, y)) break;
      first_arc_ = arc_ = options_.first_load_factor * length(by_load_);
      longest_arc_ = options_.largest_step.value_or(default_largest_arc * arc_);
      arc_ = std::min(arc_, longest_arc_);
      if (arc_ > 0 && std::isfinite(arc_)) return Trouble::none;
    }
    first_arc_ = 0;
    is_beginning_ = true;
    return name_trouble();
  }

  // Sets `y` to the last point of the path, at rest. Before the first point, that is the
  // equilibrium at load factor 0 or, if unknown, the initial state. path_ starts at the last
  // accepted positions.
  void begin_trial(std::span<double> y) {
    const std::span<const double> from = start_.empty() || time() > 0 ? state() : start_;
    const auto half = static_cast<std::ptrdiff_t>(y.size() / 2);
    std::copy(from.begin(), from.begin() + half, y.begin());
    std::fill(y.begin() + half, y.end(), 0.0);
    path_.start(time(), positions());
  }

  // Solves K by_load_ = q at `y`, with the tangent K at the present load factor and the loads q of
  // factor 1. Returns false if the forces cannot be evaluated or K is singular.
  bool find_load_direction(double time, std::span<const double> y) {
    return newton_.evaluate(time, y) && newton_.factorise(time, y) && solve_load(time, y);
  }
  bool solve_load(double time, std::span<const double> y) {
    const double factor = trial_factor_;
    dynamics().set_load_factor(1);
    dynamics().applied_loads(time, y, options_.scale_gravity, load_);
    dynamics().set_load_factor(factor);
    return newton_.factors().solve(load_, by_load_);
  }

  Trouble find_point(double end, std::span<double> y) {
    begin_trial(y);
    trial_factor_ = factor_;
    set_factor(factor_);
    if (!find_load_direction(end, y)) return name_trouble();
    negative_ = newton_.negative_directions();
    const double sign = direction_.empty() || mean_product(direction_, by_load_) >= 0 ? 1 : -1;
    const double part = sign * arc_ / length(by_load_);
    for (std::size_t i = 0; i < step_.size(); ++i) step_[i] = part * by_load_[i];
    move(y, step_, part);
    for (int i = 0; i < most_corrections && !should_stop(); ++i) {
      const double moved = correct(end, y);
      // The negated comparison also rejects a move that is not a number.
      if (!(moved <= longest_arc_correction * arc_ * std::sqrt(static_cast<double>(free_))))
        return name_trouble();
      if (!newton_.evaluate(end, y)) return name_trouble();
      if (newton_.is_converged(end, y, moved)) return accept_point(end, y, i + 1);
    }
    return name_trouble();
  }

  // Applies one correction to `y` and the load factor. Returns the largest displacement (m) of a
  // particle, or infinity if the correction cannot be computed.
  double correct(double end, std::span<double> y) {
    ++corrections_;
    constexpr double none = std::numeric_limits<double>::infinity();
    if (!newton_.evaluate(end, y) || !newton_.factorise(end, y) || !solve_load(end, y) ||
        !newton_.factors().solve(newton_.residual(), by_residual_))
      return none;
    const double excess = 0.5 * (mean_product(step_, step_) - arc_ * arc_);
    const double change =
        -(excess + mean_product(step_, by_residual_)) / mean_product(step_, by_load_);
    for (std::size_t i = 0; i < step_.size(); ++i) {
      by_residual_[i] += change * by_load_[i];
      step_[i] += by_residual_[i];
    }
    move(y, by_residual_, change);
    return largest_length(by_residual_);
  }

  void move(std::span<double> y, const std::vector<Vec3>& way, double change) {
    auto* const x = reinterpret_cast<Vec3*>(y.data());
    for (std::size_t i = 0; i < way.size(); ++i) x[i] += way[i];
    trial_factor_ += change;
    set_factor(trial_factor_);
  }

  Trouble accept_point(double end, std::span<double> y, int corrections) {
    set_fault(path_.move_to(end, y));
    if (fault()) return trouble_of_fault();
    factor_ = trial_factor_;
    negative_ = newton_.negative_directions();
    direction_ = step_;
    const double change = std::sqrt(static_cast<double>(wanted_corrections) / corrections);
    arc_ = std::min(longest_arc_, arc_ * std::clamp(change, 1 / largest_change, largest_change));
    has_ended_ = reaches_end(y);
    return Trouble::none;
  }

  bool reaches_end(std::span<const double> y) const {
    if (options_.largest_load_factor && factor_ >= *options_.largest_load_factor) return true;
    if (!options_.largest_displacement) return false;
    return dynamics().largest_displacement(StateView::of(y).position) >=
           *options_.largest_displacement;
  }

  Trouble name_trouble() {
    set_fault(newton_.fault());
    set_place(newton_.factors().weakest_particle());
    return fault() ? trouble_of_fault() : Trouble::not_converged;
  }

  Failure final_failure(Trouble trouble) const override {
    if (trouble != Trouble::not_converged) return OneStepIntegrator::final_failure(trouble);
    const std::string where =
        place() < 0 ? "" : ", weakest at " + scene().describe_particle(place());
    const std::string factor = "load factor " + rounded_text(factor_);
    const std::string what =
        is_beginning_ ? "no path of equilibria begins at the unloaded shape: its tangent stiffness "
                        "is singular or no equilibrium is near"
                      : "the path of equilibria is lost beyond the " + factor +
                            " at t = " + rounded_text(time()) +
                            " s: no arc is short enough, and the tangent stiffness has " +
                            std::to_string(negative_) + " negative directions";
    return {Failure::Kind::newton, time(), place(), what + where};
  }

  // Returns the mean of a_i . b_i (m^2) over the free particles.
  double mean_product(const std::vector<Vec3>& a, const std::vector<Vec3>& b) const {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
    return sum / free_;
  }
  double length(const std::vector<Vec3>& way) const { return std::sqrt(mean_product(way, way)); }

  const StaticCase& options_;
  EquilibriumNewton newton_;
  SafePath path_;
  int free_ = 0;  // number of free particles
  double factor_ = 0, trial_factor_ = 0;
  double arc_ = 0, first_arc_ = 0, longest_arc_ = 0;  // m
  // Displacements of the last step (m); empty before the first step and after a restart.
  std::vector<Vec3> direction_;
  std::vector<double> start_;  // the equilibrium at load factor 0; empty if unknown
  int negative_ = 0;           // number of negative eigenvalues of the tangent
  bool has_ended_ = false, is_beginning_ = false;
  std::int64_t corrections_ = 0;
  std::vector<Vec3> load_, by_load_, by_residual_, step_;
};

}  // namespace

std::unique_ptr<Integrator> make_arc_length_integrator(const Scene& scene, Dynamics& dynamics) {
  return std::make_unique<ArcLengthIntegrator>(scene, dynamics);
}

}  // namespace weft::sim
