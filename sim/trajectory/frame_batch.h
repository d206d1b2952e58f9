// Frames that wait in memory for the next commit of a trajectory. Private to sim/.
#pragma once

#include <span>
#include <vector>

#include "sim/trajectory/trajectory.h"

namespace weft::sim {

// Frames as the file holds them: the images of a body one after the other, float32, by texel.
class FrameBatch {
 public:
  // `bodies` is kept by reference.
  FrameBatch(const std::vector<TrajectoryBody>& bodies, bool velocity);

  // Takes the arguments of TrajectoryWriter::write_frame.
  void add(double time, const std::vector<std::span<const Vec3>>& positions,
           const std::vector<std::span<const Vec3>>& velocities, std::span<const double> series,
           std::span<const double> step_rows);
  // Forgets the frames but keeps their memory for others.
  void clear();

  int frames() const { return static_cast<int>(times_.size()); }
  // Returns the memory that the frames take, bytes.
  std::size_t bytes() const;
  const std::vector<double>& times() const { return times_; }
  // Images of a body, frame by frame; empty for a body that does not move.
  const std::vector<float>& positions(std::size_t body) const { return positions_[body]; }
  const std::vector<float>& velocities(std::size_t body) const { return velocities_[body]; }
  // The values of one of `columns` series: one per frame, or one per step.
  std::vector<double> series(std::size_t column, std::size_t columns) const;
  std::vector<double> steps(std::size_t column, std::size_t columns) const;

 private:
  const std::vector<TrajectoryBody>& bodies_;
  bool has_velocity_;
  std::vector<double> times_, series_rows_, step_rows_;
  std::vector<std::vector<float>> positions_, velocities_;
};

// Appends the image of a body, float32 by texel, from values by particle.
void append_texels(const bsi::Atlas& atlas, std::span<const Vec3> by_particle,
                   std::vector<float>& texels);

}  // namespace weft::sim
