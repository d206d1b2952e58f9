#include "sim/trajectory/frame_batch.h"

#include <cassert>

namespace weft::sim {
namespace {

std::vector<double> column_of(const std::vector<double>& rows, std::size_t column,
                              std::size_t columns) {
  assert(columns > 0 && rows.size() % columns == 0);
  std::vector<double> values;
  values.reserve(rows.size() / columns);
  for (std::size_t i = column; i < rows.size(); i += columns) values.push_back(rows[i]);
  return values;
}

}  // namespace

void append_texels(const bsi::Atlas& atlas, std::span<const Vec3> by_particle,
                   std::vector<float>& texels) {
  assert(static_cast<int>(by_particle.size()) == atlas.particle_count());
  const std::size_t before = texels.size();
  texels.resize(before + 3 * static_cast<std::size_t>(atlas.texel_count()));
  float* target = texels.data() + before;
  for (int texel = 0; texel < atlas.texel_count(); ++texel) {
    const Vec3& value = by_particle[atlas.particle_of_texel(texel)];
    for (int axis = 0; axis < 3; ++axis) *target++ = static_cast<float>(value[axis]);
  }
}

FrameBatch::FrameBatch(const std::vector<TrajectoryBody>& bodies, bool velocity)
    : bodies_(bodies),
      has_velocity_(velocity),
      positions_(bodies.size()),
      velocities_(bodies.size()) {}

void FrameBatch::add(double time, const std::vector<std::span<const Vec3>>& positions,
                     const std::vector<std::span<const Vec3>>& velocities,
                     std::span<const double> series, std::span<const double> step_rows) {
  assert(positions.size() == bodies_.size());
  assert(!has_velocity_ || velocities.size() == bodies_.size());
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (!bodies_[b].moves) continue;
    append_texels(bodies_[b].atlas, positions[b], positions_[b]);
    if (has_velocity_) append_texels(bodies_[b].atlas, velocities[b], velocities_[b]);
  }
  series_rows_.insert(series_rows_.end(), series.begin(), series.end());
  step_rows_.insert(step_rows_.end(), step_rows.begin(), step_rows.end());
  times_.push_back(time);
}

void FrameBatch::clear() {
  times_.clear();
  series_rows_.clear();
  step_rows_.clear();
  for (std::vector<float>& list : positions_) list.clear();
  for (std::vector<float>& list : velocities_) list.clear();
}

std::size_t FrameBatch::bytes() const {
  std::size_t texels = 0;
  for (const std::vector<float>& list : positions_) texels += list.size();
  for (const std::vector<float>& list : velocities_) texels += list.size();
  return texels * sizeof(float) +
         (times_.size() + series_rows_.size() + step_rows_.size()) * sizeof(double);
}

std::vector<double> FrameBatch::series(std::size_t column, std::size_t columns) const {
  return column_of(series_rows_, column, columns);
}

std::vector<double> FrameBatch::steps(std::size_t column, std::size_t columns) const {
  return column_of(step_rows_, column, columns);
}

}  // namespace weft::sim
