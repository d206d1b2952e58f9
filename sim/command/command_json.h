// The JSON objects that `weft run`, `weft modes` and `weft buckling` print with `--json`, and those
// of any command that fails.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/case/case.h"
#include "sim/command/modes_command.h"
#include "sim/command/run_command.h"
#include "sim/modes/buckling_modes.h"
#include "sim/modes/vibration_modes.h"
#include "sim/run/recorded_run.h"

namespace weft::sim {

// Returns the report of a run, as JSON. `warnings` are those of RunOptions::warning. `code` is the
// exit code of the command.
std::string report_json(const RunCommand& command, const Case& source, const RunReport& report,
                        const std::vector<std::string>& warnings, int code);
// Return the report of `weft modes` and of `weft buckling`, as JSON. `code` is the exit code of the
// command. The list of modes is empty if no mode was found.
std::string modes_json(const RunCommand& command, const ModesReport& report,
                       const VibrationModes& found, int code);
std::string modes_json(const RunCommand& command, const ModesReport& report,
                       const BucklingModes& found, int code);
// Returns the JSON object of a command on a case that ended without a report. `title` is the
// title of the case, or empty if the case was not read. The status is "refused" if `code` is
// exit_code::bad_case, else "failed".
std::string refusal_json(const RunCommand& command, const std::optional<std::string>& title,
                         int code, const std::string& reason);
// Returns the JSON object of a command without a case that ended without a result. The status is
// "refused" if `code` is exit_code::bad_case, else "failed".
std::string refusal_json(int code, const std::string& reason);

}  // namespace weft::sim
