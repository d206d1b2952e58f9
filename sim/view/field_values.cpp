#include "sim/view/field_values.h"

#include <algorithm>

#include "sim/case/case_text.h"

namespace weft::sim {

std::vector<std::string> field_names(const TrajectoryReader& reader) {
  std::vector<std::string> names;
  for (const TrajectoryBody& body : reader.bodies()) {
    for (const TrajectoryField& field : body.fields) {
      if (std::ranges::find(names, field.name) == names.end()) names.push_back(field.name);
    }
  }
  return names;
}

std::string after_number(const std::string& units) {
  return units.empty() || units == "1" ? "" : ' ' + printable(units);
}

std::vector<double> magnitudes(std::vector<double> values, int components) {
  if (components == 1) return values;
  for (std::size_t i = 0; i < values.size() / 3; ++i) {
    values[i] = Vec3(values[3 * i], values[3 * i + 1], values[3 * i + 2]).norm();
  }
  values.resize(values.size() / 3);
  return values;
}

}  // namespace weft::sim
