// The scenes of the suite `robustness`.
#pragma once

#include <ostream>
#include <string>
#include <vector>

namespace weft::robustness {

struct RobustScene {
  std::string name;  // of the case file without its extension
  std::string path;
  double end = 0;  // s; 0: the duration of the case
};

inline std::ostream& operator<<(std::ostream& out, const RobustScene& scene) {
  return out << scene.name;
}

// Returns every case of the folder `cases`, and the scenes of contact in `cases/benchmarks`, sorted
// by name. Of long cases, only a first part is simulated.
std::vector<RobustScene> robust_scenes(const std::string& cases);

}  // namespace weft::robustness
