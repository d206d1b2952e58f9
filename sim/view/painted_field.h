// A recorded field that the colours of bodies show in pictures.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "sim/trajectory/trajectory.h"
#include "sim/view/colour_scale.h"
#include "sim/view/rendered_body.h"

namespace weft::sim {

// A recorded field on all bodies that have it. Vectors count by their magnitude.
class PaintedField {
 public:
  // Reads the field `name` in all `frames` to find its extremes. The colour scale is
  // scale_between() the two numbers of `range` or, if that is empty, the extremes. Throws
  // RenderUsageError if no body has the field, and std::runtime_error if no value in these frames
  // is finite. O(values in these frames).
  PaintedField(const TrajectoryReader& reader, const std::string& name,
               const std::vector<int>& frames, std::optional<std::array<double, 2>> range);

  // Sets the positions of the body's values in the colour map for a frame (RenderedBody::places). A
  // body without the field gets no positions.
  void paint(int frame, RenderedBody& body) const;
  const Legend& legend() const { return legend_; }
  // Returns the names of the bodies that lack the field.
  const std::vector<std::string>& plain_bodies() const { return plain_bodies_; }

 private:
  std::vector<double> values(int body, int frame) const;
  void find_extremes(const std::vector<int>& frames);

  const TrajectoryReader& reader_;
  std::vector<std::optional<TrajectoryField>> fields_;  // by body; empty if it lacks the field
  std::vector<std::string> plain_bodies_;
  Legend legend_;
};

}  // namespace weft::sim
