// The error of a run, measured by a second, more exact run (error_monitor.h).
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace weft::sim {

struct BodyError {
  std::string body;
  // RMS distance between the body's particles in the two runs (m): its largest value over the
  // compared frames, and its value in the last of these frames.
  double largest = 0, last = 0;
  double largest_time = 0;  // time of the frame with the largest distance, s
};

struct ErrorEstimate {
  std::vector<BodyError> bodies;  // errors of the dynamic bodies
  double last_time = 0;           // time of the last frame compared, s
  // Time (s) of the first frame in which the runs differ by more than a tenth of a body's largest
  // motion or of its radius. From then on, differences do not grow in proportion to the errors that
  // caused them. They only show that the error is large.
  std::optional<double> parted_time;
  std::string failure;  // message if the second run failed, else empty
};

}  // namespace weft::sim
