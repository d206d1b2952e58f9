// Sixty scenes of the suite `moving`, as case texts made from a table and a seed: prescribed motion
// against cloth of every kind.
#pragma once

#include <string>
#include <vector>

namespace weft::moving {

constexpr int scene_count = 60, seed_count = 10;

struct MovingScene {
  int number = 0, seed = 0;
  std::string name;    // from the table: the sheet, what meets it and how
  std::string method;  // cvode, arkode, euler (adaptive), euler-step (converged Newton),
                       // euler-linear (one iteration) or verlet
  std::string text;    // the case
  double start = 0;    // s, of the first motion
  double end = 0;      // s, of the case

  // Predicted from the geometry alone.
  double stretch = 0;  // l / L - 1 of the shortest path between the pins round the pushing body
  bool is_trapped = false;  // cloth is caught between a moving body and a fixed or approaching one
  double fastest = 0;       // m/s, upper bound of the speed of any prescribed point
  double strength = 0;      // kappa d^2 / (sigma v^2 / 2)
  bool has_path() const;    // a path without collision exists, stretched by at most a fifth
  bool is_strong() const { return strength >= 1; }
  bool must_be_done() const { return has_path() && is_strong(); }
};

// Makes a scene: `number` from 0 to scene_count - 1, `seed` from 0 to seed_count - 1. The text is
// the same on every machine. The method advances by one with each seed. Shape files of folded
// sheets go to `folder`.
MovingScene make_scene(int number, int seed, const std::string& folder);

}  // namespace weft::moving
