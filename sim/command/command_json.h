// The JSON object that a command prints with `--json`, whether it succeeds or fails.
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

// Returns the report of a run that ended with exit code `code`. Members that are also series of the
// trajectory have the names of those series.
std::string report_json(const RunCommand& command, const Case& source, const RunReport& report,
                        int code);
// Returns the report of `weft modes` or `weft buckling`. After a failure the list of modes is
// empty.
std::string modes_json(const RunCommand& command, const ModesReport& report,
                       const VibrationModes& found, int code);
std::string modes_json(const RunCommand& command, const ModesReport& report,
                       const BucklingModes& found, int code);
// Returns the object of a command on a case that ended without a report. It has a title if the case
// was read. A mistake in the case or the arguments gives the status "refused", any other fault
// "failed".
std::string refusal_json(const RunCommand& command, const std::optional<std::string>& title,
                         int code, const std::string& reason);
// Returns the object of any other command that ended without a result.
std::string refusal_json(int code, const std::string& reason);

}  // namespace weft::sim
