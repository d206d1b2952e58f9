// The colour scale of a field, and the legend that explains it.
#pragma once

#include <string>
#include <vector>

#include "gpu/colour_map.h"

namespace weft::sim {

// A scale from numbers to colours. A diverging scale is for numbers of both signs: zero has the
// middle colour of the colour map, and equal magnitudes have equally strong colours.
struct ColourScale {
  double low = 0, high = 1;  // numbers at the ends of the scale; low < high
  bool diverging = false;    // if true, low < 0 < high must hold

  const gpu::ColourMap& map() const;
  // Returns the position of a number between the ends: 0 at `low`, 1 at `high`. It is finite for
  // all numbers within the scale, even if the difference of the ends is not.
  double share_of(double value) const;
  // Returns the position of a number in the colour map, from 0 to 1. A number beyond an end of the
  // scale has the position of that end. The position of NaN is NaN.
  float place_of(double value) const;
};

// Returns a scale from `low` to `high`, which must be finite, with low <= high. The scale is
// diverging if low < 0 < high and the smaller magnitude is at least a hundredth of the larger one.
// If low = high, the scale lies between zero and this number, or from 0 to 1 if both are zero.
ColourScale scale_between(double low, double high);

// Returns round numbers within the scale for the marks of a legend, in increasing order: at most
// max(count, 1) + 1 numbers. Returns none if the ends of the scale agree in about fifteen digits,
// or if its round numbers are too small for doubles.
std::vector<double> round_marks(const ColourScale& scale, int count);

struct Legend {
  std::string name;        // name of the field
  std::string units;       // may be empty
  bool magnitude = false;  // true if the values are magnitudes of vectors
  ColourScale scale;
  // Extremes of the drawn values. They may lie beyond the ends of the scale.
  double least = 0, most = 0;
};

// Size of the smallest picture with room for a legend (pixels).
inline constexpr int least_legend_width = 240, least_legend_height = 180;

// Returns the width (pixels) of the legend beside a picture of `height` pixels.
int legend_width(int height);

// Returns the picture widened by a strip with the legend at its right. The strip has the width
// legend_width(). A name or units that are too long for the strip are cut, and end in dots.
// Precondition: the picture is at least least_legend_height high.
gpu::Picture with_legend(const gpu::Picture& picture, const Legend& legend);

}  // namespace weft::sim
