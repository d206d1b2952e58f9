// The error of a run, measured by a second, more exact run (error_monitor.h).
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace weft::sim {

struct BodyError {
  std::string body;
  // RMS distance between the two runs over the body's vertices (m): the largest of all frames, and
  // that of the last frame.
  double largest = 0, last = 0;
  double largest_time = 0;  // s, of the frame with the largest distance
};

struct ErrorEstimate {
  std::vector<BodyError> bodies;  // dynamic bodies only
  double last_time = 0;           // s, of the last frame compared
  // Time (s) of the first frame in which the runs differ by more than a tenth of a body's largest
  // motion or of its radius. From then on, differences do not grow in proportion to the errors that
  // caused them. They only show that the error is large.
  std::optional<double> parted_time;
  std::string failure;  // why the second run ended early; empty if it did not
};

}  // namespace weft::sim
