#include "sim/view/painted_field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim/case/case_text.h"
#include "sim/view/field_values.h"
#include "sim/view/render_trajectory.h"

namespace weft::sim {
namespace {

// Returns an error message for a field that no body has. `names` lists the existing fields.
std::string unknown_field(const std::string& name, const std::vector<std::string>& names) {
  if (names.empty()) {
    return "there is no field " + in_quotes(name) +
           ": the file has positions only; [output] of the case says what is recorded";
  }
  const auto near = nearest_name(name, names);
  return "there is no field " + in_quotes(name) + " in the file" +
         (near ? "; did you mean " + in_quotes(*near) + "? It has " : "; it has ") +
         quoted_list(names);
}

}  // namespace

PaintedField::PaintedField(const TrajectoryReader& reader, const std::string& name,
                           const std::vector<int>& frames,
                           std::optional<std::array<double, 2>> range)
    : reader_(reader) {
  bool is_known = false;
  for (int b = 0; b < static_cast<int>(reader.bodies().size()); ++b) {
    const std::vector<TrajectoryField>& fields = reader.bodies()[b].fields;
    const auto found = std::ranges::find(fields, name, &TrajectoryField::name);
    if (found == fields.end()) {
      fields_.emplace_back();
      plain_bodies_.push_back(reader.bodies()[b].name);
      continue;
    }
    fields_.emplace_back(*found);
    if (!is_known) {
      legend_.name = name;
      legend_.units = found->units;
      legend_.magnitude = found->components > 1;
    }
    is_known = true;
  }
  if (!is_known) throw RenderUsageError(unknown_field(name, field_names(reader)));
  find_extremes(frames);
  legend_.scale =
      range ? scale_between((*range)[0], (*range)[1]) : scale_between(legend_.least, legend_.most);
}

std::vector<double> PaintedField::values(int body, int frame) const {
  return magnitudes(reader_.field_values(body, fields_[body]->name, frame),
                    fields_[body]->components);
}

void PaintedField::find_extremes(const std::vector<int>& frames) {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const int frame : frames) {
    for (std::size_t b = 0; b < fields_.size(); ++b) {
      if (!fields_[b]) continue;
      for (const double value : values(static_cast<int>(b), frame)) {
        if (!std::isfinite(value)) continue;
        least = std::min(least, value);
        most = std::max(most, value);
      }
    }
  }
  if (least > most) {
    throw std::runtime_error("field " + in_quotes(legend_.name) +
                             " has no finite value in the frames to be drawn");
  }
  legend_.least = least;
  legend_.most = most;
}

void PaintedField::paint(int frame, RenderedBody& body) const {
  body.places.clear();
  if (!fields_[body.index]) return;
  for (const double value : body.surface.values(values(body.index, frame))) {
    body.places.push_back(legend_.scale.place_of(value));
  }
  body.colour_map = &legend_.scale.map();
}

}  // namespace weft::sim
