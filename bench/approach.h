// Two tori that approach each other along a straight line, and where they first touch.
#pragma once

#include <vector>

#include "bench/scenes.h"

namespace weft::bench {

struct Approach {
  bsi::Vec3 direction;   // from the resting torus to the moving one, a unit vector
  bool touched = false;  // `found` is set
  // Distances of the centres at the first contact, m: `found` for the meshes, by the traversal of
  // pyramids rebuilt at every step; `expected` for the smooth tori.
  double found = 0, expected = 0;
  double leaf = 0;  // the longest edge of the mesh, m
  int steps = 0;    // rebuilds and traversals
  long hits = 0;    // pairs of triangles that meet there
};

// Moves one torus towards the other from `directions` directions spread evenly over the sphere,
// rotated differently in each. It advances by a quarter of a leaf. The first step at which
// triangles meet is then bisected to a micrometre.
std::vector<Approach> approach_from_all_sides(const Body& torus, int directions);

// Returns the distance of two solid tori (with the radii of make_paper_torus), the second rotated
// by `turn` and moved by `shift`. It is negative if they overlap by less than two minor radii. It
// is the distance of their core circles minus two minor radii. The distance of a point from the
// first circle is a closed form, which is minimised along the second. Accurate to 1e-12 m.
double torus_distance(const Eigen::Matrix3d& turn, const bsi::Vec3& shift);

}  // namespace weft::bench
