// The error of a run, measured by a second, more exact run (error_monitor.h).
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
  // Time (s) of the first frame in which the runs are further apart than a tenth of a body's
  // largest motion, or of its radius. From then on, differences no longer grow in proportion to the
  // errors that caused them: they only show that the error is large.
  std::optional<double> parted_time;
  std::string failure;  // why the second run ended early; else empty
};

}  // namespace weft::sim
