#include "sim/trajectory/frame_batch.h"

#include <cassert>

namespace weft::sim {
namespace {

// Returns the columns [first, first + width) of a table, row by row. `rows` is the table, whose
// rows have `columns` numbers.
std::vector<double> columns_of(const std::vector<double>& rows, std::size_t first,
                               std::size_t width, std::size_t columns) {
  assert(columns > 0 && rows.size() % columns == 0 && first + width <= columns);
  std::vector<double> values;
  values.reserve(rows.size() / columns * width);
  for (std::size_t i = first; i < rows.size(); i += columns) {
    for (std::size_t k = 0; k < width; ++k) values.push_back(rows[i + k]);
  }
  return values;
}

}  // namespace

FrameBatch::FrameBatch(const std::vector<TrajectoryBody>& bodies, Precision precision,
                       const Rounding& rounding)
    : bodies_(bodies),
      precision_(precision),
      rounding_(rounding),
      positions_(bodies.size()),
      exact_positions_(bodies.size()),
      fields_(bodies.size()) {
  for (std::size_t b = 0; b < bodies.size(); ++b) fields_[b].resize(bodies[b].fields.size());
}

void FrameBatch::add(double time, const std::vector<std::span<const Vec3>>& positions,
                     const FrameChannels& channels, std::span<const double> series,
                     std::span<const double> step_rows) {
  assert(positions.size() == bodies_.size());
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const TrajectoryBody& body = bodies_[b];
    if (!body.moves) continue;
    if (precision_ == Precision::float64) {
      append_positions(body.atlas, positions[b], rounding_, exact_positions_[b]);
    } else {
      append_positions(body.atlas, positions[b], rounding_, positions_[b]);
    }
    for (std::size_t f = 0; f < body.fields.size(); ++f) {
      append_texels(body.atlas, channels.fields[b][f], body.fields[f].components, fields_[b][f]);
    }
  }
  series_rows_.insert(series_rows_.end(), series.begin(), series.end());
  step_rows_.insert(step_rows_.end(), step_rows.begin(), step_rows.end());
  record_rows_.insert(record_rows_.end(), channels.records.begin(), channels.records.end());
  times_.push_back(time);
}

void FrameBatch::clear() {
  times_.clear();
  series_rows_.clear();
  step_rows_.clear();
  record_rows_.clear();
  for (std::vector<float>& list : positions_) list.clear();
  for (std::vector<double>& list : exact_positions_) list.clear();
  for (auto& of_body : fields_) {
    for (std::vector<float>& list : of_body) list.clear();
  }
}

std::size_t FrameBatch::bytes() const {
  std::size_t texels = 0, doubles = 0;
  for (const std::vector<float>& list : positions_) texels += list.size();
  for (const std::vector<double>& list : exact_positions_) doubles += list.size();
  for (const auto& of_body : fields_) {
    for (const std::vector<float>& list : of_body) texels += list.size();
  }
  return texels * sizeof(float) +
         (doubles + times_.size() + series_rows_.size() + step_rows_.size() + record_rows_.size()) *
             sizeof(double);
}

std::vector<double> FrameBatch::records(std::size_t first, std::size_t width,
                                        std::size_t columns) const {
  return columns_of(record_rows_, first, width, columns);
}

std::vector<double> FrameBatch::series(std::size_t column, std::size_t columns) const {
  return columns_of(series_rows_, column, 1, columns);
}

std::vector<double> FrameBatch::steps(std::size_t column, std::size_t columns) const {
  return columns_of(step_rows_, column, 1, columns);
}

}  // namespace weft::sim
