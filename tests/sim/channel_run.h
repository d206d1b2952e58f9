// A simulation whose channels tests ask for.
#pragma once

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "sim/channels/recorded_channels.h"
#include "sim/motion/dynamics.h"
#include "sim/simulation/simulation.h"
#include "tests/sim/simulated_case.h"

namespace weft::sim {

class ChannelRun {
 public:
  explicit ChannelRun(const std::string& text, const Overrides& overrides = {})
      : scene_(build_scene(parse_case(text, "test.toml", overrides))),
        simulation_(*scene_),
        channels_(simulation_) {
    compute();
  }

  // Steps to the time and computes the channels there.
  void advance_to(double time) {
    if (time > simulation_.time()) {
      if (const auto failure = simulation_.advance(time - simulation_.time()))
        ADD_FAILURE() << failure->text;
    }
    compute();
  }
  void compute() {
    const auto y = simulation_.state();
    simulation_.dynamics().expand_all(simulation_.time(), y, position_, velocity_);
    channels_.compute(simulation_.time(), y, position_, velocity_);
  }

  const Scene& scene() const { return *scene_; }
  Simulation& simulation() { return simulation_; }
  const RecordedChannels& channels() const { return channels_; }
  // Positions (m) and velocities (m/s) of all particles of the scene.
  const std::vector<Vec3>& position() const { return position_; }
  const std::vector<Vec3>& velocity() const { return velocity_; }

  // Values of a field of a body, `components` numbers per particle.
  std::vector<double> field(const std::string& body, const std::string& name) const {
    for (std::size_t i = 0; i < scene_->case_order.size(); ++i) {
      const SceneBody& of = scene_->bodies[scene_->case_order[i]];
      if (of.name != body) continue;
      const std::vector<ChannelPlace> fields = channels_.fields(of);
      for (std::size_t f = 0; f < fields.size(); ++f) {
        const auto values = channels_.field_values()[i][f];
        if (name == fields[f].dataset->name) return {values.begin(), values.end()};
      }
    }
    ADD_FAILURE() << "no field " << name << " of " << body;
    return {};
  }
  std::vector<Vec3> vectors(const std::string& body, const std::string& name) const {
    const std::vector<double> values = field(body, name);
    std::vector<Vec3> result;
    for (std::size_t i = 0; i + 2 < values.size(); i += 3)
      result.emplace_back(values[i], values[i + 1], values[i + 2]);
    return result;
  }
  std::vector<double> record(const std::string& path) const {
    std::size_t first = 0;
    for (const ChannelPlace& place : channels_.records()) {
      const auto width = static_cast<std::size_t>(place.dataset->components);
      const auto values = channels_.record_values().subspan(first, width);
      if (place.path == path) return {values.begin(), values.end()};
      first += width;
    }
    ADD_FAILURE() << "no record " << path;
    return {0, 0, 0};
  }
  Vec3 vector(const std::string& path) const {
    const std::vector<double> values = record(path);
    return {values[0], values[1], values[2]};
  }
  // Sums the records "reactions/.../NAME".
  Vec3 sum_of_reactions(const std::string& name) const {
    Vec3 sum = Vec3::Zero();
    for (const ChannelPlace& place : channels_.records()) {
      if (place.path.starts_with("reactions/") && place.path.ends_with("/" + name))
        sum += vector(place.path);
    }
    return sum;
  }

  // Weight (N), its moment about the origin (N m), momentum (kg m/s) and angular momentum of all
  // simulated bodies.
  Vec3 weight() const {
    return sum_over_particles([&](int i) { return Vec3(scene_->mass[i] * gravity()); });
  }
  Vec3 weight_moment() const {
    return sum_over_particles(
        [&](int i) { return position_[i].cross(scene_->mass[i] * gravity()); });
  }
  Vec3 momentum() const {
    return sum_over_particles([&](int i) { return Vec3(scene_->mass[i] * velocity_[i]); });
  }
  Vec3 angular_momentum() const {
    return sum_over_particles(
        [&](int i) { return position_[i].cross(scene_->mass[i] * velocity_[i]); });
  }

 private:
  Vec3 gravity() const { return simulation_.dynamics().gravity(simulation_.time()); }
  template <class Value>
  Vec3 sum_over_particles(const Value& value) const {
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < scene_->dynamic_particles; ++i) sum += value(i);
    return sum;
  }

  std::unique_ptr<const Scene> scene_;
  Simulation simulation_;
  RecordedChannels channels_;
  std::vector<Vec3> position_, velocity_;
};

inline Vec3 sum_of(const std::vector<Vec3>& all) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& each : all) sum += each;
  return sum;
}

}  // namespace weft::sim
