// The colours of a field: the scale that gives a number its colour, and the legend that explains
// the scale.
#pragma once

#include <string>
#include <vector>

#include "gpu/colour_map.h"

namespace weft::sim {

// A scale from numbers to colours. A diverging scale serves numbers of both signs: zero has the
// middle of the colour map, and equal magnitudes have equally strong colours.
struct ColourScale {
  double low = 0, high = 1;  // ends of the scale; low < high
  bool diverging = false;    // if true, low < 0 < high

  const gpu::ColourMap& map() const;
  // Returns the place of a number in the colour map, 0 .. 1. Numbers beyond an end get the place of
  // that end. NaN stays NaN.
  float place_of(double value) const;
};

// Returns a scale from `low` to `high`. Both must be finite, and low <= high. The scale is
// diverging if low < 0 < high and the smaller magnitude is at least a hundredth of the larger one.
// If low = high, it runs between zero and that number, or from 0 to 1 if both are zero.
ColourScale scale_between(double low, double high);

// Returns about `count` round numbers within the scale, in increasing order, for the marks of a
// legend.
std::vector<double> round_marks(const ColourScale& scale, int count);

struct Legend {
  std::string name;   // of the field
  std::string units;  // may be empty
  bool magnitude = false;
  ColourScale scale;
  // Extremes of the drawn values. They may lie beyond the ends of the scale.
  double least = 0, most = 0;
};

// Size of the smallest picture with room for a legend (pixels).
inline constexpr int least_legend_width = 240, least_legend_height = 180;

// Returns the width of a legend beside a picture of this height (pixels).
int legend_width(int height);

// Returns the picture with the legend in a strip of width legend_width() at its right.
// Precondition: the picture is at least least_legend_height high.
gpu::Picture with_legend(const gpu::Picture& picture, const Legend& legend);

}  // namespace weft::sim
