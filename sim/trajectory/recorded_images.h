// The images that a trajectory holds: those of the bodies that the case records, whole or in part.
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
  // The particles of these bodies that seams hold together; without those of parts.
  std::vector<SewnParticles> sewn() const;
  // Positions of these bodies by their particles, from those of all particles of the scene. Spans
  // last until the next call, and as long as `all`.
  const std::vector<std::span<const Vec3>>& positions(std::span<const Vec3> all);
  // Values of the fields of these bodies in the frame that the channels were last computed for.
  // Spans last until the next call of this function or of RecordedChannels::compute().
  const std::vector<std::vector<std::span<const double>>>& fields();

 private:
  const Scene& scene_;
  const RecordedChannels& channels_;
  std::vector<RecordedBody> recorded_;
  std::vector<std::vector<int>> components_;  // by body and field
  std::vector<std::span<const Vec3>> positions_;
  std::vector<std::vector<std::span<const double>>> fields_;
  // Values of parts: positions by body, fields by body and field.
  std::vector<std::vector<Vec3>> position_memory_;
  std::vector<std::vector<std::vector<double>>> field_memory_;
};

}  // namespace weft::sim
