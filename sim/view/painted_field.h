// A recorded field as colours of the bodies in pictures. For render_trajectory.cpp.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "sim/trajectory/trajectory.h"
#include "sim/view/colour_scale.h"
#include "sim/view/rendered_body.h"

namespace weft::sim {

// A field of one name, of all bodies that have it; vectors count by their magnitude.
class PaintedField {
 public:
  // Reads the field in all `frames` for the range of its values, unless one is given. Throws
  // RenderUsageError if no body has a field of this name, std::runtime_error if all values to be
  // drawn are NaN. O(values in these frames).
  PaintedField(const TrajectoryReader& reader, const std::string& name,
               const std::vector<int>& frames, std::optional<std::array<double, 2>> range);

  // Gives the body the places of a frame in the colour map; none if it lacks the field.
  void paint(int frame, RenderedBody& body) const;
  const Legend& legend() const { return legend_; }
  // Names of the bodies that lack the field.
  const std::vector<std::string>& plain_bodies() const { return plain_bodies_; }

 private:
  std::vector<double> values(int body, int frame) const;
  void find_extremes(const std::vector<int>& frames);

  const TrajectoryReader& reader_;
  std::vector<std::optional<TrajectoryField>> fields_;  // by body
  std::vector<std::string> plain_bodies_;
  Legend legend_;
};

}  // namespace weft::sim
