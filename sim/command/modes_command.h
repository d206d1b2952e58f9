// The commands `weft modes` and `weft buckling`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/base/bill.h"
#include "sim/base/failure.h"
#include "sim/command/run_command.h"

namespace weft::sim {

struct ModesCommand {
  RunCommand run;            // common options; run.directory is used only if `writes`
  int count = 10;            // number of modes
  bool writes = false;       // if true, writes a trajectory of the modes
  int frames_per_mode = 1;   // number of frames that show each mode in the trajectory
  bool start_shape = false;  // `weft modes`: if true, the modes are about the start shape
  double load_factor = 0;    // `weft buckling`: load factor of the equilibrium
};

// Computes natural modes about the equilibrium or the start shape of a case, and prints their
// frequencies. With `writes`, the trajectory is DIRECTORY/NAME_modes.h5, where NAME is the name of
// the case file without its extension. Returns the exit code.
int show_modes(const ModesCommand& command);
// Computes critical load factors, and prints them. With `writes`, the trajectory is
// DIRECTORY/NAME_buckling.h5, with NAME as for show_modes(). Returns the exit code.
int show_buckling(const ModesCommand& command);

// The results of `weft modes` or `weft buckling` apart from the modes themselves.
struct ModesReport {
  std::string title;
  std::string about;       // state about which the modes are: "equilibrium" or "start_shape"
  double time = 0;         // time of the state (s)
  double imbalance = 0;    // CaseEquilibrium::imbalance() of the state
  double load_factor = 1;  // load factor of the state
  Cost cost;               // cost of the process so far
  std::string trajectory;  // path of the trajectory; empty if none was written
  std::vector<std::string> warnings;  // left_out_forces() of the state
  std::optional<Failure> failure;
};

}  // namespace weft::sim
