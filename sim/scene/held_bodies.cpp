#include "sim/scene/held_bodies.h"

#include <algorithm>
#include <numeric>

namespace weft::sim {

namespace {

// Returns a mark for each body: 1 if it is held as a whole. A body with several pins, of which at
// least one moves, is not held as a whole, because contact and its friction require obstacles to be
// rigid. Nor is a body on which a load acts, because only simulated bodies have loads, and the
// reactions of its pins include them.
std::vector<char> find_held(const Scene& scene, const std::vector<PrescribedMotion>& pins) {
  std::vector<char> is_held, moves(scene.bodies.size(), 0);
  std::vector<int> pin_count(scene.bodies.size(), 0);
  for (const PrescribedMotion& pin : pins) {
    if (pin.particles.empty()) continue;
    const int body = scene.body_index_of_particle(pin.particles.front());
    ++pin_count[body];
    moves[body] |= static_cast<char>(pin.moves);
  }
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const auto first = scene.pinned.begin() + scene.bodies[b].first_particle;
    const bool all = std::all_of(first, first + scene.bodies[b].particle_count(),
                                 [](char pinned) { return pinned != 0; });
    const bool is_rigid = all && (moves[b] == 0 || pin_count[b] == 1);
    const bool is_loaded =
        std::ranges::count(scene.source.load, scene.bodies[b].name, &LoadCase::body) > 0;
    is_held.push_back(static_cast<char>(is_rigid && !is_loaded));
  }
  return is_held;
}

// Returns values by particle in a new order of bodies. `all` may have values for the first bodies
// only; other bodies are skipped.
template <class Value>
std::vector<Value> reordered(const std::vector<Value>& all, const std::vector<SceneBody>& bodies,
                             const std::vector<int>& order) {
  std::vector<Value> result;
  for (const int b : order) {
    if (bodies[b].first_particle >= static_cast<int>(all.size())) continue;
    const auto first = all.begin() + bodies[b].first_particle;
    result.insert(result.end(), first, first + bodies[b].particle_count());
  }
  return result;
}

void reorder(Scene& scene, const std::vector<int>& order, std::vector<PrescribedMotion>& pins) {
  scene.initial_position = reordered(scene.initial_position, scene.bodies, order);
  scene.mass = reordered(scene.mass, scene.bodies, order);
  scene.pinned = reordered(scene.pinned, scene.bodies, order);
  std::vector<SceneBody> bodies;
  std::vector<int> shift(order.size());
  int first = 0;
  for (const int b : order) {
    shift[b] = first - scene.bodies[b].first_particle;
    first += scene.bodies[b].particle_count();
  }
  for (PrescribedMotion& pin : pins) {
    if (pin.particles.empty()) continue;
    const int by = shift[scene.body_index_of_particle(pin.particles.front())];
    for (int& particle : pin.particles) particle += by;
  }
  for (const int b : order) {
    bodies.push_back(std::move(scene.bodies[b]));
    bodies.back().first_particle += shift[b];
  }
  scene.bodies = std::move(bodies);
}

// Returns the index of the first spin, or the number of dynamic particles if there are no spins.
int first_spin(const Scene& scene) {
  const auto spins = std::ranges::find(scene.bodies, true, &SceneBody::are_spins);
  return spins == scene.bodies.end() ? scene.dynamic_particles : spins->first_particle;
}

void make_obstacle(SceneBody& body, Scene& scene, std::vector<PrescribedMotion>& pins) {
  body.dynamic = false;
  body.moves = false;
  for (const PrescribedMotion& pin : pins) {
    if (!pin.particles.empty() &&
        scene.body_index_of_particle(pin.particles.front()) == &body - scene.bodies.data())
      body.moves |= pin.moves;
  }
}

}  // namespace

void hold_bodies(Scene& scene, std::span<const char> is_held, std::vector<PrescribedMotion>& pins) {
  const int all = static_cast<int>(scene.bodies.size()), dynamic = scene.dynamic_bodies;
  std::vector<int> order(all), place(all);
  std::iota(order.begin(), order.end(), 0);
  const auto held = std::stable_partition(order.begin(), order.begin() + dynamic,
                                          [&](int b) { return is_held[b] == 0; });
  if (held == order.begin() || held == order.begin() + dynamic) return;
  scene.dynamic_bodies = static_cast<int>(held - order.begin());
  reorder(scene, order, pins);
  for (int b = 0; b < all; ++b) place[order[b]] = b;
  for (int& body : scene.case_order) body = place[body];
  for (int b = scene.dynamic_bodies; b < dynamic; ++b) make_obstacle(scene.bodies[b], scene, pins);
  scene.dynamic_particles = scene.bodies[scene.dynamic_bodies].first_particle;
  scene.heavy_particles = first_spin(scene);
  scene.mass.resize(scene.dynamic_particles);
  scene.pinned.resize(scene.dynamic_particles);
  std::erase_if(pins, [&](const PrescribedMotion& pin) {
    return !pin.moves && !pin.particles.empty() && pin.particles[0] >= scene.dynamic_particles;
  });
}

void put_held_bodies_last(Scene& scene, std::vector<PrescribedMotion>& pins) {
  scene.dynamic_bodies = static_cast<int>(scene.bodies.size());
  scene.dynamic_particles = scene.particle_count;
  scene.heavy_particles = first_spin(scene);
  scene.case_order.resize(std::ranges::find(scene.bodies, true, &SceneBody::are_spins) -
                          scene.bodies.begin());
  std::iota(scene.case_order.begin(), scene.case_order.end(), 0);
  hold_bodies(scene, find_held(scene, pins), pins);
}

}  // namespace weft::sim
