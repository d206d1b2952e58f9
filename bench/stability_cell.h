// One cell of the stability grid: a case, run in a separate process and judged.
//
// 25 states of a run (200 if obstacles or pins move) and its last one are checked:
// - positions and velocities are finite;
// - there is no more energy than was put in (sim/motion/energy_watch.h). A run checks this
//   as it goes and fails by itself; an excess that is only found here makes the outcome `wrong`;
// - with contact, no triangle passes through another (crossings.h, exact), and, if obstacles are at
//   rest, the first of two surfaces has not come out on the other side of the second;
// - without contact, pins and gravity, the momentum is that of the start, up to an error of the
//   tolerance in every component and one thousandth;
// - at the end of a static run, the root mean square of the remaining accelerations is at most a
//   thousandth of gravity.
// A run that finishes is `inexact` in two cases, whatever its own watch says. Either its distance
// from a converged run of the same case (stability_reference.h) exceeds `strayed_share` of the
// distance which that has moved (root mean squares over the particles); a hundred times its
// tolerance and the uncertainty of the converged run are allowed on top. Or more than `lost_share`
// of the largest kinetic energy is lost although nothing damps, touches or moves it.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/stability_grid.h"
#include "bench/stability_reference.h"
#include "sim/integrator/integrator.h"
#include "sim/motion/energy_watch.h"

namespace weft::bench {

// Outcomes in the order of the legend; those from `too_slow` on are forbidden.
enum class Outcome {
  finished,
  inexact,  // finished far from a converged run, or with much energy lost
  refused,
  failed,
  limited,   // the run ended at its compute.cpu_limit, and reports it
  too_slow,  // has taken more than most_medians, however it ended; found when all have run, unless
             // a limit was given
  hung,
  not_finite,
  wrong,
  unclear,
  crashed
};
inline constexpr int outcome_count = 11;
inline constexpr double most_medians = 50;
inline constexpr double strayed_share = 0.1, lost_share = 0.2;
const char* outcome_name(Outcome outcome);
inline bool is_forbidden(Outcome outcome) { return outcome >= Outcome::too_slow; }

struct CellResult {
  Outcome outcome = Outcome::crashed;
  std::string message;  // of the run or of the check; empty if it finished
  double cpu = 0;       // s
  double reached = 0;   // s, simulated
  double energy = 0;    // largest share of the watch's limit, at the checked states
  std::int64_t steps = 0;
  // Distance from the converged run (m), and lost share of the largest kinetic energy; NaN if
  // unknown.
  double error = std::numeric_limits<double>::quiet_NaN();
  double lost = std::numeric_limits<double>::quiet_NaN();
};

// Checks the states of a scene. It has its own dynamics and does not touch the integrator's.
class Judge {
 public:
  explicit Judge(const sim::Scene& scene);
  // Returns the fault of the state `y` at `time` (s), for the outcome `wrong`; empty if there is
  // none.
  [[nodiscard]] std::optional<std::string> check(double time, std::span<const double> y);
  // Returns the fault of the remaining forces at the end of a static run; empty if they are small.
  [[nodiscard]] std::optional<std::string> check_rest(double time, std::span<const double> y);
  double largest_share() const { return energy_watch_.largest_share(); }
  // Returns the share of the largest kinetic energy of the checked states that is lost at `y`. NaN
  // if something may take it: damping, air, contact, moving pins or obstacles.
  double energy_lost(double time, std::span<const double> y);

 private:
  std::optional<std::string> check_surfaces(double time, std::span<const double> y);
  std::optional<std::string> check_momentum(std::span<const double> y) const;
  sim::Vec3 momentum(std::span<const double> y) const;

  const sim::Scene& scene_;
  sim::Statistics statistics_;
  sim::Dynamics dynamics_;
  double mass_;  // kg, of all dynamic particles
  bool keeps_momentum_, keeps_energy_;
  double most_kinetic_ = 0;  // J
  sim::Energies start_;
  sim::Vec3 start_momentum_;
  sim::EnergyWatch energy_watch_;
  std::vector<sim::Vec3> position_, velocity_;
};

// Returns the reason why the end `y` of a run with a tolerance (m; 0: none) is inexact; empty if it
// is not. Sets result.error and result.lost.
std::string inexactness(const sim::Scene& scene, Judge& judge, const ConvergedEnd* converged,
                        double tolerance, double time, std::span<const double> y,
                        CellResult& result);

// True if obstacles or pins move.
bool something_is_moved(const sim::Scene& scene);
bool all_finite(std::span<const double> y);
// True if the message of a failure is clear: it names the time and the body or obstacle, or the
// part of the case that was refused.
bool is_clear(const std::string& failure);

// Runs `weft run PATH --set ...` without its trajectory for each cell, `jobs` at a time, each in a
// child process. Its compute.cpu_limit is `limit` (s) times the size of the cell. A child whose
// step takes several times that is killed. Returns the results in the order of the cells, compared
// with `converged`; calls `done` as each ends.
std::vector<CellResult> run_cells(std::span<const Cell> cells, const ConvergedEnds& converged,
                                  double limit, int jobs,
                                  const std::function<void(const Cell&, const CellResult&)>& done);

}  // namespace weft::bench
