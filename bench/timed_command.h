// The CPU time of a whole command.
#pragma once

#include <string>
#include <vector>

namespace weft::bench {

struct TimedCommand {
  bool is_well = false;  // it exited with code 0
  double cpu_s = 0;      // user and system time of the process and the children it waited for
  std::string output;    // standard output and standard error
};

// Runs a program, found by PATH unless it has a '/', in a folder and on one thread
// (OMP_NUM_THREADS = 1). Its output goes to the file `output.txt` of the folder. Throws
// std::system_error if no process can be started.
TimedCommand run_command(const std::vector<std::string>& words, const std::string& folder);

// Returns the path of the `weft` of this build or installation. Throws std::runtime_error if it is
// not there.
std::string weft_command();

// Returns true if PATH has such a program.
bool is_installed(const std::string& program);

}  // namespace weft::bench
