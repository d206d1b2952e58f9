// The states of bodies of another run, in which the bodies of a case start ([restart]).
#pragma once

#include <string>
#include <vector>

#include "bsi/geometry_image.h"
#include "sim/base/vectors.h"
#include "sim/scene/spline_surface.h"

namespace weft::sim {

// Positions (m) and velocities (m/s) of a body by texel: patch by patch, row by row. The texels of
// a shell are points of its surface.
struct BodyState {
  std::string name;
  bsi::Atlas atlas;
  std::vector<Vec3> position, velocity;
};

struct StartStates {
  std::vector<BodyState> bodies;

  // Returns the state of the body of this name, or null.
  const BodyState* find(const std::string& name) const;
};

// Returns `values`, which belong to the texels of the image `from`, at the particles of the image
// `to`. Values between texels are bilinear in the row and the column, and the borders of the two
// images coincide. Images of equal size keep their bits. Precondition: the images have as many
// patches, closed alike.
std::vector<Vec3> resampled(const std::vector<Vec3>& values, const bsi::Atlas& from,
                            const bsi::Atlas& to);
// Likewise, but with values between texels on the surface of splines of the degree of `surface`
// through those at the texels. `surface` belongs to `to`. A shell that is bent has kinks, and so
// much energy, on a finer image of bilinear values. Images with fewer points than such splines need
// are bilinear.
std::vector<Vec3> resampled(const std::vector<Vec3>& values, const bsi::Atlas& from,
                            const bsi::Atlas& to, const SplineSurface& surface);

}  // namespace weft::sim
