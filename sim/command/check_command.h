// The command `weft check`.
#pragma once

#include <string>

#include "sim/command/run_command.h"

namespace weft::sim {

struct CheckCommand {
  RunCommand run;         // the case, its overrides, and whether files are overwritten
  std::string picture;    // PNG of the initial state to write; or empty
  std::string new_start;  // HDF5 file for the start of bodies that intersect slightly; or empty
};

// Checks a case. Prints what its scene needs and which parts of the computation it skips. Draws the
// initial state, whether it can be simulated or not, and repairs it, if the command asks for these.
// The case is never changed. Returns the exit code.
int check_case(const CheckCommand& command);

}  // namespace weft::sim
