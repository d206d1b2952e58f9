// What an accuracy asks of a scene, corrected by pilot runs of it.
#pragma once

#include "sim/case/case.h"

namespace weft::sim {

// Where `time.accuracy` has chosen a tolerance tau by the table: two runs of the whole duration,
// without a trajectory, at 16 tau (no more than 2e-5 m and what contact allows) and a 16th of that.
// Their distance over that of the table is the factor by which this scene's errors are larger than
// the table's, at other tolerances too: it is taken out of the tolerance.
//
// Where the method is free, too, and there is no contact, `verlet` takes its place if all of its
// steps, nine tenths of the longest stable one, are less work than the looser of those runs, and
// two runs of it, at that share and at half of it, find it as accurate as asked for. Work is
// counted, not timed: the choice is the same everywhere.
//
// What was found is added to Case::accuracy_choice and Case::resolved_text. Leaves the case alone
// where there is nothing to correct, and says so where a run fails. Costs up to three times what
// the run will. Throws CaseError as build_scene() does.
void correct_accuracy(Case& target);

}  // namespace weft::sim
