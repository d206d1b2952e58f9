// The least and the largest recorded values of a trajectory, with their texels and times.
#pragma once

#include <string>
#include <vector>

#include "bsi/geometry_image.h"
#include "sim/trajectory/trajectory.h"

namespace weft::sim {

// An extreme value of a field or of a record. `body` and `texel` are set for fields only.
struct FieldExtreme {
  double value = 0;
  int frame = -1;
  double time = 0;   // s
  std::string body;  // name of the body
  bsi::TexelAddress texel;
};

// The extremes of a field over all frames and all bodies that have it. Vectors count by their
// magnitude. Values that are not finite only count in `not_finite`.
struct FieldSummary {
  std::string name, units;
  bool magnitude = false;         // true if the values are magnitudes of vectors
  bool has_extremes = false;      // false if no value is finite
  FieldExtreme minimum, maximum;  // for equal values, the first one by body, frame and texel
  long not_finite = 0;            // number of values that are not finite
};

// The extremes of a record, such as the force at a pin, over all frames. Vectors count by their
// magnitude. Values that are not finite are left out.
struct RecordSummary {
  std::string path, units;
  bool magnitude = false;         // true if the values are magnitudes of vectors
  bool has_extremes = false;      // false if no value is finite
  FieldExtreme minimum, maximum;  // for equal values, the one of the earliest frame
};

// Returns a summary per field. Reads one frame of one body at a time. Throws FileError. O(values).
std::vector<FieldSummary> field_extremes(const TrajectoryReader& reader);
// Returns a summary per record. Leaves out the records of the channel largest_stretch_place, whose
// values are indices. Throws FileError. O(values).
std::vector<RecordSummary> record_extremes(const TrajectoryReader& reader);

}  // namespace weft::sim
