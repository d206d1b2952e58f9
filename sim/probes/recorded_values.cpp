#include "sim/probes/recorded_values.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim/base/file_error.h"
#include "sim/case/case_text.h"
#include "sim/probes/shadow.h"
#include "sim/view/field_values.h"

namespace weft::sim {

namespace {

using QuantityKind = RecordedQuantity::Kind;
using QuantityPart = RecordedQuantity::Part;

constexpr double missing_number = std::numeric_limits<double>::quiet_NaN();

double part_of(const Vec3& vector, QuantityPart part) {
  return part == QuantityPart::length ? vector.norm() : vector[static_cast<int>(part)];
}

bool are_finite(const std::vector<Vec3>& points) {
  return std::ranges::all_of(points, [](const Vec3& point) { return point.allFinite(); });
}

}  // namespace

RecordedValues::RecordedValues(const TrajectoryReader& reader)
    : reader_(reader), contents_(reader.contents()) {}

const std::vector<double>& RecordedValues::list(const std::string& path, const auto& read) {
  const auto found = lists_.find(path);
  return found != lists_.end() ? found->second : lists_.emplace(path, read()).first->second;
}

int RecordedValues::count(Instants instants) {
  if (instants == Instants::frames) return reader_.frames();
  return static_cast<int>(list("steps/time", [&] { return reader_.step_values("time"); }).size());
}

double RecordedValues::time(Instants instants, int index) {
  if (instants == Instants::frames) return reader_.time(index);
  return list("steps/time", [&] { return reader_.step_values("time"); })[index];
}

double RecordedValues::series(Instants instants, int number, int index) {
  if (instants == Instants::frames) {
    const std::string& name = contents_.series[number].name;
    return list("series/" + name, [&] { return reader_.series_values(name); })[index];
  }
  const std::string& name = contents_.step_series[number].name;
  return list("steps/" + name, [&] { return reader_.step_values(name); })[index];
}

const std::vector<Vec3>& RecordedValues::positions(int body, int frame) {
  auto& [held, values] = positions_[body];
  const int wanted = contents_.bodies[body].moves ? frame : 0;
  if (held != wanted) {
    values = reader_.positions(body, wanted);
    held = wanted;
  }
  return values;
}

const std::vector<double>& RecordedValues::field(int body, const std::string& name, int frame) {
  auto& [held, values] = fields_[{body, name}];
  if (held != frame) {
    values = reader_.field_values(body, name, frame);
    held = frame;
  }
  return values;
}

const RecordedValues::Surface& RecordedValues::surface(int body) {
  const auto found = surfaces_.find(body);
  if (found != surfaces_.end()) return found->second;
  RecordedSurface surface(contents_.bodies[body]);
  try {
    std::vector<std::array<int, 3>> triangles = surface.mesh().triangles;
    return surfaces_.emplace(body, Surface{std::move(surface), std::move(triangles)}).first->second;
  } catch (const std::invalid_argument& error) {
    throw FileError("body " + in_quotes(contents_.bodies[body].name) +
                    " has no surface: " + error.what());
  }
}

Vec3 RecordedValues::vector(const RecordedQuantity& quantity, int frame) {
  switch (quantity.kind) {
    case QuantityKind::position:
      return positions(quantity.body, frame)[quantity.particle];
    case QuantityKind::displacement: {
      auto& first = first_positions_[quantity.body];
      if (first.empty()) first = reader_.positions(quantity.body, 0);
      return positions(quantity.body, frame)[quantity.particle] - first[quantity.particle];
    }
    case QuantityKind::field: {
      const double* values = &field(quantity.body, quantity.name, frame)[3 * quantity.particle];
      return {values[0], values[1], values[2]};
    }
    case QuantityKind::record: {
      const double* values = &list(quantity.name, [&] {
        return reader_.record_values(quantity.name);
      })[3 * static_cast<std::size_t>(frame)];
      return {values[0], values[1], values[2]};
    }
    case QuantityKind::shadow:
      return shadow(quantity.body, frame, quantity.part);
    default: {
      const std::vector<Vec3>& points = positions(quantity.body, frame);
      Vec3 lower = points.front(), upper = points.front();
      for (const Vec3& point : points) {
        lower = lower.cwiseMin(point);
        upper = upper.cwiseMax(point);
      }
      if (!are_finite(points)) lower = upper = Vec3::Constant(missing_number);
      if (quantity.kind == QuantityKind::size) return upper - lower;
      return quantity.kind == QuantityKind::lower ? lower : upper;
    }
  }
}

// Returns a vector that has the area of the shadow along `axis`, and zeros.
Vec3 RecordedValues::shadow(int body, int frame, QuantityPart axis) {
  const auto& [surface_of_body, triangles] = surface(body);
  const std::vector<Vec3> points = surface_of_body.points(positions(body, frame));
  Vec3 areas = Vec3::Zero();
  const int number = static_cast<int>(axis);
  areas[number] = are_finite(points) ? shadow_area(points, triangles, number) : missing_number;
  return areas;
}

double RecordedValues::area(int body, int frame) {
  const auto& [surface_of_body, triangles] = surface(body);
  return surface_area(surface_of_body.points(positions(body, frame)), triangles);
}

// Returns the extreme of the field's finite values, or NaN if there is none.
double RecordedValues::extreme(const RecordedQuantity& quantity, int frame) {
  const auto& fields = contents_.bodies[quantity.body].fields;
  const int components =
      std::ranges::find(fields, quantity.name, &TrajectoryField::name)->components;
  double result = missing_number;
  for (const double value : magnitudes(field(quantity.body, quantity.name, frame), components)) {
    if (!std::isfinite(value)) continue;
    const bool is_further =
        quantity.kind == QuantityKind::largest ? value > result : value < result;
    if (std::isnan(result) || is_further) result = value;
  }
  return result;
}

double RecordedValues::quantity(const RecordedQuantity& quantity, int frame) {
  if (quantity.part != QuantityPart::number) return part_of(vector(quantity, frame), quantity.part);
  switch (quantity.kind) {
    case QuantityKind::field:
      return field(quantity.body, quantity.name, frame)[quantity.particle];
    case QuantityKind::record:
      return list(quantity.name, [&] { return reader_.record_values(quantity.name); })[frame];
    case QuantityKind::area:
      return area(quantity.body, frame);
    default:
      return extreme(quantity, frame);
  }
}

double RecordedValues::number(RunNumber number) const {
  const int frames = reader_.frames();
  const std::optional<RunEnd> end = reader_.end();
  switch (number) {
    case RunNumber::cpu_time:
      return end ? end->bill.total.cpu : missing_number;
    case RunNumber::wall_time:
      return end ? end->bill.total.wall : missing_number;
    case RunNumber::duration:
      return frames > 0 ? reader_.time(frames - 1) : missing_number;
    case RunNumber::frames:
      return frames;
  }
  return missing_number;
}

}  // namespace weft::sim
