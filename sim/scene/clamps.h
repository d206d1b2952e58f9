// Edges at which a clamp holds the tangent plane of a surface.
#pragma once

#include <span>
#include <vector>

#include "sim/scene/motion.h"

namespace weft::sim {

struct PrescribedMotion;
struct Scene;
struct SceneBody;

// An edge of a triangle at the rim of a clamp. The clamp holds both ends of the edge, but not the
// opposite node of the triangle. The edge and a ghost node beyond it span the tangent plane that
// the clamp holds. The ghost follows the motion of the pin.
struct ClampedEdge {
  int triangle = 0;     // index of the triangle in the body's mesh
  int edge = 0;         // index of the opposite node in the triangle
  Vec3 ghost{0, 0, 0};  // m, place at t = 0, which the motion of the pin maps to the present place
};

// Returns the edges at the rim of a clamp, in the order of triangles. `held` has the particles of
// the clamp (global indices, sorted). `position` (m, by particle) and `pose`, the pose of the pin's
// motion, belong to the same time. At that time, the ghost of an edge lies in the plane of the
// edge's triangle. O(triangles log held).
std::vector<ClampedEdge> find_clamped_edges(const SceneBody& body, std::span<const int> held,
                                            std::span<const Vec3> position, const RigidPose& pose);

// A clamped edge with the pin that holds it.
struct ClampedBy {
  const PrescribedMotion* held;
  const ClampedEdge* edge;
};

// Returns the clamped edges of a dynamic body, in the order of triangles. The pointers in the
// result point into the scene.
std::vector<ClampedBy> clamped_edges_of(const Scene& scene, int body);

// Returns a mark for each triangle of a dynamic body: 1 if the triangle has a clamped edge, or if
// one clamp holds all its nodes. The result is empty if the body has no clamped edge.
std::vector<char> triangles_at_clamps(const Scene& scene, int body);
// Marks these and the triangles whose bending seams take over. Empty if there are none.
std::vector<char> triangles_at_edges(const Scene& scene, int body);

// Throws CaseError at the pin if the pin is a clamp without clamped edges. `edges` are its clamped
// edges.
void require_clamped_edges(const PinCase& pin, const std::vector<ClampedEdge>& edges);

}  // namespace weft::sim
