// The recorded fields of a trajectory: their names, and the numbers that represent their values in
// scales and extremes.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim/trajectory/trajectory.h"

namespace weft::sim {

// Names of the fields of all bodies, each once, in the order of the file.
std::vector<std::string> field_names(const TrajectoryReader& reader);

// Returns ` UNITS` to follow a number, printable; nothing for pure numbers.
std::string after_number(const std::string& units);

// Returns the numbers themselves, or, with 3 components, the magnitude of each vector.
std::vector<double> magnitudes(std::vector<double> values, int components);

}  // namespace weft::sim
