// The least and the largest recorded values of a trajectory, with places and times.
#pragma once

#include <string>
#include <vector>

#include "bsi/geometry_image.h"
#include "sim/trajectory/trajectory.h"

namespace weft::sim {

// An extreme value of a field, at a texel, or of a record.
struct FieldExtreme {
  double value = 0;
  int frame = -1;
  double time = 0;   // s
  std::string body;  // of the field; empty for a record
  bsi::TexelAddress texel;
};

// The extremes of a field over all bodies that have it. Vectors count by their magnitude. Values
// that are not finite are only counted.
struct FieldSummary {
  std::string name, units;
  bool magnitude = false;
  bool has_extremes = false;      // false if no value is finite
  FieldExtreme minimum, maximum;  // the first of equal values
  long not_finite = 0;
};

// The extremes of a record, such as the force at a pin. Vectors count by their magnitude. Values
// that are not finite are ignored, and extremes have no place.
struct RecordSummary {
  std::string path, units;
  bool magnitude = false;
  bool has_extremes = false;
  FieldExtreme minimum, maximum;
};

// Returns a summary per field. Reads one frame of one body at a time. Throws FileError. O(values).
std::vector<FieldSummary> field_extremes(const TrajectoryReader& reader);
// Returns a summary per record, except records of places, whose values have no order. Throws
// FileError. O(values).
std::vector<RecordSummary> record_extremes(const TrajectoryReader& reader);

}  // namespace weft::sim
