// A case with its scene and its integrator, for tests that inspect states.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "sim/case/case_reader.h"
#include "sim/integrator/integrator.h"
#include "sim/scene/scene.h"
#include "sim/view/crossings.h"

namespace weft::sim {

using Overrides = std::vector<std::string>;

// Returns an override that sets a number of [time].
inline std::string key(const std::string& name, double value) {
  return "time." + name + "=" + std::to_string(value * 1e12) + "e-12";
}
inline Overrides method(const std::string& name, const Overrides& more = {}) {
  Overrides all{"time.method=\"" + name + "\""};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

// An undamped sheet that hangs by two corners; tests vary it by overrides.
constexpr const char* hanging_sheet = R"(
[time]
duration = 0.1
frames_per_second = 50
[contact]
enabled = false
[material.cloth]
bending_stiffness = 1e-5
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [9, 9] }
[[body.pin]]
corners = ["last_first", "last_last"]
)";

class SimulatedCase {
 public:
  explicit SimulatedCase(const std::string& text, const Overrides& overrides = {})
      : scene_(build_scene(parse_case(text, "test.toml", overrides))),
        dynamics_(*scene_, statistics_),
        integrator_(make_integrator(*scene_, dynamics_)) {}

  // Steps until `time` is reached and returns the state there (interpolated).
  std::vector<double> advance_to(double time) {
    std::vector<double> y(integrator_->state().begin(), integrator_->state().end());
    while (integrator_->time() < time) {
      const auto failure = integrator_->step();
      if (failure) {
        ADD_FAILURE() << failure->text;
        return y;
      }
    }
    if (time > 0) {
      if (const auto failure = integrator_->state_at(time, y)) ADD_FAILURE() << failure->text;
    }
    return y;
  }
  // Returns the positions of all particles, with prescribed ones in their place.
  std::vector<Vec3> positions(double time, const std::vector<double>& y) const {
    std::vector<Vec3> position, velocity;
    dynamics_.expand_all(time, y, position, velocity);
    return position;
  }
  std::vector<Vec3> positions_at(double time) { return positions(time, advance_to(time)); }
  double energy(double time, const std::vector<double>& y) {
    return dynamics_.energies(time, y).total();
  }

  const Scene& scene() const { return *scene_; }
  Dynamics& dynamics() { return dynamics_; }
  Integrator& integrator() { return *integrator_; }
  const Statistics& statistics() const { return statistics_; }

 private:
  std::unique_ptr<const Scene> scene_;
  Statistics statistics_;
  Dynamics dynamics_;
  std::unique_ptr<Integrator> integrator_;
};

// A spring between a pinned and a free row that moves along it.
constexpr const char* oscillator = R"(
[time]
duration = 10
position_tolerance = 1e-10
velocity_tolerance = 1e-8
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.spring]
density = 1
membrane = "springs"
structural_stiffness = 100
shear_stiffness = 0
[[body]]
name = "rod"
velocity = [0.1, 0, 0]
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [2, 2] }
[[body.pin]]
edges = ["first_col"]
)";

// The path of a ball leads through a sheet, which rests between two pinned edges, and back, from
// 0.4 s to 0.6 s.
constexpr const char* there_and_back = R"(
[time]
duration = 0.65
[world]
gravity = [0, 0, 0]
[material.cloth]
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [9, 9] }
[[body.pin]]
edges = ["first_row", "last_row"]
[[obstacle]]
name = "ball"
position = [0.03, 0.02, 0.15]
shape = { type = "sphere", radius = 0.1, resolution = [5] }
[obstacle.motion]
keyframes = [{ time = 0.4 }, { time = 0.5, translation = [0, 0, -0.3] }, { time = 0.6 }]
)";

// Both pinned edges of a sheet are pulled along it towards a plate, which they would pass through:
// no force can stop pins.
constexpr const char* pins_against_a_plate = R"(
[time]
duration = 1
frames_per_second = 2
[material.cloth]
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [5, 5] }
[[body.pin]]
edges = ["first_row"]
motion = { velocity = [1, 0, 0] }
[[body.pin]]
edges = ["last_row"]
motion = { velocity = [1, 0, 0] }
[[obstacle]]
name = "plate"
position = [0.5, 0, 0]
rotation_deg = [0, 90, 0]
shape = { type = "rectangle", size = [1, 1], resolution = [4, 4] }
)";

// Returns the number of pairs of triangles of the scene that pass through each other.
inline int crossings(const Scene& scene, const std::vector<Vec3>& position) {
  std::vector<CrossingSurface> surfaces;
  for (const SceneBody& body : scene.bodies) {
    surfaces.push_back({std::span(position).subspan(body.first_particle, body.particle_count()),
                        body.mesh.triangles, body.dynamic});
  }
  return static_cast<int>(find_crossings(surfaces).size());
}

// Returns the root mean square distance of two states' positions, m.
inline double position_difference(const std::vector<double>& a, const std::vector<double>& b) {
  const StateView first = StateView::of(a), second = StateView::of(b);
  double sum = 0;
  for (std::size_t i = 0; i < first.position.size(); ++i) {
    sum += (first.position[i] - second.position[i]).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(first.position.size()));
}

}  // namespace weft::sim
