// The tolerance for an accuracy, corrected by what a scene makes of errors.
#pragma once

#include "sim/case/case.h"

namespace weft::sim {

// Where `time.accuracy` has chosen a tolerance tau by the table: two runs of the whole duration,
// without a trajectory, at 16 tau (no more than 2e-5 m and what contact allows) and a 16th of that.
// Their distance over that of the table is the factor by which this scene's errors are larger than
// the table's, at other tolerances too: it is taken out of the tolerance, and added to
// Case::accuracy_choice and Case::resolved_text. Leaves the case alone where there is nothing to
// correct, and says so where a run fails. Costs up to three times what the run will. Throws
// CaseError as build_scene() does.
void correct_accuracy(Case& target);

}  // namespace weft::sim
