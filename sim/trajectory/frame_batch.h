// Frames that wait in memory for the next commit of a trajectory. Private to sim/.
#pragma once

#include <span>
#include <vector>

#include "sim/trajectory/image_storage.h"
#include "sim/trajectory/trajectory.h"

namespace weft::sim {

// Frames in the layout of the file: per body and dataset, one image by texel after the other.
// Positions are rounded as `rounding` says.
class FrameBatch {
 public:
  // `bodies` is kept by reference.
  FrameBatch(const std::vector<TrajectoryBody>& bodies, Precision precision,
             const Rounding& rounding);

  // Adds a frame. The arguments are those of TrajectoryWriter::write_frame().
  void add(double time, const std::vector<std::span<const Vec3>>& positions,
           const FrameChannels& channels, std::span<const double> series,
           std::span<const double> step_rows);
  // Removes the frames but keeps their memory for later ones.
  void clear();

  int frames() const { return static_cast<int>(times_.size()); }
  // Returns the memory that the frames occupy (bytes).
  std::size_t bytes() const;
  const std::vector<double>& times() const { return times_; }
  // Images of a body, frame by frame; empty for a body that does not move. Only the list of the
  // batch's precision is filled: exact_positions() for float64, positions() for float32.
  const std::vector<float>& positions(std::size_t body) const { return positions_[body]; }
  const std::vector<double>& exact_positions(std::size_t body) const {
    return exact_positions_[body];
  }
  const std::vector<float>& field(std::size_t body, std::size_t field) const {
    return fields_[body][field];
  }
  // Returns `width` numbers per frame from the records, starting at column `first`. The records of
  // a frame have `columns` numbers.
  std::vector<double> records(std::size_t first, std::size_t width, std::size_t columns) const;
  // Returns the values of one of `columns` series. series() gives one value per frame, steps() one
  // per step.
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
