// Spheres of single blocks straight from the image, without the levels below.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "bsi/geometry_image.h"
#include "bsi/sphere.h"
#include "bsi/sphere_build.h"

namespace weft::bsi {

// The spheres of one level of a patch, row by row, as a rebuild of a Pyramid makes them; the level
// after the last of quads is that of triangles. For `exact` and `tight` they are the same to the
// last bit. For `fast` the centres are, and the radii those of `exact`, since radii that are
// carried up need the levels below. Returns the first texel of the patch whose position is not
// finite or reaches Pyramid::coordinate_limit; `spheres` is then empty. On the threads of OpenMP.
// O(quads), for `tight` a dozen times that.
[[nodiscard]] std::optional<TexelAddress> build_level(const Atlas& atlas,
                                                      std::span<const Vec3> positions, int patch,
                                                      int level, RadiusPolicy policy,
                                                      std::vector<Sphere>& spheres);

// Replaces exact spheres of a whole tree by smaller ones, for RadiusPolicy::tight. On so many
// threads. O(quads) a level.
void tighten(const SphereTree& tree, std::span<const std::span<const Vec3>> ends, int threads);

}  // namespace weft::bsi
