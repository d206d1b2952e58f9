// Delivery of results, and commands that read untrusted files in a process of their own.
#pragma once

#include <functional>
#include <string>

namespace weft::sim {

// Flushes standard output and returns `code`. If results cannot be written, prints a message and
// returns exit_code::input_output.
int deliver(int code);

// A command that reads `path`. run_guarded() runs it in a separate process (reading_process.h) and
// returns its exit code. If the process crashes, run_guarded() prints a message that names the file
// and returns exit_code::input_output.
struct GuardedCommand {
  std::string path;
  bool draws = false;    // the command draws; a crash may then have another cause than the file
  bool json = false;     // also prints the message to standard output, as a JSON object
  bool is_long = false;  // the command computes; the CPU limit for reading does not apply
  std::function<int()> run;
};
int run_guarded(const GuardedCommand& command);

// Prints `text` as a line on standard error, with control characters escaped.
void complain(const std::string& text);

}  // namespace weft::sim
