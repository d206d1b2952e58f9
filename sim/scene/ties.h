// Ties: springs between vertices of a body and points of another body or of an obstacle.
#pragma once

#include <array>
#include <vector>

#include "sim/base/vectors.h"

namespace weft::sim {

struct Case;
struct Scene;
struct TieCase;

// A spring between a vertex of the tied body and a point. If the tie ends on a body, the point is
// the one nearest to the vertex on that body's surface at t = 0, and the rest length is their
// distance at that time. If the tie ends on an obstacle of the case, the point starts at the vertex
// and moves with the obstacle, and the rest length is zero.
struct TieSpring {
  int vertex = 0;  // particle of the tied body, local index
  // Corners of the triangle with the point, local indices of the other body. nodes[0] is -1 if the
  // tie ends on an obstacle.
  std::array<int, 3> nodes{-1, 0, 0};
  Vec3 weights{0, 0, 0};  // weights of `nodes`; the point is the weighted sum of their positions
  Vec3 place{0, 0, 0};    // m, position of the point at t = 0
  double length = 0;      // m, rest length
  double share = 0;  // share of the tie's stiffness, proportional to the area around the vertex
};

struct Tie {
  // Points into the source of the scene that build_scene() returned.
  const TieCase* source = nullptr;
  int number = 0;        // index into Case::tie
  int body = 0, to = 0;  // indices into Scene::case_order
  std::vector<TieSpring> springs;
};

// Adds the ties of the case to a scene. Precondition: the scene has all its bodies and obstacles.
// Throws CaseError as select_vertices() (pins.h). Cost per tie: O(its vertices * triangles of the
// other body).
void add_ties(Scene& scene);

// Returns true if a tie of the scene may break.
bool has_breakable_ties(const Scene& scene);

}  // namespace weft::sim
