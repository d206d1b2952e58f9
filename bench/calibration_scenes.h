// Short scenes on which tolerances are calibrated, and others that verify the calibration.
#pragma once

#include <string>
#include <vector>

#include "sim/case/case.h"

namespace weft::bench {

struct CalibrationScene {
  const char* name;
  const char* shows;
  std::vector<std::string> overrides;  // KEY=VALUE of the text of `base`
  const char* base;                    // TOML
  bool held_out;                       // for verification, not for calibration
};

const std::vector<CalibrationScene>& calibration_scenes();

// The case of a scene, with more overrides (KEY=VALUE).
sim::Case case_of(const CalibrationScene& scene, const std::vector<std::string>& more = {});

}  // namespace weft::bench
