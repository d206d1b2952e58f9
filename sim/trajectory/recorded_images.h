// The images that a trajectory holds: those of the bodies that the case records, whole or in part.
// Shells have points of their surface in them, with the velocities of these; forces of contact are
// those on their control points.
#pragma once

#include <span>
#include <vector>

#include "sim/channels/recorded_channels.h"
#include "sim/scene/recorded_bodies.h"
#include "sim/trajectory/trajectory.h"

namespace weft::sim {

class RecordedImages {
 public:
  // Keeps references to the scene and the channels.
  RecordedImages(const Scene& scene, const RecordedChannels& channels);

  // The bodies with their fields, as the trajectory knows them.
  std::vector<TrajectoryBody> bodies() const;
  // Positions of these bodies by their particles, from those of all particles of the scene. Spans
  // last until the next call, and as long as `all`.
  const std::vector<std::span<const Vec3>>& positions(std::span<const Vec3> all);
  // Values of the fields of these bodies in the frame that the channels were last computed for.
  // Spans last until the next call of this function or of RecordedChannels::compute().
  const std::vector<std::vector<std::span<const double>>>& fields();

 private:
  std::span<const double> on_image(std::size_t body, std::size_t field,
                                   std::span<const double> values);

  const Scene& scene_;
  const RecordedChannels& channels_;
  std::vector<RecordedBody> recorded_;
  std::vector<std::vector<int>> components_;  // by body and field
  std::vector<std::vector<char>> is_velocity_;
  std::vector<std::span<const Vec3>> positions_;
  std::vector<std::vector<std::span<const double>>> fields_;
  // Values of parts: positions by body, fields by body and field.
  std::vector<std::vector<Vec3>> position_memory_;
  std::vector<std::vector<std::vector<double>>> field_memory_;
  // Points of shells: positions by body, velocities by body and field.
  std::vector<std::vector<Vec3>> point_memory_;
  std::vector<std::vector<std::vector<Vec3>>> velocity_memory_;
  // Of shells, from control points to the points of their images; the identity of other bodies.
  std::vector<SurfaceMap> maps_;
};

}  // namespace weft::sim
