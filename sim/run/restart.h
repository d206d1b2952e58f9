// Reads the state of another run in which the bodies of a case start ([restart]).
#pragma once

#include "sim/case/case.h"

namespace weft::sim {

// Reads the state that source.restart names, and sets source.restart->states. Does nothing if the
// case has no restart, or if its states are already there. A state comes from a frame of the
// trajectory, or from its checkpoint if restart.time is the time of the checkpoint. Throws
// CaseError at [restart] if the trajectory has neither at this time, lacks a body, or has another
// number of patches; and for a frame without velocities, or one whose surfaces are so near each
// other that the rounding of its positions matters. The message names the times that serve. Throws
// CaseError at restart.path if a file cannot be read.
//
// A checkpoint needs the files that the case of its run reads, such as shapes. They are looked for
// from the folder of that case, which the trajectory records, and then from the folder of `source`.
// A file with other contents than in that run is refused.
void read_restart(Case& source);

}  // namespace weft::sim
