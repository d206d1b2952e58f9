#include "sim/view/field_extremes.h"

#include <algorithm>
#include <cmath>

#include "sim/view/field_values.h"

namespace weft::sim {
namespace {

// Updates the extremes of a summary by a value. describe() returns the FieldExtreme of the value.
// It is called only if the value is a new extreme.
void add_value(double value, auto& summary, const auto& describe) {
  const bool is_first = !summary.has_extremes;
  if (is_first || value < summary.minimum.value) summary.minimum = describe();
  if (is_first || value > summary.maximum.value) summary.maximum = describe();
  summary.has_extremes = true;
}

// Returns the texel of a particle in the body's whole image, even if only a part of the image is
// recorded.
bsi::TexelAddress place_of(const TrajectoryBody& body, int particle) {
  bsi::TexelAddress place = body.atlas.particle_address(particle);
  if (body.is_part()) {
    place.row = body.part_rows[place.row];
    place.col = body.part_cols[place.col];
  }
  return place;
}

// Updates the summary by the values of one body in one frame.
void add_values(const TrajectoryReader& reader, int body, int frame,
                const std::vector<double>& values, FieldSummary& summary) {
  const TrajectoryBody& at = reader.bodies()[body];
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) {
      ++summary.not_finite;
      continue;
    }
    add_value(values[i], summary, [&] {
      return FieldExtreme{values[i], frame, reader.time(frame), at.name,
                          place_of(at, static_cast<int>(i))};
    });
  }
}

FieldSummary summarise_field(const TrajectoryReader& reader, const std::string& name) {
  FieldSummary summary;
  summary.name = name;
  for (int b = 0; b < static_cast<int>(reader.bodies().size()); ++b) {
    const std::vector<TrajectoryField>& fields = reader.bodies()[b].fields;
    const auto field = std::ranges::find(fields, name, &TrajectoryField::name);
    if (field == fields.end()) continue;
    summary.units = field->units;
    summary.magnitude = field->components > 1;
    for (int f = 0; f < reader.frames(); ++f) {
      add_values(reader, b, f, magnitudes(reader.field_values(b, name, f), field->components),
                 summary);
    }
  }
  return summary;
}

RecordSummary summarise_record(const TrajectoryReader& reader, const TrajectoryRecord& record) {
  RecordSummary summary;
  summary.path = record.path;
  summary.units = record.units;
  summary.magnitude = record.components > 1;
  const std::vector<double> values =
      magnitudes(reader.record_values(record.path), record.components);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    const int frame = static_cast<int>(i);
    add_value(values[i], summary, [&] {
      return FieldExtreme{values[i], frame, reader.time(frame), {}, {}};
    });
  }
  return summary;
}

}  // namespace

std::vector<FieldSummary> field_extremes(const TrajectoryReader& reader) {
  std::vector<FieldSummary> summaries;
  for (const std::string& name : field_names(reader)) {
    summaries.push_back(summarise_field(reader, name));
  }
  return summaries;
}

std::vector<RecordSummary> record_extremes(const TrajectoryReader& reader) {
  std::vector<RecordSummary> summaries;
  for (const TrajectoryRecord& record : reader.records()) {
    if (record.channel == "largest_stretch_place") continue;
    summaries.push_back(summarise_record(reader, record));
  }
  return summaries;
}

}  // namespace weft::sim
