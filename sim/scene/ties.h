// Springs that tie vertices of a body to another body or to an obstacle.
#pragma once

#include <array>
#include <vector>

#include "sim/base/vectors.h"

namespace weft::sim {

struct Case;
struct Scene;
struct TieCase;

// A spring between a vertex of the tied body and a point. If the tie ends on a body, the point is
// the one of its surface nearest to the vertex at t = 0. The rest length is their distance then. If
// the tie ends on an obstacle of the case, the point starts at the vertex and moves with the
// obstacle; the rest length is zero.
struct TieSpring {
  int vertex = 0;  // particle of the tied body, local index
  // Corners of the other body's triangle, local indices. -1: the other end is an obstacle.
  std::array<int, 3> nodes{-1, 0, 0};
  Vec3 weights{0, 0, 0};  // weights of the nodes in the point
  Vec3 place{0, 0, 0};    // m, of the point at t = 0
  double length = 0;      // m, at rest
  double share = 0;       // of the tie's stiffness, proportional to the area around the vertex
};

struct Tie {
  const TieCase* source = nullptr;  // points into Scene::source
  int number = 0;                   // in the order of the case
  int body = 0, to = 0;             // indices into Scene::case_order
  std::vector<TieSpring> springs;
};

// Adds the ties of the case to a scene that is complete otherwise. Throws CaseError at a tie that
// selects no vertex. Cost per tie: O(its vertices * triangles of the other body).
void add_ties(Scene& scene);

// Returns true if a tie of the scene may break.
bool has_breakable_ties(const Scene& scene);

}  // namespace weft::sim
