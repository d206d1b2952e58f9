// Reads sweep files.
#pragma once

#include <string>
#include <vector>

#include "sim/sweep/sweep_case.h"

namespace weft::sim {

// Read and check a sweep file, but not the case that it names. Throw CaseError as read_case() does:
// its place is that of the key or value at fault, and its hint gives the nearest name or the
// expected values.
SweepCase read_sweep(const std::string& path);
SweepCase parse_sweep(const std::string& text, const std::string& path);

// Returns the [outputs] of a sweep file, without a check of the rest of it. Throws CaseError as
// read_sweep() does.
std::vector<OutputExpression> read_sweep_outputs(const std::string& path);

// True if the method takes numbers from a unit cube (sample_points.h).
bool is_sampled(SampleMethod method);

// Return the JSON Schema (draft 2020-12) of a sweep file, and its reference page in Markdown.
std::string sweep_json_schema();
std::string sweep_reference_markdown();

}  // namespace weft::sim
