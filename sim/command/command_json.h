// The objects that `--json` prints: exactly one, also if the command fails.
#pragma once

#include <optional>
#include <string>

#include "sim/case/case.h"
#include "sim/command/modes_command.h"
#include "sim/command/run_command.h"
#include "sim/modes/buckling_modes.h"
#include "sim/modes/vibration_modes.h"
#include "sim/run/recorded_run.h"

namespace weft::sim {

// The report of a run that ended with `code`. Numbers that are also series have the series' names.
std::string report_json(const RunCommand& command, const Case& source, const RunReport& report,
                        int code);
// The report of `weft modes` and of `weft buckling`. After a failure the list of modes is empty.
std::string modes_json(const RunCommand& command, const ModesReport& report,
                       const VibrationModes& found, int code);
std::string modes_json(const RunCommand& command, const ModesReport& report,
                       const BucklingModes& found, int code);
// The object of a command on a case without a report. It has the title if the case was read.
std::string refusal_json(const RunCommand& command, const std::optional<std::string>& title,
                         int code, const std::string& reason);
// The object of any other command without a result.
std::string refusal_json(int code, const std::string& reason);

}  // namespace weft::sim
