// The options of `weft sweep`.
#pragma once

#include <CLI/CLI.hpp>

#include "sim/command/sweep_command.h"

namespace weft::sim {

// Adds the subcommand `sweep`. `command` and `code` must outlive `app`; the parser sets `code` to
// the exit code of the command that ran.
void add_sweep(CLI::App& app, SweepCommand& command, int& code);

}  // namespace weft::sim
