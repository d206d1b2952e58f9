// Writes modes as a trajectory.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim/base/bill.h"
#include "sim/modes/case_equilibrium.h"
#include "sim/trajectory/trajectory.h"

namespace weft::sim {

struct RecordedMode {
  // One displacement per dynamic particle, of which the largest has the length 1.
  std::span<const Vec3> shape;
  std::vector<double> values;  // one value per series
};

struct ModeTrajectoryOptions {
  std::string path;         // path of the HDF5 file; a missing folder is created
  bool force = false;       // true: an existing file is overwritten
  int frames_per_mode = 1;  // 1: the shape alone; otherwise one period
  // Series in addition to "mode", which is the number of the mode, from 1.
  std::vector<TrajectoryWriter::Series> series;
};

// Writes the equilibrium as frame 0 at time 0, then the equilibrium displaced by one mode after the
// other, numbered from 1. With one frame per mode, frame i at time i is mode i at its largest
// displacement. With n > 1 frames per mode, frames n (i - 1) + k for k = 1 .. n show one period of
// a sine of mode i, at times i - 1 + k / n. The amplitude of the particle that moves most is a
// tenth of the diagonal of the box around the simulated bodies. The field "displacement" (m) holds
// the displacements. Series are NaN in frame 0. The file also holds `bill`. Throws FileError if the
// file cannot be written.
void write_modes(CaseEquilibrium& equilibrium, std::span<const RecordedMode> modes,
                 const ModeTrajectoryOptions& options, const Bill& bill);

}  // namespace weft::sim
