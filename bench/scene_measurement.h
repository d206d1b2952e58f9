// Measures all methods on one scene, in alternation.
#pragma once

#include <string>
#include <vector>

#include "bench/hierarchy_results.h"
#include "bench/scenes.h"

namespace weft::bench {

struct SceneMeasurement {
  int repeats = 7;
  std::vector<int> threads{1};       // of Weft
  std::vector<std::string> methods;  // empty: all
};

// Names of all methods of this build.
std::vector<std::string> method_names();

// Appends a row for each method that can handle the scene. In every pass, each method rebuilds,
// refits and queries. Brute force and the slow exact tests of peers run only in the first pass.
// Times are CPU time for one thread, wall time for several. Returns false, after a report on
// standard error, if a method finds wrong candidates or wrong hits.
bool measure_scene(CollisionScene scene, const SceneMeasurement& measurement,
                   std::vector<Row>& rows);

}  // namespace weft::bench
