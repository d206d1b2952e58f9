// The images that a run records: positions and fields of the bodies that the case selects, whole or
// in part. The image of a shell holds points of its surface and their velocities. Its contact
// forces are those on the control points.
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
  // Returns the positions (m) of each recorded body, by its recorded particles. `all` holds the
  // positions of all particles of the scene. The result is valid until the next call, and no longer
  // than `all`.
  const std::vector<std::span<const Vec3>>& positions(std::span<const Vec3> all);
  // Returns the values that the channels last computed, by recorded body and by field, with one
  // entry per recorded particle. The result is valid until the next call of this function or of
  // RecordedChannels::compute().
  const std::vector<std::vector<std::span<const double>>>& fields();

 private:
  std::span<const double> on_image(std::size_t body, std::size_t field,
                                   std::span<const double> values);

  const Scene& scene_;
  const RecordedChannels& channels_;
  std::vector<RecordedBody> recorded_;
  std::vector<std::vector<int>> components_;  // number of components, by body and field
  std::vector<std::vector<char>> is_velocity_;
  std::vector<std::span<const Vec3>> positions_;
  std::vector<std::vector<std::span<const double>>> fields_;
  // Storage for values of bodies that are recorded in part: positions by body, and fields by body
  // and field.
  std::vector<std::vector<Vec3>> position_memory_;
  std::vector<std::vector<std::vector<double>>> field_memory_;
  // Storage for values at surface points of shells: positions by body, and velocities by body and
  // field.
  std::vector<std::vector<Vec3>> point_memory_;
  std::vector<std::vector<std::vector<Vec3>>> velocity_memory_;
  // Maps from the control points of shells to the points of their images, by body. For other bodies
  // they are identities.
  std::vector<SurfaceMap> maps_;
};

}  // namespace weft::sim
