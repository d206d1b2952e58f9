// The named outputs of a run.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "sim/case/case.h"
#include "sim/trajectory/trajectory.h"

namespace weft::sim {

// Names and values of outputs. A value that does not exist is NaN.
using OutputValues = std::vector<std::pair<std::string, double>>;

// Throws CaseError if an output is at fault or asks for what `contents` does not have.
void check_outputs(const std::vector<OutputExpression>& outputs,
                   const TrajectoryContents& contents);

// Returns the values of the outputs. Throws CaseError as check_outputs(), and FileError.
OutputValues evaluate_outputs(const std::vector<OutputExpression>& outputs,
                              const TrajectoryReader& reader);

// Returns the [outputs] of the case that a trajectory holds. The place of their texts is in
// `PATH:case`. Throws CaseError if the case has no such table of texts, and none if it has no
// outputs.
std::vector<OutputExpression> recorded_outputs(const TrajectoryReader& reader,
                                               const std::string& path);

// Reads an output from a text `NAME = EXPRESSION`. Throws CaseError without "=" or for a name of
// other characters than letters, digits, _ and -.
OutputExpression output_of(const std::string& text);
// Reads several outputs. Throws CaseError as output_of(), and for a name that is given twice.
std::vector<OutputExpression> outputs_of(const std::vector<std::string>& texts);

// Returns the outputs as lines `NAME VALUE`, and as one JSON object with null for what is no finite
// number.
std::string to_text(const OutputValues& outputs);
std::string to_json(const OutputValues& outputs);

}  // namespace weft::sim
