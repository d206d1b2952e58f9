// `weft run` and `weft check`.
#pragma once

#include <string>
#include <vector>

#include "sim/base/bill.h"
#include "sim/base/stopwatch.h"

namespace weft::sim {

struct RunCommand {
  std::string case_path;
  std::string directory = "out";
  std::vector<std::string> overrides;  // key=value
  bool force = false;
  bool json = false;
  bool quiet = false;
  bool estimate_error = false;
  Stopwatch started = Stopwatch::since_process_start();
};

// Exit codes of the weft command.
namespace exit_code {
inline constexpr int done = 0;
inline constexpr int numerical_failure = 1;
inline constexpr int bad_case = 2;
inline constexpr int input_output = 4;
}  // namespace exit_code

// Runs a case. The trajectory is DIRECTORY/NAME.h5, with the name of the case file. Results go to
// standard output, progress and errors to standard error. Returns the exit code: 130 after SIGINT,
// 143 after SIGTERM.
int run_case(const RunCommand& command);
// Prints what the scene needs, and which parts of the computation it skips.
int check_case(const RunCommand& command);

}  // namespace weft::sim
