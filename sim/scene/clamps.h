// Edges at which a pin holds the tangent plane of a surface.
#pragma once

#include <span>
#include <vector>

#include "sim/scene/motion.h"

namespace weft::sim {

struct PrescribedMotion;
struct Scene;
struct SceneBody;

// An edge of a triangle. A clamp holds both ends of the edge, but not the triangle's opposite node.
// A ghost node beyond the edge spans the clamp's tangent plane with it and follows the pin's
// motion.
struct ClampedEdge {
  int triangle = 0;     // index into the body's mesh
  int edge = 0;         // opposite node `edge` of the triangle
  Vec3 ghost{0, 0, 0};  // m, place at t = 0 that the pin's motion carries to the ghost's
};

// Returns the edges that a clamp holds, by triangle. `held` are its particles (global indices,
// sorted). Each ghost lies in the plane of its triangle, at `position` (m, by particle) at the time
// of `pose`, the pose of the pin's motion. O(triangles log held).
std::vector<ClampedEdge> find_clamped_edges(const SceneBody& body, std::span<const int> held,
                                            std::span<const Vec3> position, const RigidPose& pose);

// A clamped edge with the pin that holds it.
struct ClampedBy {
  const PrescribedMotion* held;
  const ClampedEdge* edge;
};

// Returns the clamped edges of a dynamic body, by triangle. They point into the scene.
std::vector<ClampedBy> clamped_edges_of(const Scene& scene, int body);

// Marks the triangles of a dynamic body whose bending the clamps take over: those with a clamped
// edge, and those that a clamp holds as a whole. Empty if the body has no clamped edge.
std::vector<char> triangles_at_clamps(const Scene& scene, int body);
// Marks these and the triangles whose bending seams take over. Empty if there are none.
std::vector<char> triangles_at_edges(const Scene& scene, int body);

// Throws CaseError at the pin if it is a clamp and holds no edge.
void require_clamped_edges(const PinCase& pin, const std::vector<ClampedEdge>& edges);

}  // namespace weft::sim
