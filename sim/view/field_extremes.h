// The least and the largest recorded values of a trajectory, with their places and times.
#pragma once

#include <string>
#include <vector>

#include "bsi/geometry_image.h"
#include "sim/trajectory/trajectory.h"

namespace weft::sim {

// The value of a field at a texel, or of a record.
struct FieldExtreme {
  double value = 0;
  int frame = -1;
  double time = 0;   // s
  std::string body;  // of a field
  bsi::TexelAddress texel;
};

// A field of all bodies that have it. Vectors count by their magnitude; values that are not finite
// are left out, and counted.
struct FieldSummary {
  std::string name, units;
  bool magnitude = false;
  bool has_extremes = false;      // false if no value is finite
  FieldExtreme minimum, maximum;  // the first of equal ones
  long not_finite = 0;
};

// A record, such as the force at a pin, in the same way; its extremes have no place.
struct RecordSummary {
  std::string path, units;
  bool magnitude = false;
  bool has_extremes = false;
  FieldExtreme minimum, maximum;
};

// Reads one frame of one body at a time. Throws FileError. O(values).
std::vector<FieldSummary> field_extremes(const TrajectoryReader& reader);
// Leaves out records that are places, which have no order. Throws FileError. O(values).
std::vector<RecordSummary> record_extremes(const TrajectoryReader& reader);

}  // namespace weft::sim
