#include "sim/trajectory/recorded_images.h"

#include <algorithm>

#include "sim/scene/shell_body.h"

namespace weft::sim {

RecordedImages::RecordedImages(const Scene& scene, const RecordedChannels& channels)
    : scene_(scene),
      channels_(channels),
      recorded_(recorded_bodies(scene)),
      components_(recorded_.size()),
      is_velocity_(recorded_.size()),
      positions_(recorded_.size()),
      fields_(recorded_.size()),
      position_memory_(recorded_.size()),
      field_memory_(recorded_.size()),
      point_memory_(recorded_.size()),
      velocity_memory_(recorded_.size()) {
  for (std::size_t i = 0; i < recorded_.size(); ++i) {
    const SceneBody& body = scene.bodies[recorded_[i].body];
    maps_.push_back(map_to_image(body));
    for (const ChannelPlace& place : channels.fields(body)) {
      components_[i].push_back(place.dataset->components);
      is_velocity_[i].push_back(place.channel->id == ChannelId::velocity);
    }
    fields_[i].resize(components_[i].size());
    field_memory_[i].resize(components_[i].size());
    velocity_memory_[i].resize(components_[i].size());
  }
}

std::vector<TrajectoryBody> RecordedImages::bodies() const {
  std::vector<TrajectoryBody> bodies;
  for (const RecordedBody& recorded : recorded_) {
    const SceneBody& body = scene_.bodies[recorded.body];
    TrajectoryBody& written = bodies.emplace_back();
    written.name = body.name;
    written.atlas = body.atlas;
    written.moves = body.moves;
    written.is_obstacle = body.is_obstacle;
    written.thickness = body.thickness;
    if (body.spheres != nullptr) written.radii.assign(body.particle_count(), body.spheres->radius);
    written.spline_degree = body.spline ? body.spline->degree() : 0;
    for (const auto& [channel, dataset, path] : channels_.fields(body)) {
      written.fields.push_back({dataset->name, dataset->units, channel->name, dataset->components});
    }
    if (!recorded.part) continue;
    written.atlas = recorded.part->atlas;
    written.part_rows = recorded.part->rows;
    written.part_cols = recorded.part->cols;
  }
  return bodies;
}

std::vector<SewnParticles> RecordedImages::sewn() const {
  std::vector<SewnParticles> pairs;
  const auto find = [&](int point, int& particle) {
    const int body = scene_.body_index_of_point(point);
    const auto found = std::ranges::find(recorded_, body, &RecordedBody::body);
    if (found == recorded_.end() || found->part) return -1;
    particle = point - scene_.bodies[body].first_point;
    return static_cast<int>(found - recorded_.begin());
  };
  scene_.sewn.visit_pairs([&](int point, int other) {
    SewnParticles pair;
    pair.body = find(point, pair.particle);
    pair.other_body = find(other, pair.other_particle);
    if (pair.body >= 0 && pair.other_body >= 0) pairs.push_back(pair);
  });
  return pairs;
}

const std::vector<std::span<const Vec3>>& RecordedImages::positions(std::span<const Vec3> all) {
  for (std::size_t i = 0; i < recorded_.size(); ++i) {
    const SceneBody& body = scene_.bodies[recorded_[i].body];
    const std::span<const Vec3> particles = all.subspan(body.first_particle, body.particle_count());
    positions_[i] = recorded_[i].of_recorded(
        maps_[i].points_of(particles, body.particle_count(), point_memory_[i]), 1,
        position_memory_[i]);
  }
  return positions_;
}

const std::vector<std::vector<std::span<const double>>>& RecordedImages::fields() {
  const auto& values = channels_.field_values();
  for (std::size_t i = 0; i < recorded_.size(); ++i) {
    for (std::size_t f = 0; f < fields_[i].size(); ++f) {
      fields_[i][f] = recorded_[i].of_recorded(on_image(i, f, values[recorded_[i].order][f]),
                                               components_[i][f], field_memory_[i][f]);
    }
  }
  return fields_;
}

// Returns the values of a field as the image holds them. Velocities of a shell are mapped from its
// control points to the points of the image.
std::span<const double> RecordedImages::on_image(std::size_t i, std::size_t field,
                                                 std::span<const double> values) {
  if (maps_[i].is_identity() || is_velocity_[i][field] == 0) return values;
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  const std::size_t count = values.size() / 3;
  const std::span<const Vec3> velocities(reinterpret_cast<const Vec3*>(values.data()), count);
  const std::span<const Vec3> points =
      maps_[i].points_of(velocities, static_cast<int>(count), velocity_memory_[i][field]);
  return {points[0].data(), values.size()};
}

}  // namespace weft::sim
