// `weft modes` and `weft buckling`.
#pragma once

#include <optional>
#include <string>

#include "sim/base/bill.h"
#include "sim/base/failure.h"
#include "sim/command/run_command.h"

namespace weft::sim {

struct ModesCommand {
  RunCommand run;            // its folder is used only with `writes`
  int count = 10;            // number of modes
  bool writes = false;       // writes a trajectory of the modes
  int frames_per_mode = 1;   // in the trajectory
  bool start_shape = false;  // `weft modes`: about the start shape
  double load_factor = 0;    // `weft buckling`: of the equilibrium
};

// Computes natural modes about the equilibrium of a case, and prints their frequencies. The
// trajectory is DIRECTORY/NAME_modes.h5. Returns the exit code.
int show_modes(const ModesCommand& command);
// Computes critical load factors, and prints them. The trajectory is DIRECTORY/NAME_buckling.h5.
// Returns the exit code.
int show_buckling(const ModesCommand& command);

// The members of the `--json` object other than the modes.
struct ModesReport {
  std::string title;
  std::string about;       // the state: "equilibrium" or "start_shape"
  double time = 0;         // s, of the state
  double imbalance = 0;    // CaseEquilibrium::imbalance()
  double load_factor = 1;  // of the state
  Cost cost;               // of the process so far
  std::string trajectory;  // path; empty: none written
  std::optional<Failure> failure;
};

}  // namespace weft::sim
