// One run of the suite `moving`, looked at as the referee does, in a process of its own.
#pragma once

#include <string>
#include <vector>

#include "tests/moving/moving_scenes.h"

namespace weft::moving {

struct MovingOutcome {
  std::string failure;       // empty: done
  int crossings = 0;         // pairs of triangles, in the first state that has any
  double crossing_time = 0;  // s, of that state
  long states = 0;           // looked at
  long steps = 0, vetoed = 0;
  double cpu_time = 0;  // s
};

// CPU time that one run may take (s); beyond it counts as failed.
constexpr double run_limit = 15;
// States looked at within each interval between two frames, after the first movement. Before it,
// frames are.
constexpr int states_per_frame = 20;

// Runs in this process. Throws CaseError for a scene that cannot be simulated.
MovingOutcome run_scene(const MovingScene& scene);

// Runs each in a child process, `jobs` at a time; a crash is a failure that says so.
std::vector<MovingOutcome> run_scenes(const std::vector<MovingScene>& scenes, int jobs);

}  // namespace weft::moving
