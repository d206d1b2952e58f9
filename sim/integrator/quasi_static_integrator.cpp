#include <algorithm>
#include <vector>

#include "sim/case/case_text.h"
#include "sim/integrator/equilibrium_newton.h"
#include "sim/integrator/integrator_makers.h"
#include "sim/integrator/one_step_integrator.h"
#include "sim/integrator/relaxation.h"

namespace weft::sim {

namespace {

// Shortest step as a fraction of the time between frames.
constexpr double shortest_increment = 1.0 / 1024;
// Longest first step that may use a homotopy or a relaxation, as a fraction of the time between
// frames.
constexpr double increment_of_first = 1.0 / 16;
// Fractions of the initial imbalance that a step of a homotopy removes: its first step, and the
// smallest step tried.
constexpr double first_homotopy_step = 0.25, least_homotopy_step = 1.0 / 256;
// Longest extrapolation of the last step, in lengths of that step.
constexpr double longest_extrapolation = 2.5;
// An equilibrium that was reached through unstable states is on another branch if the largest
// distance of a particle exceeds `farthest_stray` times the expected one. The expected distance is
// that of the extrapolated last step plus `least_stray` times the size of the bodies. Near a limit
// point, the displacements of equal load steps grow by a factor of up to 2.4.
constexpr double farthest_stray = 4, least_stray = 1e-3;

// Finds one equilibrium per step, by Newton's method from the previous equilibrium or a prediction.
// For the first equilibrium and beyond limit points, also tries other searches.
class QuasiStaticIntegrator final : public OneStepIntegrator {
 public:
  QuasiStaticIntegrator(const Scene& scene, Dynamics& dynamics)
      : OneStepIntegrator(scene, dynamics),
        newton_(scene, dynamics),
        relaxation_(scene, dynamics),
        path_(dynamics),
        scratch_(dynamics.state_size()),
        product_(dynamics.particle_count()),
        way_(dynamics.particle_count()) {
    dynamics.set_load(1);
  }

  int last_order() const override { return 0; }
  void transfer(StateArchive& archive) override {
    transfer_steps(archive);
    newton_.transfer(archive);
    relaxation_.transfer(archive);
    archive(found_first_, known_time_, known_, earlier_time_, earlier_, negative_);
  }
  IntegratorCounts counts() const override {
    IntegratorCounts counts = OneStepIntegrator::counts();
    counts.newton_iterations = newton_.iterations() + relaxation_.newton_iterations();
    counts.linear_iterations = relaxation_.linear_iterations();
    counts.linear_setups = newton_.factorisations() + relaxation_.newton_iterations();
    return counts;
  }
  std::optional<PathPoint> path_point() const override { return PathPoint{1, negative_}; }

 private:
  using End = EquilibriumNewton::End;

  bool checks_its_own_path() const override { return true; }
  double shortest_step() const override {
    return std::max(scene().source.time.minimum_step,
                    shortest_increment / scene().source.time.frames_per_second);
  }
  void forget() override {
    known_.clear();
    earlier_.clear();
    found_first_ = false;
  }
  bool jumps() const { return scene().source.equilibria.at_limit_point == AtLimitPoint::jump; }

  Trouble attempt(double& end, std::span<double> y) override {
    note_last_step();
    newton_.forget_signs();
    set_fault({});
    End found = End::diverged;
    for (const bool careful : {false, true}) {
      if (!begin_search(end, careful, y)) return trouble_of_fault();
      found = search(end, careful, y);
      if (found == End::converged && is_elsewhere(end, y)) found = End::diverged;
      if (found == End::converged) return accept_equilibrium();
      if (found == End::stopped) return Trouble::not_converged;
    }
    is_singular_ = found == End::singular;
    weakest_ = newton_.factors().weakest_particle();
    if (search_elsewhere(end, y)) return accept_equilibrium();
    set_place(is_singular_ ? weakest_ : newton_.worst_particle());
    if (found != End::blocked) return Trouble::not_converged;
    set_fault(newton_.fault());
    return trouble_of_fault();
  }

