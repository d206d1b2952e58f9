// Frames that wait in memory for the next commit of a trajectory. Private to sim/.
#pragma once

#include <span>
#include <vector>

#include "sim/trajectory/image_storage.h"
#include "sim/trajectory/trajectory.h"

namespace weft::sim {

// The waiting frames, in the layout of the file. Each dataset of a body is a list of images, frame
// by frame, and an image is stored texel by texel.
class FrameBatch {
 public:
  // Keeps a reference to `bodies`. Positions are stored with `precision` and rounded by `rounding`.
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
  // Return the images of a body's positions (m); empty for a body that does not move. With
  // precision float64, exact_positions() has the images and positions() is empty; with float32,
  // vice versa.
  const std::vector<float>& positions(std::size_t body) const { return positions_[body]; }
  const std::vector<double>& exact_positions(std::size_t body) const {
    return exact_positions_[body];
  }
  // Returns the images of a field of a body.
  const std::vector<float>& field(std::size_t body, std::size_t field) const {
    return fields_[body][field];
  }
  // Returns the columns [first, first + width) of the records, frame by frame. The records of a
  // frame have `columns` numbers altogether.
  std::vector<double> records(std::size_t first, std::size_t width, std::size_t columns) const;
  // Return the values of one of `columns` series: one value per frame (series()) or per step
  // (steps()).
  std::vector<double> series(std::size_t column, std::size_t columns) const;
  std::vector<double> steps(std::size_t column, std::size_t columns) const;

 private:
  const std::vector<TrajectoryBody>& bodies_;
  Precision precision_;
  Rounding rounding_;  // rounding of positions
  std::vector<double> times_, series_rows_, step_rows_, record_rows_;
  std::vector<std::vector<float>> positions_;
  std::vector<std::vector<double>> exact_positions_;
  std::vector<std::vector<std::vector<float>>> fields_;  // images by body and field
};

}  // namespace weft::sim
