// Functions that run commands: faults become messages and exit codes, and untrusted files are read
// in a separate process.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "sim/command/run_command.h"

namespace weft::sim {

// Flushes standard output and returns `code`. If this fails, prints a message and returns
// exit_code::input_output.
int deliver(int code);

// A command that reads the file `path`, for run_guarded().
struct GuardedCommand {
  std::string path;
  bool draws = false;        // true if the command draws, so that drawing may cause a crash
  bool json = false;         // true if standard output gets messages as JSON objects
  bool is_long = false;      // true if the command has no CPU time limit
  std::function<int()> run;  // runs the command and returns its exit code
};
// Runs the command in a separate process (sim/base/reading_process.h) and returns its exit code. If
// a signal ends the process, prints a message that names the file and returns
// exit_code::input_output. After SIGPIPE, which says nothing about the file, this process ends by
// that signal, too.
int run_guarded(const GuardedCommand& command);

// Calls run(title) and returns its exit code. `run` sets `title` once it has read the case. For a
// CaseError, a FileError, an error of std::filesystem or a lack of memory, prints a message and
// returns the matching exit code. With --json it also prints a JSON object.
int report_faults(const RunCommand& command,
                  const std::function<int(std::optional<std::string>& title)>& run);

// Prints `text` and a line end on standard error. Control characters other than \n are escaped.
void complain(const std::string& text);

}  // namespace weft::sim
