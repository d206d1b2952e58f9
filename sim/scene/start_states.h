// The states of bodies of another run, in which the bodies of a case start ([restart]).
#pragma once

#include <string>
#include <vector>

#include "bsi/geometry_image.h"
#include "sim/base/vectors.h"

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

}  // namespace weft::sim
