// Strain, tension, curvature and moment of a body's surface, by particle. Private to sim/.
//
// Each of these tensors is constant on a triangle and lies in its plane. A particle has the mean
// over the triangles around it, weighted by rest area. Before averaging, a triangle's tensor is
// rotated into the particle's tangent plane, about the line where the two planes meet. The
// equations are in section 13 of docs/theory.md.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "materials/crease.h"
#include "materials/strain_limit.h"
#include "materials/types.h"
#include "sim/scene/cloth_laws.h"

namespace weft::sim {

// A symmetric tensor in a plane: its components along two orthonormal axes.
struct PlaneTensor {
  double xx = 0, xy = 0, yy = 0;

  double trace() const { return xx + yy; }
  PlaneTensor& operator+=(const PlaneTensor& other);
  friend PlaneTensor operator*(double factor, const PlaneTensor& tensor) {
    return {factor * tensor.xx, factor * tensor.xy, factor * tensor.yy};
  }
};

// The principal values of a tensor by particle, with major >= minor. `direction` is the unit vector
// of the major principal axis, three numbers per particle. Its sign has no meaning and is chosen to
// make the component of largest magnitude positive.
struct PrincipalValues {
  std::vector<double> major, minor, direction;
};

// Elastic moduli of a plate. `stiffness` is the bending stiffness (N m) or, for strain in the plane
// of the plate, the membrane stiffness divided by 1 - nu^2 (N/m), where nu is the Poisson ratio.
struct PlateModuli {
  double stiffness = 0, poisson_ratio = 0;
  // Returns stiffness [(1 - nu) e + nu tr(e) 1], where e is the strain.
  PlaneTensor response(const PlaneTensor& strain) const;
};

// Damping of a material, as times (s) by which rates of strain and curvature are multiplied.
struct DampingTimes {
  double membrane = 0, bending = 0;
};

class SurfaceTensors {
 public:
  // The body must have a material and outlive this object. Curvature, moment and bending energy
  // need `bends`, which takes more memory. `clamped` lists the edges that clamps hold. `held` marks
  // triangles that do not bend; if it is empty, all triangles bend. O(particles).
  SurfaceTensors(const SceneBody& body, bool bends, int threads,
                 std::span<const ClampedEdge> clamped = {}, std::span<const char> held = {});

  // Sets the deformation that all other functions evaluate. `position` (m) and `velocity` (m/s)
  // have one entry per particle of the body, followed by one per ghost of a clamped edge. `creases`
  // has one entry per triangle, or none at all. O(particles).
  void place(std::span<const Vec3> position, std::span<const Vec3> velocity,
             const DampingTimes& damping, std::vector<materials::Crease> creases = {});
  // Computes the Green strain (F^T F - 1) / 2. O(particles).
  void find_strain(PrincipalValues& values) const;
  // Computes the Cauchy tension (N/m), which is a force per current length, with damping and the
  // strain limit. It is that of the limit alone for a membrane of springs. O(particles).
  void find_stress(PrincipalValues& values) const;
  // Computes the change of curvature since rest (1/m). It is positive if the surface has become
  // hollow on the side of its normals. Precondition: the object was made with `bends`.
  // O(particles).
  void find_curvature(PrincipalValues& values) const;
  // Computes the plastic part of this curvature, which creases keep. Precondition: the object was
  // made with `bends`. O(particles).
  void find_crease(PrincipalValues& values) const;
  // Computes the bending moment per rest length (N m/m), with damping. Its sign convention is that
  // of the elastic curvature. Precondition: the object was made with `bends`. O(particles).
  void find_moment(PrincipalValues& values) const;
  // Returns the elastic energy (J) of bending and of a membrane of triangles. It leaves out
  // springs. Precondition: the material does not resist bending, or the object was made with
  // `bends`. O(particles).
  double elastic_energy() const;

 private:
  struct Triangle {
    std::array<int, 3> nodes{};
    // Inverse of the matrix whose columns are the rest edges 0->1 and 0->2, in the rest plane
    // (1/m).
    Eigen::Matrix2d inverse_edges;
    double area = 0;  // area at rest (m^2)
    // Cosine and sine of the angle from the edge 0->1 to the warp.
    double warp_cosine = 1, warp_sine = 0;
  };
  // The bending of a triangle at its three edges. A border edge that is not clamped has no angle of
  // its own: it takes the angle of least energy, which is linear in the other angles. The entries
  // of `curvature` for the other edges include the contribution of that border edge.
  struct Hinges {
    std::array<int, 3> across{-1, -1, -1};   // node beyond the edge; -1 at a free border edge
    std::array<double, 3> rest_angle{};      // angle at rest (rad)
    std::array<PlaneTensor, 3> curvature{};  // curvature per angle, in the rest plane (1/m per rad)
  };
  struct Placed {
    Vec3 along, across, normal;  // present axes: two in the triangle's plane, and its normal
    Eigen::Matrix2d gradient;    // deformation gradient F, from the rest plane to these axes
    Eigen::Matrix2d rate;        // rate of F (1/s)
  };

  void add_hinges(const bsi::Mesh& mesh, std::span<const ClampedEdge> clamped,
                  std::span<const char> held);
  void clamp(std::span<const ClampedEdge> clamped, int triangle, Hinges& hinges) const;
  materials::Nodes4 hinge_nodes(std::size_t triangle, int i, std::span<const Vec3> x) const;
  void place_triangle(int triangle);
  PlateModuli membrane_moduli() const;
  PlaneTensor strain_of(int triangle, double damping_time) const;
  PlaneTensor curvature_of(int triangle, double damping_time) const;
  PlaneTensor crease_of(int triangle) const;
  PlaneTensor elastic_curvature_of(int triangle, double damping_time) const;
  // Return the second Piola-Kirchhoff tension (N/m) in the rest plane: that of the membrane with
  // damping, that of the strain limit, and their sum.
  PlaneTensor membrane_tension_of(int triangle) const;
  PlaneTensor limit_tension_of(int triangle) const;
  PlaneTensor tension_of(int triangle) const;
  // Returns the bending moment per rest length (N m/m), with damping, in the rest plane.
  PlaneTensor moment_of(int triangle) const;
  // Return the elastic energies per rest area (J/m^2).
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
  // Material laws whose stiffness depends on the direction; empty for isotropic materials.
  std::optional<StretchLaw> stretch_law_;
  std::optional<BendingLaw> bending_law_;
  std::optional<materials::StrainLimit> unit_limit_;  // of a triangle with legs of 1 m
  std::vector<Triangle> triangles_;
  std::vector<Hinges> hinges_;     // by triangle; empty unless made with `bends`
  std::vector<int> first_around_;  // by particle: index of its first triangle in around_
  std::vector<int> around_;        // triangles around each particle, particle by particle
  std::vector<Placed> placed_;     // by triangle
  std::vector<Vec3> position_, velocity_;
  std::vector<materials::Crease> creases_;  // by triangle; empty: none
  DampingTimes damping_;
  mutable std::vector<PlaneTensor> tensors_;  // by triangle; work array of average()
};

}  // namespace weft::sim
