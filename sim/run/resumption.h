// Finds where a recorded run can go on.
#pragma once

#include <optional>
#include <string>

#include "sim/case/case.h"
#include "sim/run/run_checkpoint.h"

namespace weft::sim {

struct ResumeOptions {
  bool estimates_error = false;  // true if the run is to measure its error
  bool extends = false;          // true if the duration may be longer than before
};

struct Resumption {
  // The checkpoint from which the run goes on. Empty: it begins at t = 0, in place of the file of a
  // run that was stopped before its first checkpoint, if there is one.
  std::optional<RunCheckpoint> checkpoint;
};

// Finds the checkpoint of the trajectory at the path `trajectory`, which must be one of the case
// `source`. The table [compute] may differ. Settles time.accuracy of `source` as that run did.
// Throws CaseError if the case or the options are others, and FileError if another process writes
// the trajectory, if a file is damaged or lacks frames, or if the sidecar is not one of Weft.
Resumption find_resumption(const std::string& trajectory, Case& source,
                           const ResumeOptions& options);

}  // namespace weft::sim
