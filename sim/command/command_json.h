// `--json` prints one object, whatever becomes of the command.
#pragma once

#include <string>

#include "sim/case/case.h"
#include "sim/command/run_command.h"
#include "sim/run/recorded_run.h"

namespace weft::sim {

// The report of a run that ended with `code`. Numbers that are also series have their names.
std::string report_json(const RunCommand& command, const Case& source, const RunReport& report,
                        int code);
// The object of a `weft run` that has no report.
std::string refusal_json(const RunCommand& command, int code, const std::string& reason);
// The object of any other command that has no result.
std::string refusal_json(int code, const std::string& reason);

}  // namespace weft::sim
