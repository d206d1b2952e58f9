// Shared by the commands: delivery of results, and commands that read files of others.
#pragma once

#include <functional>
#include <string>

namespace weft::sim {

// Flushes standard output and returns `code`, or exit_code::input_output, with a message, when
// results could not be delivered.
int deliver(int code);

// Runs a command that reads `path` in a process of its own (reading_process.h) and returns its exit
// code; exit_code::input_output, with a message that names the file, when it crashed.
struct GuardedCommand {
  std::string path;
  bool draws = false;    // the command uses OpenGL, which may be what crashed
  bool json = false;     // the message goes to standard output, too, as an object
  bool is_long = false;  // it computes, so that its CPU time is not limited as that of reading is
  std::function<int()> run;
};
int run_guarded(const GuardedCommand& command);

// Prints `text` on standard error with control characters escaped, and ends the line.
void complain(const std::string& text);

}  // namespace weft::sim
