// The names, units and magnitudes of the recorded fields of a trajectory.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim/trajectory/trajectory.h"

namespace weft::sim {

// Returns the names of the fields of all bodies, each name once, in the order of the file.
std::vector<std::string> field_names(const TrajectoryReader& reader);

// Returns the text to print after a number: a space and the units. Returns an empty text for
// dimensionless values.
std::string after_number(const std::string& units);

// Returns `values` if there is one component. If there are three, `values` holds vectors, and their
// magnitudes are returned.
std::vector<double> magnitudes(std::vector<double> values, int components);

}  // namespace weft::sim
