// One run of the suite `moving`, in a separate process, with its states judged by an exact
// count of intersections.
#pragma once

#include <string>
#include <vector>

#include "tests/moving/moving_scenes.h"

namespace weft::moving {

struct MovingOutcome {
  std::string failure;       // empty: done
  int crossings = 0;         // pairs of triangles, in the first state that has any
  double crossing_time = 0;  // s, of that state
  long states = 0;           // states checked
  long steps = 0, vetoed = 0;
  double cpu_time = 0;  // s
};

// Limit of CPU time of one run (s); a run beyond it has failed.
constexpr double run_limit = 15;
// States checked in each interval between two frames, after the first motion. Before it, only
// frames are checked.
constexpr int states_per_frame = 20;

// Runs in this process. Throws CaseError for a scene that cannot be simulated.
MovingOutcome run_scene(const MovingScene& scene);

// Runs each scene in a child process, `jobs` at a time. A crash is reported as a failure.
std::vector<MovingOutcome> run_scenes(const std::vector<MovingScene>& scenes, int jobs);

}  // namespace weft::moving
