#include "sim/modes/mode_trajectory.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/base/output_folder.h"
#include "sim/channels/recorded_channels.h"
#include "sim/motion/dynamics.h"
#include "sim/scene/scene.h"
#include "sim/trajectory/recorded_images.h"

namespace weft::sim {

namespace {

using Series = TrajectoryWriter::Series;

// Largest displacement, as a fraction of the diagonal of the box around the simulated bodies.
constexpr double amplitude_part = 0.1;

const TrajectoryField displacement{"displacement", "m", "mode", 3};

// Writes frames of the displaced equilibrium.
class ModeWriter {
 public:
  ModeWriter(CaseEquilibrium& equilibrium, const ModeTrajectoryOptions& options)
      : scene_(equilibrium.scene()),
        channels_(equilibrium.simulation()),
        images_(scene_, channels_),
        bodies_(with_displacements()),
        place_(expanded(equilibrium)),
        rest_(copies(images_.positions(place_))),
        fields_(bodies_.size()),
        field_values_(bodies_.size()),
        writer_(in_output_folder(options.path), bodies_, series(options),
                {.title = scene_.source.title,
                 .case_text = scene_.source.resolved_text,
                 .compute = equilibrium.simulation().compute(),
                 .time_units = "1",
                 .force = options.force,
                 .precision = scene_.source.output.precision,
                 .compression = scene_.source.output.compression,
                 .compression_error = scene_.source.output.compression_error,
                 .commit_interval = std::numeric_limits<double>::infinity()},
                images_.positions(place_)) {
    Eigen::AlignedBox3d box;
    for (int i = 0; i < scene_.dynamic_particles; ++i) box.extend(place_[i]);
    amplitude_ = amplitude_part * box.diagonal().norm();
  }

  // Writes the equilibrium displaced by `factor` times amplitude_ times `shape`.
  void write(double time, double factor, std::span<const Vec3> shape,
             const std::vector<double>& values) {
    std::vector<Vec3> displaced = place_;
    for (std::size_t i = 0; i < shape.size(); ++i) displaced[i] += factor * amplitude_ * shape[i];
    const auto& positions = images_.positions(displaced);
    find_displacements(positions);
    writer_.write_frame(time, positions, {fields_, {}}, values);
  }
  void finish(const Bill& bill) { writer_.finish({"done", "", bill}); }

 private:
  static std::vector<Series> series(const ModeTrajectoryOptions& options) {
    std::vector<Series> all{{"mode", "1"}};
    all.insert(all.end(), options.series.begin(), options.series.end());
    return all;
  }
  static std::vector<Vec3> expanded(const CaseEquilibrium& equilibrium) {
    std::vector<Vec3> position, velocity;
    equilibrium.dynamics().expand_all(equilibrium.time(), equilibrium.state(), position, velocity);
    return position;
  }
  static std::vector<std::vector<Vec3>> copies(const std::vector<std::span<const Vec3>>& views) {
    std::vector<std::vector<Vec3>> all;
    all.reserve(views.size());
    for (const auto& each : views) all.emplace_back(each.begin(), each.end());
    return all;
  }
  std::vector<TrajectoryBody> with_displacements() const {
    std::vector<TrajectoryBody> bodies = images_.bodies();
    for (TrajectoryBody& body : bodies) {
      if (body.moves) body.fields = {displacement};
    }
    return bodies;
  }

  // Computes the displacements of the recorded points, which need not be particles.
  void find_displacements(const std::vector<std::span<const Vec3>>& positions) {
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      if (!bodies_[b].moves) continue;
      field_values_[b].clear();
      for (std::size_t i = 0; i < positions[b].size(); ++i) {
        const Vec3 way = positions[b][i] - rest_[b][i];
        field_values_[b].insert(field_values_[b].end(), way.begin(), way.end());
      }
      fields_[b] = {field_values_[b]};
    }
  }

  const Scene& scene_;
  RecordedChannels channels_;
  RecordedImages images_;
  std::vector<TrajectoryBody> bodies_;
  std::vector<Vec3> place_;  // positions of all particles (m)
  // Positions (m) of the recorded points at equilibrium, by body.
  std::vector<std::vector<Vec3>> rest_;
  std::vector<std::vector<std::span<const double>>> fields_;
  std::vector<std::vector<double>> field_values_;
  TrajectoryWriter writer_;
  double amplitude_ = 0;  // largest displacement (m)
};

}  // namespace

void write_modes(CaseEquilibrium& equilibrium, std::span<const RecordedMode> modes,
                 const ModeTrajectoryOptions& options, const Bill& bill) {
  ModeWriter writer(equilibrium, options);
  const std::vector<double> none(options.series.size() + 1,
                                 std::numeric_limits<double>::quiet_NaN());
  writer.write(0, 0, {}, none);
  const int count = options.frames_per_mode;
  for (std::size_t m = 0; m < modes.size(); ++m) {
    std::vector<double> values{static_cast<double>(m + 1)};
    values.insert(values.end(), modes[m].values.begin(), modes[m].values.end());
    for (int k = 1; k <= count; ++k) {
      const double phase = static_cast<double>(k) / count;
      const double factor = count == 1 ? 1 : std::sin(2 * std::numbers::pi * phase);
      writer.write(static_cast<double>(m) + phase, factor, modes[m].shape, values);
    }
  }
  writer.finish(bill);
}

}  // namespace weft::sim
