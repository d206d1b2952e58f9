// Copies frames from one trajectory to another, and finds out whether they can be read. Private to
// sim/.
#pragma once

#include <string>
#include <vector>

#include "sim/trajectory/trajectory.h"

namespace weft::sim {

// The datasets of a trajectory, in the order of TrajectoryWriter::write_frame().
struct TrajectoryLayout {
  std::vector<TrajectoryBody> bodies;
  std::vector<TrajectoryWriter::Series> series, step_series;
  std::vector<TrajectoryRecord> records;
};

// Appends the first `frames` frames of the trajectory at `path` to `to`, with the rows of the steps
// before them. Every number keeps its bits. `layout` is that of `to`. Throws FileError, also if the
// trajectory has fewer frames or other datasets. Cost: that of writing the frames once.
void copy_frames(const std::string& path, int frames, const TrajectoryLayout& layout,
                 TrajectoryWriter& to);

// Reads the header and the first `frames` frames of the trajectory at `path`, or as many as there
// are, in a process of their own, because HDF5 crashes on some damaged files. Throws FileError if
// that process crashes or comes to no end. Other faults are left to a later reader.
void require_readable(const std::string& path, int frames);

}  // namespace weft::sim
