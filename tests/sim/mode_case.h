// Modes of cases, for tests.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "sim/case/case_reader.h"
#include "sim/modes/buckling_modes.h"
#include "sim/modes/case_equilibrium.h"
#include "sim/modes/vibration_modes.h"
#include "sim/motion/dynamics.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// Reads a case of cases/benchmarks.
inline Case benchmark_case(const std::string& name,
                           const std::vector<std::string>& overrides = {}) {
  return read_case(std::string(WEFT_CASES_DIR) + "/benchmarks/" + name + ".toml", overrides);
}

inline VibrationModes modes_of(const Case& source, int count, bool start_shape = false) {
  CaseEquilibrium about(source, {.start_shape = start_shape, .load_factor = {}, .progress = {}});
  if (const auto failure = about.find()) ADD_FAILURE() << failure->text;
  VibrationModes found = find_vibration_modes(about.dynamics(), about.time(), about.state(), count);
  if (found.failure) ADD_FAILURE() << found.failure->text;
  return found;
}

inline BucklingModes buckling_of(const Case& source, int count, double load_factor = 0) {
  require_load(source);
  CaseEquilibrium about(source, {.load_factor = load_factor, .progress = {}});
  if (const auto failure = about.find()) ADD_FAILURE() << failure->text;
  return find_buckling_modes(about.dynamics(), about.time(), about.state(), load_factor, count);
}

}  // namespace weft::sim
