// The keys of a case that vary in time, and the parts of the scene that they affect.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "sim/case/case.h"
#include "sim/scene/time_curve.h"

namespace weft::sim {

// A key that varies.
struct SceneCurve {
  std::string key;  // "world.wind", "material.cotton.mass_damping"
  std::variant<const Varying<double>*, const Varying<Vec3>*> source;  // points into the case
  CurveTimes times;
  std::string unused;  // why it acts on nothing; empty if it acts on something
  // It can set bodies at rest in motion: all of them, or those of these materials.
  bool moves_all = false;
  std::vector<std::string> moves_materials;
};

// Returns the keys of a case that vary, in the order of the case.
std::vector<SceneCurve> find_curves(const Case& source);

// The curves that act on something in a case.
class SceneCurves {
 public:
  explicit SceneCurves(const Case& source);

  // Corners and jumps after t = 0, where steps must end, by time.
  std::vector<MotionEvent> events() const;
  // Longest step (s) that follows every gust; infinite without one.
  double longest_step() const;
  // True if a curve that changes after `from` and before `to` (s) can set a body of this material
  // in motion that is at rest.
  bool may_move(const std::string& material, double from, double to) const;

 private:
  std::vector<SceneCurve> curves_;
};

}  // namespace weft::sim
