// The table of the suite `moving`: sheets, what they meet, and how.
#pragma once

#include <array>
#include <vector>

#include "tests/moving/moving_scenes.h"

namespace weft::moving {

// Sheets. pinned: along two opposite edges; hanging: by its upper edge; corners: by its upper
// corners. Pinned, free and folded sheets are without gravity, so that they rest until they are
// met.
enum class Sheet { pinned, hanging, corners, free, folded };
enum class Thing { ball, paddle, needle, plate, torus, wall };
// Courses of a body. through: starts and stops at once; eased: by two keyframes; back: by three;
// oscillate: by seven; creep: not deep; sweep: on an arm about an axis beside the sheet; spin:
// about itself while it approaches; clamp: two bodies from both sides, past each other.
enum class Course { through, eased, back, oscillate, creep, sweep, spin, clamp };
enum class Pins { still, twist, turn, jerk, pull };

struct Row {
  const char* name;
  Sheet sheet;
  std::vector<Thing> things;
  Course course = Course::through;
  double speed = 0;  // m/s; of sweep and spin turns/s
  double rest = 0;   // s, at most, before it moves
  bool both_sides = false;
  Pins pins = Pins::still;
  double pin_speed = 0;  // of jerk and pull m/s, of twist and turn turns/s
  double strength = 1;   // below 1: kappa d^2 as a share of sigma v^2 / 2
};

const std::array<Row, scene_count>& scene_table();

}  // namespace weft::moving
