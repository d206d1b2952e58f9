// Times of all methods on one scene, taken in turn.
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

// Appends a row for each method that can do the scene. Pass after pass, every method rebuilds,
// refits, queries; the exact tests of peers, which take long, and brute force in the first pass
// alone.
// CPU time of one thread, wall time of several. False, after saying so on standard error, if any
// finds other candidates or other hits than it should.
bool measure_scene(CollisionScene scene, const SceneMeasurement& measurement,
                   std::vector<Row>& rows);

}  // namespace weft::bench
