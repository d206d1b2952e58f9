#include "sim/simulation/rest_watch.h"

#include <algorithm>

#include "sim/motion/dynamics.h"
#include "sim/motion/tolerances.h"

namespace weft::sim {

RestWatch::RestWatch(const Scene& scene, double time, std::span<const double> y)
    : scene_(scene), place_(scene.dynamic_particles), since_(scene.dynamic_bodies) {
  begin(time, y);
}

void RestWatch::begin(double time, std::span<const double> y) {
  last_look_ = time;
  for (int body = 0; body < scene_.dynamic_bodies; ++body) begin_window(body, time, y);
}

void RestWatch::begin_window(int body, double time, std::span<const double> y) {
  const int first = scene_.bodies[body].first_particle;
  std::copy_n(StateView::of(y).position.begin() + first, scene_.bodies[body].particle_count(),
              place_.begin() + first);
  since_[body] = time;
}

void RestWatch::look(double time, std::span<const double> y, std::span<const char> asleep) {
  last_look_ = time;
  const TimeCase& options = scene_.source.time;
  const double distance =
      options.position_tolerance * window / std::max(window, options.duration - time);
  for (int body = 0; body < scene_.dynamic_bodies; ++body) {
    if (asleep[body] == 0 && !stays(scene_.bodies[body], y, distance)) begin_window(body, time, y);
  }
}

// True if every vertex is slow and within `distance` (m) of its position at the start of the
// window.
bool RestWatch::stays(const SceneBody& body, std::span<const double> y, double distance) const {
  const StateView state = StateView::of(y);
  const double speed = velocity_tolerance(scene_.source.time);
  for (int i = body.first_particle; i < body.first_particle + body.particle_count(); ++i) {
    if ((state.position[i] - place_[i]).squaredNorm() > distance * distance ||
        state.velocity[i].squaredNorm() > speed * speed)
      return false;
  }
  return true;
}

}  // namespace weft::sim
