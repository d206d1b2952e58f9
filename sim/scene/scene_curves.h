// The keys of a case that vary in time, and the parts of the scene that they affect.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "sim/case/case.h"
#include "sim/scene/time_curve.h"

namespace weft::sim {

// A key of the case that varies in time.
struct SceneCurve {
  std::string key;  // "world.wind", "material.cotton.mass_damping"
  std::variant<const Varying<double>*, const Varying<Vec3>*> source;  // points into the case
  CurveTimes times;
  std::string unused;  // why it acts on nothing; empty if it acts on something
  // A change of the value can set bodies at rest in motion: all bodies, or those of
  // `moves_materials`.
  bool moves_all = false;
  std::vector<std::string> moves_materials;
};

// Returns the keys of a case that vary in time, in the order of the case.
std::vector<SceneCurve> find_curves(const Case& source);

// The varying keys of a case, without those that act on nothing.
class SceneCurves {
 public:
  explicit SceneCurves(const Case& source);

  // Returns the corners and jumps after t = 0, where steps must end, by time.
  std::vector<MotionEvent> events() const;
  // Returns the longest step (s) that resolves every gust; infinity without one.
  double longest_step() const;
  // Returns true if a curve changes after `from` and before `to` (s) and can set a body of this
  // material in motion from rest.
  bool may_move(const std::string& material, double from, double to) const;

 private:
  std::vector<SceneCurve> curves_;
};

}  // namespace weft::sim
