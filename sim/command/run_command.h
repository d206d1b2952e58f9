// The command `weft run`, and the exit codes of all commands.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/base/bill.h"
#include "sim/base/stopwatch.h"

namespace weft::sim {

struct RunCommand {
  std::string case_path;
  std::string directory = "out";
  std::vector<std::string> overrides;  // "KEY=VALUE" (see read_case())
  bool force = false;                  // overwrites an existing trajectory
  bool resume = false;                 // goes on from the checkpoint of an earlier run
  std::string restart_from;            // trajectory whose state the bodies start in; or empty
  std::optional<double> restart_time;  // s; time of this state
  std::optional<double> extend;        // s; goes on to this duration, beyond that of the run
  bool json = false;                   // prints results as one JSON object
  bool quiet = false;                  // prints no progress
  bool estimate_error = false;         // runs a second, more exact simulation to measure the error
  Stopwatch started = Stopwatch::since_process_start();
};

// Exit codes of the weft command.
namespace exit_code {
inline constexpr int done = 0;
inline constexpr int numerical_failure = 1;
inline constexpr int bad_case = 2;
inline constexpr int some_runs_failed = 3;
inline constexpr int input_output = 4;
}  // namespace exit_code

// Runs a case. Writes the trajectory DIRECTORY/NAME.h5, where NAME is the name of the case file
// without its extension. Prints results on standard output, progress and errors on standard error.
// Returns the exit code: one of exit_code or, after a signal, 130 (SIGINT) or 143 (SIGTERM).
int run_case(const RunCommand& command);

}  // namespace weft::sim
