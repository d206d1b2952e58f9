#include "sim/scene/awake_scene.h"

#include <algorithm>
#include <cassert>

#include "sim/scene/held_bodies.h"
#include "sim/scene/surface_points.h"

namespace weft::sim {

namespace {

// Returns a copy of the scene with `position` as initial positions of the dynamic particles,
// because integrators start from the initial state. All initial velocities are zero; velocities of
// awake bodies come from the state with which the integrator restarts.
Scene at_present(const Scene& whole, std::span<const Vec3> position) {
  Scene scene = whole;
  std::copy(position.begin(), position.end(), scene.initial_position.begin());
  for (SceneBody& body : scene.bodies) body.velocity = body.spin = Vec3::Zero();
  return scene;
}

}  // namespace

AwakeScene::AwakeScene(const Scene& whole, std::span<const char> asleep,
                       std::span<const Vec3> position)
    : whole_(whole), scene_(at_present(whole, position)) {
  assert(static_cast<int>(asleep.size()) == whole.dynamic_bodies);
  assert(static_cast<int>(position.size()) == whole.dynamic_particles);
  hold_bodies(scene_, asleep, scene_.prescribed);
  number_surface_points(scene_);
  assert(scene_.dynamic_bodies < whole.dynamic_bodies);
  for (int b = scene_.dynamic_bodies; b < whole.dynamic_bodies; ++b) scene_.bodies[b].sleeps = true;
  whole_body_.resize(whole.bodies.size());
  for (std::size_t i = 0; i < whole.case_order.size(); ++i)
    whole_body_[scene_.case_order[i]] = whole.case_order[i];
}

int AwakeScene::whole_particle(int particle) const {
  const int body = scene_.body_index_of_particle(particle);
  return particle - scene_.bodies[body].first_particle +
         whole_.bodies[whole_body_[body]].first_particle;
}

// Calls copy(first, whole_first, count) for each range of `count` numbers of an awake body. The
// range begins at `first` in a state of scene_, and at `whole_first` in a state of whole_.
template <class Copy>
void AwakeScene::visit_vectors(const Copy& copy) const {
  for (int b = 0; b < scene_.dynamic_bodies; ++b) {
    const SceneBody& body = scene_.bodies[b];
    const int first = body.first_particle;
    const int whole_first = whole_.bodies[whole_body_[b]].first_particle;
    copy(3 * first, 3 * whole_first, 3 * body.particle_count());
    copy(3 * (scene_.dynamic_particles + first), 3 * (whole_.dynamic_particles + whole_first),
         3 * body.particle_count());
  }
}

void AwakeScene::gather(std::span<const double> whole, std::span<double> awake) const {
  visit_vectors([&](int first, int whole_first, int count) {
    std::copy_n(whole.begin() + whole_first, count, awake.begin() + first);
  });
}

void AwakeScene::scatter(std::span<const double> awake, std::span<double> whole) const {
  visit_vectors([&](int first, int whole_first, int count) {
    std::copy_n(awake.begin() + first, count, whole.begin() + whole_first);
  });
}

}  // namespace weft::sim
