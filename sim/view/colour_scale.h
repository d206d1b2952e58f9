// The colours of a field: which number has which colour, and the legend that says so.
#pragma once

#include <string>
#include <vector>

#include "gpu/colour_map.h"

namespace weft::sim {

// Numbers and their colours. Where numbers of both signs count, zero has the middle of the
// diverging map, and equal magnitudes have equally strong colours.
struct ColourScale {
  double low = 0, high = 1;  // at the ends of the legend; low < high
  bool diverging = false;    // then low < 0 < high

  const gpu::ColourMap& map() const;
  // Returns the place in the map, 0..1; numbers beyond the ends have the places of the ends, NaN
  // stays NaN.
  float place_of(double value) const;
};

// The scale of numbers from `low` to `high`, low <= high, both finite. It diverges if both signs
// reach a hundredth of the largest magnitude. Equal numbers get a scale from zero to their value,
// or, of zeros, from 0 to 1.
ColourScale scale_between(double low, double high);

// Round numbers within the scale for the marks of a legend, in increasing order, about `count`.
std::vector<double> round_marks(const ColourScale& scale, int count);

struct Legend {
  std::string name;   // of the field
  std::string units;  // may be empty
  bool magnitude = false;
  ColourScale scale;
  // Extremes of the values drawn, which may lie beyond the ends of the scale.
  double least = 0, most = 0;
};

// The smallest picture that a legend fits in, pixels.
inline constexpr int least_legend_width = 240, least_legend_height = 180;

// Pixels that a legend takes at the right of a picture of this height.
int legend_width(int height);

// Returns the picture with the legend in a strip of legend_width() at its right.
gpu::Picture with_legend(const gpu::Picture& picture, const Legend& legend);

}  // namespace weft::sim
