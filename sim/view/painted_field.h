// A recorded field shown by the colours of bodies in pictures. For render_trajectory.cpp.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "sim/trajectory/trajectory.h"
#include "sim/view/colour_scale.h"
#include "sim/view/rendered_body.h"

namespace weft::sim {

// The field of one name, on all bodies that have it. Vectors count by their magnitude.
class PaintedField {
 public:
  // Reads the field in all `frames` to find its extremes. `range` gives the ends of the colours;
  // without it they are the extremes. Throws RenderUsageError if no body has a field of this name.
  // Throws std::runtime_error if no value in these frames is finite. O(values in these frames).
  PaintedField(const TrajectoryReader& reader, const std::string& name,
               const std::vector<int>& frames, std::optional<std::array<double, 2>> range);

  // Sets the body's places in the colour map for a frame. A body without the field gets none.
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
