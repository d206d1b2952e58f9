// Bending of single triangles that have an edge at which something beyond their image decides the
// angle: a clamp, or a surface sewn to it.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "materials/crease.h"
#include "sim/forces/force.h"
#include "sim/forces/moving_points.h"
#include "sim/forces/varying_numbers.h"
#include "sim/scene/cloth_laws.h"

namespace weft::sim {

inline constexpr int no_particle = -1;

// A triangle with at least one edge at a clamp or a seam. Edge i is opposite node i, and node i + 3
// lies across edge i. Beyond a clamped edge, the surface is the mirror image of the triangle in the
// clamp's tangent plane. The angle at the edge is therefore twice the angle to that plane. Beyond a
// sewn edge, the surface is the triangle of the other border. While a seam is open, nothing joins
// the two triangles: their angle counts by the part to which the seam is closed.
struct BorderTriangle {
  std::array<int, 6> particles;  // global indices; no_particle: ghost or border
  // Indices of the ghosts in MovingPoints, by edge; no_particle for edges without a ghost.
  std::array<int, 3> ghosts{no_particle, no_particle, no_particle};
  std::array<int, 3> pins{-1, -1, -1};    // by edge: index of the clamp in the body's list of pins
  std::array<int, 3> bodies{-1, -1, -1};  // by sewn edge with a ghost: index into Scene::bodies
  std::array<bool, 3> is_sewn{};          // by edge
  int body = 0;                           // index into Scene::bodies
  int case_body = 0;                      // index into Case::body
  int triangle = 0;                       // index into the body's mesh
  Vec3 factors{1, 1, 1};                  // by edge: 2 if clamped, SeamFold::share if sewn, else 1
  Vec3 rest_angles{0, 0, 0};              // rad, by edge
  Vec3 closing_times{0, 0, 0};            // s, by edge: of its seam; 0: closed from the start
  // By edge, at the time of set_time(): the part of its angle that counts, which grows from 0 to 1
  // while its seam closes, and the rate of growth over this part (1/s).
  Vec3 closed_parts{1, 1, 1}, closing_rates{0, 0, 0};
  Eigen::Matrix3d modulus = Eigen::Matrix3d::Zero();  // N m, over the three angles
  // Law with a stiffness that depends on the curvature. Null if the law is linear.
  std::shared_ptr<const materials::CurvedBending> curved;
  materials::StrainMapOf<double> map;  // from the angles to the curvature, for `curved`
  double damping_time = 0;             // s, at the time of set_time()
  materials::YieldLaw yielding;
};

// A list of such triangles, with their damping and ghosts. A ghost is a node across an edge that is
// no particle.
struct BorderTriangles {
  std::vector<BorderTriangle> triangles;
  VaryingNumbers damping_times;  // s
  bool is_damped = false;        // at any time
  MovingPoints ghosts;
};

// Makes a triangle with the nodes across its edges that its own body has.
BorderTriangle border_triangle(const Scene& scene, int body, const bsi::Mesh& mesh, int index);
// Lets the triangle bend against the other side of its seams.
void join_folds(const Scene& scene, BorderTriangle& triangle, MovingPoints& ghosts);
// Sets the laws of bending and of yielding. Must be called once all nodes across edges are known.
void find_laws(const Scene& scene, const bsi::Mesh& mesh, BorderTriangle& triangle);

// Returns the bending force of these triangles. Its energy is recorded under `name`.
std::unique_ptr<Force> make_border_bending(std::string_view name, BorderTriangles triangles,
                                           const Scene& scene);

}  // namespace weft::sim
