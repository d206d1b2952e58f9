// The keys of a case that vary in time, and the bodies that they affect.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "sim/case/case.h"
#include "sim/scene/time_curve.h"

namespace weft::sim {

// A key of a case whose value varies in time.
struct SceneCurve {
  std::string key;  // for example "world.wind" or "material.cotton.mass_damping"
  std::variant<const Varying<double>*, const Varying<Vec3>*> source;  // points into the case
  CurveTimes times;
  std::string unused;  // reason why the key has no effect; empty if it has an effect
  // True if a change of the value can set any body at rest in motion.
  bool moves_all = false;
  std::vector<std::string> moves_materials;  // materials whose bodies the change can set in motion
};

// Returns the keys of a case that vary in time: first the keys of the world, then of contact,
// materials and loads.
std::vector<SceneCurve> find_curves(const Case& source);

// The varying keys of a case that have an effect.
class SceneCurves {
 public:
  explicit SceneCurves(const Case& source);

  // Returns the corners and jumps of all curves after t = 0, sorted by time. Steps must end there.
  std::vector<MotionEvent> events() const;
  // Returns the longest step (s) that resolves every gust, or infinity if there is no gust.
  double longest_step() const;
  // Returns true if a curve that can set bodies of this material in motion changes after `from` and
  // before `to` (s).
  bool may_move(const std::string& material, double from, double to) const;

 private:
  std::vector<SceneCurve> curves_;
};

}  // namespace weft::sim
