// The images of a trajectory: those of the bodies that the case records, whole or in part. Images
// of shells hold points of their surfaces and the velocities of these; their forces of contact are
// those on control points.
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

  // Returns the recorded bodies with their fields, as the trajectory stores them.
  std::vector<TrajectoryBody> bodies() const;
  // Returns the particles of these bodies that seams hold together, without those of parts.
  std::vector<SewnParticles> sewn() const;
  // Returns the positions of each recorded body, by its recorded particles. `all` holds the
  // positions of all particles of the scene. The result is valid until the next call and as long as
  // `all` is.
  const std::vector<std::span<const Vec3>>& positions(std::span<const Vec3> all);
  // Returns the field values of each recorded body, as the channels last computed them. The result
  // is valid until the next call of this function or of RecordedChannels::compute().
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
  // Values of bodies that are recorded in part: positions by body, fields by body and field.
  std::vector<std::vector<Vec3>> position_memory_;
  std::vector<std::vector<std::vector<double>>> field_memory_;
  // Points of shells: positions by body, velocities by body and field.
  std::vector<std::vector<Vec3>> point_memory_;
  std::vector<std::vector<std::vector<Vec3>>> velocity_memory_;
  // Maps from control points of shells to the points of their images; identities of other bodies.
  std::vector<SurfaceMap> maps_;
};

}  // namespace weft::sim
