// Frames that wait in memory for the next commit of a trajectory. Private to sim/.
#pragma once

#include <span>
#include <vector>

#include "sim/trajectory/image_storage.h"
#include "sim/trajectory/trajectory.h"

namespace weft::sim {

// Frames as the file holds them: for each body its images one after the other, by texel. Positions
// are rounded as `rounding` says.
class FrameBatch {
 public:
  // `bodies` is kept by reference.
  FrameBatch(const std::vector<TrajectoryBody>& bodies, Precision precision,
             const Rounding& rounding);

  // Takes the arguments of TrajectoryWriter::write_frame.
  void add(double time, const std::vector<std::span<const Vec3>>& positions,
           const FrameChannels& channels, std::span<const double> series,
           std::span<const double> step_rows);
  // Forgets the frames but keeps their memory for others.
  void clear();

  int frames() const { return static_cast<int>(times_.size()); }
  // Returns the memory that the frames take, bytes.
  std::size_t bytes() const;
  const std::vector<double>& times() const { return times_; }
  // Images of a body, frame by frame; empty for a body that does not move. Only the list of the
  // batch's precision is filled; the other one is empty.
  const std::vector<float>& positions(std::size_t body) const { return positions_[body]; }
  const std::vector<double>& exact_positions(std::size_t body) const {
    return exact_positions_[body];
  }
  const std::vector<float>& field(std::size_t body, std::size_t field) const {
    return fields_[body][field];
  }
  // The values of records, `width` numbers from `first` on, of frames that have `columns`.
  std::vector<double> records(std::size_t first, std::size_t width, std::size_t columns) const;
  // The values of one of `columns` series: one per frame, or one per step.
  std::vector<double> series(std::size_t column, std::size_t columns) const;
  std::vector<double> steps(std::size_t column, std::size_t columns) const;

 private:
  const std::vector<TrajectoryBody>& bodies_;
  Precision precision_;
  Rounding rounding_;  // of positions
  std::vector<double> times_, series_rows_, step_rows_, record_rows_;
  std::vector<std::vector<float>> positions_;
  std::vector<std::vector<double>> exact_positions_;
  std::vector<std::vector<std::vector<float>>> fields_;  // by body and field
};

}  // namespace weft::sim
