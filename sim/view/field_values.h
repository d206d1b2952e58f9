// The recorded fields of a trajectory: their names, and the scalars by which scales and extremes
// measure their values.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim/trajectory/trajectory.h"

namespace weft::sim {

// Returns the names of the fields of all bodies, each name once, in the order of the file.
std::vector<std::string> field_names(const TrajectoryReader& reader);

// Returns " UNITS", printable, to follow a number. Returns nothing for dimensionless values.
std::string after_number(const std::string& units);

// With 1 component, returns the values themselves. With 3 components, returns the magnitude of each
// vector.
std::vector<double> magnitudes(std::vector<double> values, int components);

}  // namespace weft::sim
