// One cell of the stability grid: a case, run in a process of its own and judged.
//
// Every state that is looked at is checked, 25 in a run (200 where obstacles or pins move)
// and its last one:
// - positions and velocities are finite;
// - there is no more energy than was put in (sim/motion/energy_watch.h). A run looks at this
//   after each of its steps and fails by itself; what passes it and is found here is wrong;
// - with contact, no triangle passes through another (crossings.h, exact), and, where obstacles are
//   at rest, the first surface of two has not come out on the other side of the second;
// - without contact, pins and gravity, the momentum is that of the start, to an error of the
//   tolerance in every component and one thousandth;
// - a run that gets to its end is inexact, whatever its own watch says, when it is further from a
//   converged run of the same case (stability_reference.h) than `strayed_share` of how far that
//   has moved (root mean squares over the particles), beside a hundred times its tolerance and what
//   is known of the converged run; or when more than `lost_share` of the largest kinetic energy has
//   gone, where nothing damps, touches or moves it;
// - at the end of a static run, the root mean square of the accelerations left is at most a
//   thousandth of gravity.
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

// In the order of the legend. From `too_slow` on: forbidden.
enum class Outcome {
  finished,
  inexact,  // has come to its end, far from a converged run or without much of its energy
  refused,
  failed,
  limited,   // the run has ended at its compute.cpu_limit, and says so
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
  std::string message;  // of the run, or what the check has found; empty where it finished
  double cpu = 0;       // s
  double reached = 0;   // s, simulated
  double energy = 0;    // largest share of what the watch allows, at the states looked at
  std::int64_t steps = 0;
  // NaN where nothing is known: m, from the converged run; share of the largest kinetic energy.
  double error = std::numeric_limits<double>::quiet_NaN();
  double lost = std::numeric_limits<double>::quiet_NaN();
};

// Checks the states of a scene. Has dynamics of its own and leaves the integrator's alone.
class Judge {
 public:
  explicit Judge(const sim::Scene& scene);
  // Returns what is wrong with the state `y` at `time` (s), for the outcome `wrong`; nothing if it
  // is right.
  [[nodiscard]] std::optional<std::string> check(double time, std::span<const double> y);
  // Returns what is wrong with the forces left at the end of a static run; nothing if they are
  // small.
  [[nodiscard]] std::optional<std::string> check_rest(double time, std::span<const double> y);
  double largest_share() const { return energy_watch_.largest_share(); }
  // Returns the share of the largest kinetic energy of the checked states that is gone at `y`; NaN
  // where something may take it: damping, air, contact, moving pins or obstacles.
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

// Returns what makes the end `y` of a run with a tolerance (m; 0: none) inexact, in words; empty if
// nothing does. Sets result.error and result.lost.
std::string inexactness(const sim::Scene& scene, Judge& judge, const ConvergedEnd* converged,
                        double tolerance, double time, std::span<const double> y,
                        CellResult& result);

// True if obstacles or pins move.
bool something_is_moved(const sim::Scene& scene);
bool all_finite(std::span<const double> y);
// True if the message of a failure is clear: it names the body or obstacle, or the refused part of
// the case, and the time.
bool is_clear(const std::string& failure);

// Runs `weft run PATH --set ...` without its trajectory for each cell, `jobs` at a time, each in a
// child process. Its compute.cpu_limit is `limit` (s) times the size of the cell. A child that has
// not come back from one step after several times that is ended. Returns the results in the order
// of the cells, compared with `converged`; `done` is told of each as it ends.
std::vector<CellResult> run_cells(std::span<const Cell> cells, const ConvergedEnds& converged,
                                  double limit, int jobs,
                                  const std::function<void(const Cell&, const CellResult&)>& done);

}  // namespace weft::bench
