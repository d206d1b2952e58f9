// Strain, tension, curvature and moment of a body's surface, by particle. Private to sim/.
//
// Each triangle has one tensor, in its plane. A particle's tensor is the mean over the triangles
// around it, weighted by rest area. Before averaging, each tensor is rotated into the particle's
// tangent plane, about the line where the two planes meet. docs/theory.md, section 13, has the
// equations.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "materials/types.h"
#include "sim/scene/cloth_laws.h"

namespace weft::sim {

// A symmetric tensor in a plane, in two orthonormal axes.
struct PlaneTensor {
  double xx = 0, xy = 0, yy = 0;

  double trace() const { return xx + yy; }
  PlaneTensor& operator+=(const PlaneTensor& other);
  friend PlaneTensor operator*(double factor, const PlaneTensor& tensor) {
    return {factor * tensor.xx, factor * tensor.xy, factor * tensor.yy};
  }
};

// Principal values by particle, major >= minor, and the unit vector of the major one in space
// (three numbers per particle). The sign of a direction has no meaning; its largest component is
// positive.
struct PrincipalValues {
  std::vector<double> major, minor, direction;
};

// Elastic moduli of a plate: E h / (1 - nu^2) (N/m) in its plane, or D (N m) in bending.
struct PlateModuli {
  double stiffness = 0, poisson_ratio = 0;
  // Returns stiffness [(1 - nu) e + nu tr(e) 1].
  PlaneTensor response(const PlaneTensor& strain) const;
};

// Stiffness-proportional damping of a material (s).
struct DampingTimes {
  double membrane = 0, bending = 0;
};

class SurfaceTensors {
 public:
  // The body must have a material and outlive this object. `bends` allows for curvature and moment,
  // which take three times the memory. `clamped` lists the edges that clamps hold. Triangles marked
  // in `held` do not bend; empty: none is marked. O(particles).
  SurfaceTensors(const SceneBody& body, bool bends, int threads,
                 std::span<const ClampedEdge> clamped = {}, std::span<const char> held = {});

  // Computes the deformation from the positions (m) and velocities (m/s) of the body's particles,
  // followed by those of the ghosts of clamped edges. The functions below describe this
  // deformation. Each costs O(particles).
  void place(std::span<const Vec3> position, std::span<const Vec3> velocity,
             const DampingTimes& damping);
  // Computes the Green strain (F^T F - 1) / 2.
  void find_strain(PrincipalValues& values) const;
  // Computes the Cauchy tension (N/m), a force per current length, with damping. Zero for a
  // membrane of springs.
  void find_stress(PrincipalValues& values) const;
  // Computes the change of curvature since rest (1/m). It is positive if the surface has become
  // hollow on the side of its normals. Precondition: `bends`.
  void find_curvature(PrincipalValues& values) const;
  // Computes the bending moment per rest length (N m/m), with damping. It has the sign of the
  // curvature. Precondition: `bends`.
  void find_moment(PrincipalValues& values) const;
  // Returns the elastic energy (J) of the triangles: of a membrane of triangles and of bending.
  double elastic_energy() const;

 private:
  struct Triangle {
    std::array<int, 3> nodes{};
    Eigen::Matrix2d inverse_edges;          // of the rest edges 0->1, 0->2 in the rest plane, 1/m
    double area = 0;                        // at rest, m^2
    double warp_cosine = 1, warp_sine = 0;  // of the angle from the first edge to the warp
  };
  // The edges of a triangle that bend. A border edge has no angle of its own. It takes the angle of
  // least energy, which depends on the other angles. `curvature` of the other edges includes this.
  struct Hinges {
    std::array<int, 3> across{-1, -1, -1};   // node across the edge opposite each node
    std::array<double, 3> rest_angle{};      // rad
    std::array<PlaneTensor, 3> curvature{};  // in the rest plane, 1/m per rad
  };
  struct Placed {
    Vec3 along, across, normal;  // current axes of the triangle's plane
    Eigen::Matrix2d gradient;    // F, from the rest plane to these axes
    Eigen::Matrix2d rate;        // of F, 1/s
  };

  void add_hinges(const bsi::Mesh& mesh, std::span<const ClampedEdge> clamped,
                  std::span<const char> held);
  void clamp(std::span<const ClampedEdge> clamped, int triangle, Hinges& hinges) const;
  materials::Nodes4 hinge_nodes(std::size_t triangle, int i, std::span<const Vec3> x) const;
  void place_triangle(int triangle);
  PlateModuli membrane_moduli() const;
  PlaneTensor strain_of(int triangle, double damping_time) const;
  PlaneTensor curvature_of(int triangle, double damping_time) const;
  // Return the second Piola-Kirchhoff tension and the moment, with damping, and the energies per
  // area, in the rest plane.
  PlaneTensor tension_of(int triangle) const;
  PlaneTensor moment_of(int triangle) const;
  double stretch_energy_of(int triangle) const;
  double bending_energy_of(int triangle) const;
  template <class Law>
  PlaneTensor stress_by(const Law& law, int triangle, const PlaneTensor& strain,
                        const PlaneTensor& moved, double damping_time) const;
  template <class Law>
  double energy_by(const Law& law, int triangle, const PlaneTensor& strain) const;
  PlaneTensor in_space(int triangle, const PlaneTensor& at_rest) const;
  template <class TensorOf>
  void average(const TensorOf& tensor_of, PrincipalValues& values) const;
  Vec3 normal_at(std::span<const int> around) const;
  void average_at(int particle, PrincipalValues& values) const;

  const SceneBody& body_;
  int threads_;
  // The laws of materials that differ by direction; empty for isotropic ones.
  std::optional<StretchLaw> stretch_law_;
  std::optional<BendingLaw> bending_law_;
  std::vector<Triangle> triangles_;
  std::vector<Hinges> hinges_;     // by triangle; empty unless bending
  std::vector<int> first_around_;  // by particle: index of its first triangle in around_
  std::vector<int> around_;        // triangles around each particle
  std::vector<Placed> placed_;     // by triangle
  std::vector<Vec3> position_, velocity_;
  DampingTimes damping_;
  mutable std::vector<PlaneTensor> tensors_;  // by triangle; of the last average()
};

}  // namespace weft::sim
