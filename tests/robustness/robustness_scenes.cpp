#include "tests/robustness/robustness_scenes.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>

namespace weft::robustness {

namespace {

// Layers, folds and knots: what contact finds hard.
constexpr std::array contact_scenes{"closing_plates", "fast_ball",        "pulled_through_ring",
                                    "reef_knot",      "sheet_on_needles", "stacked_sheets",
                                    "twisted_cloth",  "wound_up_sheet"};

// The parts (s) of cases that take long.
constexpr std::array<std::pair<const char*, double>, 15> parts{{
    {"ball_on_trampoline", 0.6},
    {"balls_in_a_sheet", 0.3},
    {"creased_paper", 1.2},
    {"drape_torus", 0.25},
    {"falling_box_of_sheets", 0.15},
    {"flag_in_gusts", 1.0},
    {"flag_in_wind", 0.3},
    {"pulled_through_ring", 0.25},
    {"sheet_on_sphere", 0.3},
    {"shell_on_trampoline", 0.4},
    {"stacked_sheets", 0.1},
    {"tube_on_torus", 0.3},
    {"two_fabrics", 0.2},
    {"undamped_sheet", 1.0},
    {"vibrating_plate", 0.02},
}};

double part_of(const std::string& name) {
  const auto found =
      std::ranges::find_if(parts, [&](const auto& one) { return one.first == name; });
  return found == parts.end() ? 0 : found->second;
}

}  // namespace

std::vector<RobustScene> robust_scenes(const std::string& cases) {
  const std::filesystem::path folder(cases);
  std::vector<RobustScene> scenes;
  const auto add = [&](const std::filesystem::path& path) {
    const std::string name = path.stem().string();
    scenes.push_back({name, path.string(), part_of(name)});
  };
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".toml") add(entry.path());
  for (const char* name : contact_scenes)
    add(folder / "benchmarks" / (std::string(name) + ".toml"));
  std::ranges::sort(scenes, {}, &RobustScene::name);
  return scenes;
}

}  // namespace weft::robustness
