// Edges at which a pin holds the tangent plane of a surface.
#pragma once

#include <span>
#include <vector>

#include "sim/scene/motion.h"

namespace weft::sim {

struct PrescribedMotion;
struct Scene;
struct SceneBody;

// A triangle's edge at the rim of a clamp. The clamp holds both ends of the edge, but not the
// triangle's opposite node. The edge and a ghost node beyond it span the tangent plane that the
// clamp holds. The ghost follows the pin's motion.
struct ClampedEdge {
  int triangle = 0;     // index into the body's mesh
  int edge = 0;         // opposite node `edge` of the triangle
  Vec3 ghost{0, 0, 0};  // m, place at t = 0; the pin's motion carries it to the ghost's place
};

// Returns the edges at the rim of a clamp, in the order of triangles. `held` are the particles of
// the clamp (global indices, sorted). `position` (m, by particle) and `pose`, the pose of the pin's
// motion, belong to the same time. At that time each ghost lies in the plane of its triangle.
// O(triangles log held).
std::vector<ClampedEdge> find_clamped_edges(const SceneBody& body, std::span<const int> held,
                                            std::span<const Vec3> position, const RigidPose& pose);

// A clamped edge with the pin that holds it.
struct ClampedBy {
  const PrescribedMotion* held;
  const ClampedEdge* edge;
};

// Returns the clamped edges of a dynamic body, in the order of triangles. The pointers point into
// the scene.
std::vector<ClampedBy> clamped_edges_of(const Scene& scene, int body);

// Returns a mark for each triangle of a dynamic body: 1 if clamps take over its bending. These
// triangles have a clamped edge, or one clamp holds all their nodes. Empty if the body has no
// clamped edge.
std::vector<char> triangles_at_clamps(const Scene& scene, int body);
// Marks these and the triangles whose bending seams take over. Empty if there are none.
std::vector<char> triangles_at_edges(const Scene& scene, int body);

// Throws CaseError at the pin if the pin is a clamp and `edges`, its clamped edges, is empty.
void require_clamped_edges(const PinCase& pin, const std::vector<ClampedEdge>& edges);

}  // namespace weft::sim