  // True if an equilibrium was reached through states with more negative directions than both ends
  // of the step, and lies far from the extrapolated last step. It then lies on another branch,
  // beyond a limit point.
  bool is_elsewhere(double end, std::span<const double> y) const {
    if (earlier_.empty()) return false;
    if (newton_.most_negative_directions() <= std::max(negative_, newton_.negative_directions()))
      return false;
    const double lengths = (end - known_time_) / (known_time_ - earlier_time_);
    const double expected = lengths * largest_move(earlier_, known_) + least_stray * newton_.size();
    return largest_move(known_, y) > farthest_stray * expected;
  }
  // Returns the largest distance (m) of a particle between two states.
  static double largest_move(std::span<const double> from, std::span<const double> to) {
    const StateView first = StateView::of(from), second = StateView::of(to);
    double largest = 0;
    for (std::size_t i = 0; i < first.position.size(); ++i)
      largest = std::max(largest, (second.position[i] - first.position[i]).norm());
    return largest;
  }

  Trouble accept_equilibrium() {
    found_first_ = true;
    negative_ = newton_.negative_directions();
    set_fault({});
    return Trouble::none;
  }

  End search(double end, bool careful, std::span<double> y) {
    return newton_.solve({end, careful, [this] { return should_stop(); }}, y, path_);
  }

  // Stores the states at both ends of the last step, from which the next equilibrium is
  // extrapolated.
  void note_last_step() {
    if (!known_.empty() && known_time_ == time()) return;
    earlier_.swap(known_);
    earlier_time_ = known_time_;
    known_.assign(state().begin(), state().end());
    known_time_ = time();
    if (!found_first_) earlier_.clear();
  }

  // Sets `y` to the start of a search: the prediction for `end` or, if there is no prediction or
  // surfaces block it, the last state. A careful search predicts by follow_pins() only. Returns
  // false if surfaces also block the prescribed motion alone.
  bool begin_search(double end, bool careful, std::span<double> y) {
    for (const bool predicted : {true, false}) {
      const auto half = static_cast<std::ptrdiff_t>(y.size() / 2);
      std::copy(state().begin(), state().begin() + half, y.begin());
      std::fill(y.begin() + half, y.end(), 0.0);
      path_.start(time(), positions());
      if (predicted && !(careful ? follow_pins(end, y) : predict(end, y))) continue;
      set_fault(path_.move_to(end, y));
      if (!fault()) return true;
    }
    return false;
  }

  // Extrapolates the last step. If that is unknown, or `end` is too far away, calls follow_pins().
  bool predict(double end, std::span<double> y) {
    const double last = known_time_ - earlier_time_, now = end - known_time_;
    if (earlier_.empty() || now > longest_extrapolation * last) return follow_pins(end, y);
    for (std::size_t i = 0; i < y.size() / 2; ++i) y[i] += now / last * (known_[i] - earlier_[i]);
    return true;
  }

  // Moves free particles by the prediction of the tangent at the last state, for the displacements
  // of pins until `end`. Returns false if no pin moves or there is no prediction.
  bool follow_pins(double end, std::span<double> y) {
    if (!dynamics().pins_move()) return false;
    scratch_.assign(state().begin(), state().end());
    dynamics().place_pins(end, scratch_);
    const StateView moved = StateView::of(scratch_);
    std::vector<double> now(state().begin(), state().end());
    dynamics().place_pins(time(), now);
    const StateView placed = StateView::of(now);
    for (std::size_t i = 0; i < way_.size(); ++i) way_[i] = moved.position[i] - placed.position[i];
    if (largest_length(way_) == 0) return false;
    if (!newton_.evaluate(time(), now) || !newton_.factorise(time(), now)) return false;
    dynamics().stiffness().multiply(way_, product_, dynamics().threads());
    for (Vec3& force : product_) force = -force;
    if (!newton_.factors().solve(product_, way_)) return false;
    auto* const x = reinterpret_cast<Vec3*>(y.data());
    for (std::size_t i = 0; i < way_.size(); ++i) x[i] += way_[i];
    return true;
  }

