// Springs that tie vertices of a body to another body or to an obstacle.
#pragma once

#include <array>
#include <vector>

#include "sim/base/vectors.h"

namespace weft::sim {

struct Case;
struct Scene;
struct TieCase;

// A spring between a vertex and a point. On a body, the point is the nearest one of its surface at
// t = 0, and the length of the spring without force is the distance then. On an obstacle of the
// case, the point is the vertex's own place at t = 0, which the obstacle carries along: the length
// is zero.
struct TieSpring {
  int vertex = 0;  // particle of the tied body, counted within the body
  // Corners of the other body's triangle, counted within that body. -1: the other end is an
  // obstacle.
  std::array<int, 3> nodes{-1, 0, 0};
  Vec3 weights{0, 0, 0};  // of the nodes in the point
  Vec3 place{0, 0, 0};    // m, of the point at t = 0
  double length = 0;      // m
  double share = 0;       // of the tie's stiffness, by the area around the vertex
};

struct Tie {
  const TieCase* source = nullptr;  // points into Scene::source
  int number = 0;                   // in the order of the case
  int body = 0, to = 0;             // indices into Scene::case_order
  std::vector<TieSpring> springs;
};

// Makes the ties of a scene that is complete otherwise. Throws CaseError at a tie that selects no
// vertex. Cost per tie: O(its vertices * triangles of the other body).
void add_ties(Scene& scene);

// True if a tie of the scene may break.
bool has_breakable_ties(const Scene& scene);

}  // namespace weft::sim
