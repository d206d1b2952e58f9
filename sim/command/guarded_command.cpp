#include "sim/command/guarded_command.h"

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <optional>

#include "sim/base/file_error.h"
#include "sim/base/file_status.h"
#include "sim/base/memory_shortage.h"
#include "sim/base/reading_process.h"
#include "sim/case/case_error.h"
#include "sim/case/case_text.h"
#include "sim/command/command_json.h"

namespace weft::sim {

namespace {

std::string describe_end(const std::string& path, bool draws, int signal) {
  constexpr std::array crashes{SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU};
  if (std::ranges::find(crashes, signal) == crashes.end()) {
    return path + ": the process that reads it was stopped (" + strsignal(signal) + ")";
  }
  if (!draws) return describe_crash(path, signal);
  return path + ": cannot be drawn: HDF5 or the drawing crashed on it (" + strsignal(signal) +
         "); weft info says whether the file is damaged";
}

// Ends this process by the signal, so that a shell sees the end that the process which prints had.
void end_by(int signal) {
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

// Returns the CPU time limit (s) for reading a file. The limit grows with the file's size, because
// a command may read the whole file.
double limit_of(const std::string& path) {
  // Slowest reading that is allowed (bytes/s): a tenth of the usual rate for compressed data.
  constexpr double slowest_reading = 5e6;
  std::error_code unknown;
  const auto size = std::filesystem::file_size(path, unknown);
  return reading_cpu_limit + (unknown ? 0 : static_cast<double>(size) / slowest_reading);
}

}  // namespace

int report_faults(const RunCommand& command,
                  const std::function<int(std::optional<std::string>& title)>& run) {
  std::optional<std::string> title;
  const auto refuse = [&](int code, const std::string& reason) {
    complain(reason);
    if (command.json) std::cout << refusal_json(command, title, code, reason) << '\n';
    return code;
  };
  try {
    return run(title);
  } catch (const CaseError& error) {
    return refuse(exit_code::bad_case, error.what());
  } catch (const FileError& error) {
    return refuse(exit_code::input_output, error.what());
  } catch (const std::filesystem::filesystem_error& error) {
    return refuse(exit_code::input_output, fault_text(error));
  } catch (const MemoryShortage& error) {
    return refuse(exit_code::input_output, error.what());
  } catch (const std::bad_alloc&) {
    return refuse(exit_code::input_output, "weft: needs more memory than there is");
  }
}

void complain(const std::string& text) { std::cerr << printable(text, true) << '\n'; }

int deliver(int code) {
  // Commands write to stdout and to std::cout. If either cannot be flushed, results are lost.
  if (std::fflush(stdout) == 0 && std::cout.flush()) return code;
  complain("weft: cannot write to standard output");
  return exit_code::input_output;
}

int run_guarded(const GuardedCommand& command) {
  std::cout.flush();
  const std::optional<double> limit =
      command.is_long ? std::nullopt : std::optional(limit_of(command.path));
  const ProcessEnd end = run_in_process([&] { return deliver(command.run()); }, {}, limit);
  if (end.signal == 0) return end.code;
  if (end.signal == SIGPIPE) end_by(SIGPIPE);
  const std::string reason = describe_end(command.path, command.draws, end.signal);
  complain(reason);
  if (command.json) std::cout << refusal_json(exit_code::input_output, reason) << '\n';
  return exit_code::input_output;
}

}  // namespace weft::sim
