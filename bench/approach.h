// Two tori that come near each other along a straight line: where they touch first.
#pragma once

#include <vector>

#include "bench/scenes.h"

namespace weft::bench {

struct Approach {
  bsi::Vec3 direction;   // from the resting torus to the moving one, a unit vector
  bool touched = false;  // else `found` means nothing
  // Distances of the centres at the first contact, m: of the meshes, by the traversal of pyramids
  // rebuilt at every step, and of the smooth tori.
  double found = 0, expected = 0;
  double leaf = 0;  // the longest edge of the mesh, m
  int steps = 0;    // rebuilds and traversals it took
  long hits = 0;    // pairs of triangles that meet there
};

// Moves one torus towards the other from `directions` directions spread evenly over the sphere,
// turned differently in each. It advances by a quarter of a leaf. The first step that finds
// triangles that meet is then halved down to a micrometre.
std::vector<Approach> approach_from_all_sides(const Body& torus, int directions);

// Returns the distance of two solid tori (of the radii of make_paper_torus), the second turned by
// `turn` and moved by `shift`. It is negative where they overlap by less than two minor radii. It
// is the distance of their core circles less two minor radii, minimised along the second circle:
// the distance of its points from the first is a closed form. Accurate to 1e-12 m.
double torus_distance(const Eigen::Matrix3d& turn, const bsi::Vec3& shift);

}  // namespace weft::bench
