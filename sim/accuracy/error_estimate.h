// The error of a run, as a second run that is more exact measures it (error_monitor.h).
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace weft::sim {

struct BodyError {
  std::string body;
  // RMS over the body's vertices of the distance between the two runs, m.
  double largest = 0, last = 0;
  double largest_time = 0;  // s
};

struct ErrorEstimate {
  std::vector<BodyError> bodies;  // the dynamic ones
  double last_time = 0;           // s, of the last frame that was compared
  // The first frame (s) in which the runs are further apart than a tenth of the largest motion of a
  // body, or of its radius. Beyond it, differences no longer grow in proportion to the errors that
  // made them, and only say that the error is large.
  std::optional<double> parted_time;
  std::string failure;  // why the second run ended early; empty: it did not
};

}  // namespace weft::sim
