// Seams, which sew a border of a body to a border of another body, or of the same one.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "sim/base/vectors.h"

namespace weft::sim {

struct SeamCase;
struct Scene;

// A vertex of one border that is sewn to a point of the other one, between two neighbouring
// vertices of it.
struct Stitch {
  int vertex = 0;              // particle, counted within its body
  std::array<int, 2> nodes{};  // of the other border, counted within that body; equal: a vertex
  double weight = 1;           // of the first node in the point
  double length = 0;           // m, of the border that the stitch holds: half of either side
  double gap = 0;              // m, between vertex and point at t = 0
};

// A triangle at a seam whose surface goes on across one of its edges. Its angle there is `share`
// times the fold between it and the triangle on the other side.
struct SeamFold {
  int body = 0, other = 0;  // in the order of the case
  int triangle = 0;         // of the body's mesh
  int edge = 0;             // opposite node `edge` of the triangle
  int across = 0;           // the node beyond the edge, counted within the other body
  double share = 1;
  double angle = 0;  // rad, fold without moment, positive on the side of the triangle's normal
};

struct Seam {
  const SeamCase* source = nullptr;  // points into Scene::source
  int number = 0;                    // in the order of the case
  int body = 0, to = 0;              // of the stitched vertices, and of their points; in that order
  double stiffness = 0;              // N/m^2
  double largest_gap = 0;            // m, at t = 0
  std::vector<Stitch> stitches;
  std::vector<SeamFold> folds;
};

// Makes the seams of a scene that is complete otherwise, with its bodies where they start. Throws
// CaseError at a seam whose edge is closed or inside the surface, or whose sides do not meet at the
// start and have no closing_time. Cost per seam: O(mesh), and O(vertices^2) for closed edges.
void add_seams(Scene& scene);

// Returns the folds of the triangles of a dynamic body, by triangle. They point into the scene.
std::vector<const SeamFold*> seam_folds_of(const Scene& scene, int body);

// True if a seam of the body draws its edges together after `time` (s).
bool closes_after(const Scene& scene, int body, double time);

}  // namespace weft::sim
