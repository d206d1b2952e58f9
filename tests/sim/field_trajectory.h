// A trajectory of a sheet with fields over a floor without any.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bsi/shapes.h"
#include "tests/sim/trajectory_fixture.h"

namespace weft::sim {

class FieldTrajectory : public TrajectoryFolder {
 protected:
  // Writes run.h5. The sheet of 17 x 17 vertices lies still and flat, 0.2 m above the floor. Its
  // field "strain" is `strain` of the frame and the place; its "velocity" is (3, 4, 0) times the
  // number of the frame.
  void write_frames(int frames, const std::function<double(int, const Vec3&)>& strain) const {
    bsi::Surface sheet = bsi::make_rectangle(1, 1, 17, 17);
    for (Vec3& position : sheet.positions) position.z() = 0.2;
    const bsi::Surface floor = bsi::make_rectangle(1.5, 1.5, 2, 2);
    std::vector<TrajectoryBody> bodies(2);
    bodies[0].name = "floor";
    bodies[0].atlas = floor.atlas;
    bodies[0].moves = false;
    bodies[0].is_obstacle = true;
    bodies[1].name = "sheet";
    bodies[1].atlas = sheet.atlas;
    bodies[1].fields = {{"strain", "1", "strain", 1}, {"velocity", "m/s", "velocity", 3}};
    TrajectoryWriter writer(path("run.h5"), bodies, {}, {.force = true},
                            {floor.positions, sheet.positions});
    for (int frame = 0; frame < frames; ++frame) {
      const std::vector<Vec3> velocities(sheet.positions.size(), frame * Vec3(3, 4, 0));
      std::vector<double> strains;
      for (const Vec3& place : sheet.positions) strains.push_back(strain(frame, place));
      writer.write_frame(0.1 * frame, {floor.positions, sheet.positions},
                         {{{}, {strains, numbers_of(velocities)}}, {}}, {});
    }
  }
};

}  // namespace weft::sim