  // Searches far from the last state, for the first equilibrium or for one beyond a limit point.
  // Returns false without a search if the step is too long for that.
  bool search_elsewhere(double end, std::span<double> y) {
    const double frame = 1 / scene().source.time.frames_per_second;
    const double longest =
        found_first_ ? (jumps() ? 1.5 * shortest_step() : 0) : 1.001 * increment_of_first * frame;
    if (end - time() > longest) return false;
    if (!found_first_ && remove_imbalance(end, y)) return true;
    if (should_stop() || !begin_search(end, true, y)) return false;
    const double acceleration = applied_acceleration(dynamics(), end, y);
    const Relaxation::End relaxed =
        relaxation_.relax({end, acceleration, true, [this] { return should_stop(); }}, y, path_);
    set_fault(relaxation_.fault());
    if (relaxed != Relaxation::End::at_rest) return false;
    scratch_.assign(y.begin(), y.end());
    for (const bool careful : {false, true}) {
      std::ranges::copy(scratch_, y.begin());
      if (search(end, careful, y) != End::converged) continue;
      // The next equilibrium is not extrapolated across the jump to this one.
      known_.clear();
      return true;
    }
    return false;
  }

  // Searches for the first equilibrium by a homotopy, which gradually removes the imbalance at its
  // start.
  bool remove_imbalance(double end, std::span<double> y) {
    if (!begin_search(end, true, y)) return false;
    newton_.keep({});
    if (!newton_.evaluate(end, y)) return false;
    const std::vector<Vec3> imbalance = newton_.residual();
    double removed = 0, step = first_homotopy_step;
    while (removed < 1 && step >= least_homotopy_step && !should_stop()) {
      const double next = std::min(1.0, removed + step);
      std::vector<Vec3> kept = imbalance;
      for (Vec3& force : kept) force *= 1 - next;
      newton_.keep(std::move(kept));
      scratch_.assign(y.begin(), y.end());
      if (search(end, false, y) == End::converged) {
        removed = next;
        step *= 1.5;
      } else {
        std::ranges::copy(scratch_, y.begin());
        step /= 2;
      }
    }
    newton_.keep({});
    return removed == 1;
  }

  Failure final_failure(Trouble trouble) const override {
    if (trouble != Trouble::not_converged) return OneStepIntegrator::final_failure(trouble);
    const bool is_limit = found_first_ && newton_.most_negative_directions() > negative_;
    std::string text = "no equilibrium is found beyond the load at t = " + rounded_text(time()) +
                       " s: the tangent stiffness ";
    if (is_limit) {
      text +=
          "has a negative direction there, as at a limit point; the forces are farthest from "
          "balance at " +
          scene().describe_particle(place()) +
          " (static.loading = \"arc_length\" follows the path of a load, "
          "static.at_limit_point = \"jump\" leaves it)";
    } else if (is_singular_) {
      text += "is singular; it is weakest at " + scene().describe_particle(place());
    } else {
      text +=
          "has no negative direction, and Newton's method does not converge; the forces are "
          "farthest from balance at " +
          scene().describe_particle(place());
    }
    return {Failure::Kind::newton, time(), place(), text};
  }

  EquilibriumNewton newton_;
  Relaxation relaxation_;
  SafePath path_;
  bool found_first_ = false;  // true once an equilibrium is known
  bool is_singular_ = false;  // true if the last search ended at a singular tangent
  int negative_ = 0;          // number of negative eigenvalues at the last equilibrium
  int weakest_ = -1;          // particle at which the last tangent is weakest
  double known_time_ = 0, earlier_time_ = 0;  // times of known_ and earlier_ (s)
  std::vector<double> known_, earlier_;       // states at the end and start of the last step
  std::vector<double> scratch_;
  std::vector<Vec3> product_, way_;
};

}  // namespace

std::unique_ptr<Integrator> make_quasi_static_integrator(const Scene& scene, Dynamics& dynamics) {
  return std::make_unique<QuasiStaticIntegrator>(scene, dynamics);
}

}  // namespace weft::sim
