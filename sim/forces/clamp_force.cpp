// Bending of triangles at clamped edges (sim/scene/clamps.h).
#include <algorithm>

#include "materials/bending.h"
#include "materials/hinge.h"
#include "sim/forces/force_arrays.h"
#include "sim/forces/moving_points.h"
#include "sim/forces/varying_numbers.h"
#include "sim/scene/cloth_laws.h"

namespace weft::sim {

namespace {

using materials::Mat3;
using materials::Nodes3;
using materials::Nodes4;

constexpr int no_particle = -1;
constexpr int most_nodes = 6;  // three nodes of the triangle and three across its edges

// A triangle with at least one clamped edge. Edge i is opposite node i, and node i + 3 lies across
// edge i. Beyond a clamped edge, the surface is the mirror image of the triangle in the clamp's
// tangent plane. The angle at the edge is therefore twice the angle to that plane.
struct ClampedTriangle {
  std::array<int, most_nodes> particles;  // global indices; no_particle: ghost or border
  // Indices of the ghosts in MovingPoints, by edge; no_particle for edges that are not clamped.
  std::array<int, 3> ghosts{no_particle, no_particle, no_particle};
  std::array<int, 3> pins{};    // by clamped edge: index of the clamp in the body's list of pins
  int body = 0;                 // index into Scene::bodies
  Vec3 factors{1, 1, 1};        // by edge: 2 if clamped, else 1
  Vec3 rest_angles{0, 0, 0};    // rad, by edge
  Mat3 modulus = Mat3::Zero();  // N m, over the three angles
  // Law with a stiffness that depends on the curvature. Null if the law is linear.
  std::shared_ptr<const materials::CurvedBending> law;
  materials::StrainMapOf<double> map;  // from the angles to the curvature, for `law`
  double damping_time = 0;             // s, at the time of set_time()
};

// The hinges of a triangle at given positions: `strains` are the changes of their angles times
// ClampedTriangle::factors (rad), `slopes` the derivatives of the strains by the node positions
// (1/m), and `hinges` the node positions of each hinge (m).
struct Angles {
  Vec3 strains{0, 0, 0};
  Eigen::Matrix<double, 3, 3 * most_nodes> slopes =
      Eigen::Matrix<double, 3, 3 * most_nodes>::Zero();
  std::array<Nodes4, 3> hinges;
};

class ClampForce final : public Force {
 public:
  ClampForce(std::vector<ClampedTriangle> triangles, VaryingNumbers damping_times, bool is_damped,
             MovingPoints ghosts, const std::vector<Vec3>& rest)
      : triangles_(std::move(triangles)),
        damping_times_(std::move(damping_times)),
        is_damped_(is_damped),
        ghosts_(std::move(ghosts)) {
    for (ClampedTriangle& triangle : triangles_) {
      const Vec3 rest_angles = find_angles(triangle, rest).strains;
      for (int i = 0; i < 3; ++i) {
        if (triangle.ghosts[i] == no_particle) triangle.rest_angles[i] = rest_angles[i];
      }
    }
  }

  std::string_view name() const override { return "clamp"; }
  bool has_damping() const override { return is_damped_; }
  bool varies() const override { return ghosts_.move() || damping_times_.varies(); }
  bool has_moving_points() const override { return ghosts_.move(); }
  void set_time(const Instant& now) override {
    ghosts_.set_time(now);
    damping_times_.visit_changed(now, [&](int first, int last, double time) {
      for (int t = first; t < last; ++t) triangles_[t].damping_time = time;
    });
  }
  double evaluation_work() const override { return 1.2; }

  double energy(const Kinematics& state, int /*threads*/) override {
    double sum = 0;
    for (const ClampedTriangle& triangle : triangles_) {
      const Vec3 strains = find_angles(triangle, state.position).strains;
      sum += triangle.law ? materials::law_energy(triangle.map, *triangle.law, strains)
                          : 0.5 * strains.dot(triangle.modulus * strains);
    }
    return sum;
  }

  double power_of_moving_points(const Kinematics& state) override {
    double power = 0;
    for (const ClampedTriangle& triangle : triangles_) {
      const Angles angles = find_angles(triangle, state.position);
      const Vec3 moments = moments_of(triangle, angles, state);
      for (int i = 0; i < 3; ++i) {
        if (triangle.ghosts[i] == no_particle) continue;
        power += (angles.slopes.middleCols<3>(3 * (i + 3)).transpose() * moments)
                     .dot(ghosts_.velocity(triangle.ghosts[i]));
      }
    }
    return power;
  }

  void list_outer_forces(const Kinematics& state, std::vector<OuterForce>& all) override {
    for (const ClampedTriangle& triangle : triangles_) {
      const Angles angles = find_angles(triangle, state.position);
      const Vec3 moments = moments_of(triangle, angles, state);
      for (int i = 0; i < 3; ++i) {
        if (triangle.ghosts[i] == no_particle) continue;
        OuterForce& outer = all.emplace_back();
        outer.body = triangle.body;
        outer.pin = triangle.pins[i];
        outer.place = ghosts_.position(triangle.ghosts[i]);
        outer.force = angles.slopes.middleCols<3>(3 * (i + 3)).transpose() * moments;
      }
    }
  }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int /*threads*/) override {
    for (const ClampedTriangle& triangle : triangles_) {
      const Angles angles = find_angles(triangle, state.position);
      add_pull(triangle, angles, -moments_of(triangle, angles, state), force);
    }
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    for (const ClampedTriangle& triangle : triangles_) {
      for (const int a : triangle.particles) {
        for (const int b : triangle.particles) {
          if (a != no_particle && b != no_particle) neighbours[a].push_back(b);
        }
      }
    }
  }
  void attach(const BlockPattern& /*pattern*/) override {}

  // Adds K = B^T C B + sum_i moment_i d^2 theta_i / dx dx and D = beta B^T V B, with the strains
  // theta and B = d theta / dx. The semi-definite form of K leaves out the sum and uses the
  // viscosity V in place of the tangent modulus C.
  void add_derivatives(const Kinematics& state, const Derivatives& into, Definiteness definiteness,
                       int /*threads*/) override {
    for (const ClampedTriangle& triangle : triangles_) {
      const Angles angles = find_angles(triangle, state.position);
      const Mat3 viscosity = viscosity_of(triangle, angles.strains);
      const Eigen::Matrix<double, 3, 3 * most_nodes> moduli = viscosity * angles.slopes;
      Block elastic = angles.slopes.transpose() * moduli;
      if (triangle.damping_time > 0 && !into.is_joined())
        add_blocks(triangle, triangle.damping_time * elastic, *into.damping);
      if (triangle.damping_time > 0 && into.is_joined()) {
        const Vec3 rates = angles.slopes * gathered(triangle, into.along);
        add_pull(triangle, angles, triangle.damping_time * viscosity * rates, into.product);
        elastic *= 1 + into.inverse_gamma * triangle.damping_time;
      }
      if (triangle.law && definiteness == Definiteness::exact)
        elastic += angles.slopes.transpose() * (tangent_of(triangle, angles.strains) - viscosity) *
                   angles.slopes;
      if (definiteness == Definiteness::exact)
        add_stress(triangle, angles, moments_of(triangle, angles, state), elastic);
      add_blocks(triangle, elastic, into.stiffness);
    }
  }

 private:
  using Block = Eigen::Matrix<double, 3 * most_nodes, 3 * most_nodes>;
  using Values = Eigen::Matrix<double, 3 * most_nodes, 1>;

  Angles find_angles(const ClampedTriangle& triangle, std::span<const Vec3> position) const {
    Angles angles;
    for (int i = 0; i < 3; ++i) {
      const int across = triangle.particles[i + 3], ghost = triangle.ghosts[i];
      if (across == no_particle && ghost == no_particle) continue;
      const std::array<int, 4> places = {(i + 1) % 3, (i + 2) % 3, i, i + 3};
      Nodes4& x = angles.hinges[i];
      for (int k = 0; k < 3; ++k) x.col(k) = position[triangle.particles[places[k]]];
      x.col(3) = ghost != no_particle ? ghosts_.position(ghost) : position[across];
      angles.strains[i] =
          triangle.factors[i] * (materials::hinge_angle(x) - triangle.rest_angles[i]);
      const Nodes4 gradient = materials::hinge_gradient(x);
      for (int k = 0; k < 4; ++k)
        angles.slopes.block<1, 3>(i, 3 * places[k]) =
            triangle.factors[i] * gradient.col(k).transpose();
    }
    return angles;
  }

  // Returns the values at the nodes of a triangle, with zero at ghosts and beyond borders.
  static Values gathered(const ClampedTriangle& triangle, std::span<const Vec3> values) {
    Values all = Values::Zero();
    for (int a = 0; a < most_nodes; ++a) {
      if (triangle.particles[a] != no_particle)
        all.segment<3>(3 * a) = values[triangle.particles[a]];
    }
    return all;
  }

  static Mat3 matrix_of(const materials::Symmetric3Of<double>& entries) {
    return Mat3::NullaryExpr([&](Eigen::Index i, Eigen::Index j) {
      return entries(static_cast<int>(i), static_cast<int>(j));
    });
  }
  // viscosity_of() returns the modulus V of damping, tangent_of() the tangent modulus C of a
  // nonlinear law, N m.
  static Mat3 viscosity_of(const ClampedTriangle& triangle, const Vec3& strains) {
    if (!triangle.law) return triangle.modulus;
    return matrix_of(materials::law_viscosity(triangle.map, *triangle.law, strains));
  }
  static Mat3 tangent_of(const ClampedTriangle& triangle, const Vec3& strains) {
    return matrix_of(materials::law_tangent(triangle.map, *triangle.law, strains, false));
  }

  // Returns the moments dW/d theta + beta V d theta/dt of the strains theta, N m.
  Vec3 moments_of(const ClampedTriangle& triangle, const Angles& angles,
                  const Kinematics& state) const {
    Vec3 strains = angles.strains, rates = Vec3::Zero();
    if (triangle.damping_time > 0) {
      Values velocity = gathered(triangle, state.velocity);
      for (int i = 0; i < 3; ++i) {
        if (triangle.ghosts[i] != no_particle)
          velocity.segment<3>(3 * (i + 3)) = ghosts_.velocity(triangle.ghosts[i]);
      }
      if (!triangle.law) strains += triangle.damping_time * (angles.slopes * velocity);
      if (triangle.law) rates = triangle.damping_time * (angles.slopes * velocity);
    }
    if (!triangle.law) return triangle.modulus * strains;
    return materials::law_slope(triangle.map, *triangle.law, strains) +
           viscosity_of(triangle, strains) * rates;
  }

  static void add_pull(const ClampedTriangle& triangle, const Angles& angles, const Vec3& moments,
                       std::span<Vec3> sums) {
    for (int a = 0; a < most_nodes; ++a) {
      if (triangle.particles[a] != no_particle)
        sums[triangle.particles[a]] += angles.slopes.middleCols<3>(3 * a).transpose() * moments;
    }
  }

  // Adds sum_i moment_i d^2 theta_i / dx dx.
  static void add_stress(const ClampedTriangle& triangle, const Angles& angles, const Vec3& moments,
                         Block& sum) {
    for (int i = 0; i < 3; ++i) {
      if (triangle.particles[i + 3] == no_particle && triangle.ghosts[i] == no_particle) continue;
      const Nodes4& x = angles.hinges[i];
      const double moment = triangle.factors[i] * moments[i];
      const int p = (i + 1) % 3, q = (i + 2) % 3;
      Nodes3 own, beyond;
      own << x.col(0), x.col(1), x.col(2);
      beyond << x.col(1), x.col(0), x.col(3);
      add_stress(materials::HingeStress<double>(own, 2, moment), {p, q, i}, sum);
      add_stress(materials::HingeStress<double>(beyond, 2, moment), {q, p, i + 3}, sum);
    }
  }
  static void add_stress(const materials::HingeStress<double>& stress,
                         const std::array<int, 3>& places, Block& sum) {
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b)
        sum.block<3, 3>(3 * places[a], 3 * places[b]) += stress.block(a, b);
    }
  }

  static void add_blocks(const ClampedTriangle& triangle, const Block& blocks,
                         BlockMatrix& matrix) {
    const BlockPattern& pattern = matrix.pattern();
    for (int a = 0; a < most_nodes; ++a) {
      for (int b = 0; b < most_nodes; ++b) {
        const int row = triangle.particles[a], column = triangle.particles[b];
        if (row == no_particle || column == no_particle || row > column) continue;
        matrix.upper_block(pattern.upper(row, pattern.slot(row, column))) +=
            blocks.block<3, 3>(3 * a, 3 * b);
      }
    }
  }

  std::vector<ClampedTriangle> triangles_;
  VaryingNumbers damping_times_;  // s, by triangle
  bool is_damped_;                // true if damped at any time
  MovingPoints ghosts_;
};

ClampedTriangle triangle_of(const SceneBody& body, const bsi::Mesh& mesh, int index) {
  ClampedTriangle triangle;
  for (int i = 0; i < 3; ++i) {
    triangle.particles[i] = body.first_particle + mesh.triangles[index][i];
    const bsi::Edge& edge = mesh.edges[mesh.triangle_edges[index][i]];
    triangle.particles[i + 3] =
        edge.triangle[1] < 0
            ? no_particle
            : body.first_particle + edge.opposite[edge.triangle[0] == index ? 1 : 0];
  }
  triangle.damping_time = body.material->bending_damping.constant_or_zero();
  return triangle;
}

bool has_clamps(const Case& source) {
  return std::ranges::any_of(source.body, [](const BodyCase& body) {
    return std::ranges::any_of(body.pin, &PinCase::clamp);
  });
}

// Sets the bending law of a triangle from its nodes and the ghosts added so far.
void find_modulus(const SceneBody& body, const bsi::Mesh& mesh, int index,
                  ClampedTriangle& triangle) {
  Nodes3 rest;
  std::array<bool, 3> has_angle{};
  for (int i = 0; i < 3; ++i) {
    rest.col(i) = body.rest[mesh.triangles[index][i]];
    has_angle[i] = triangle.particles[i + 3] != no_particle || triangle.ghosts[i] != no_particle;
  }
  const MaterialCase& material = *body.material;
  if (!material.orthotropic_bending) {
    triangle.modulus = materials::triangle_bending_modulus(
        rest, has_angle, material.bending_stiffness, material.poisson_ratio);
    return;
  }
  const Vec3 warp = warp_direction(body, index);
  const materials::OrthotropicModuli moduli = flat_bending_moduli(material);
  triangle.modulus = materials::triangle_bending_modulus(rest, warp, has_angle, moduli);
  const BendingLaw law = *bending_law(material);
  if (const auto* curved = std::get_if<materials::CurvedBending>(&law)) {
    triangle.law = std::make_shared<const materials::CurvedBending>(*curved);
    triangle.map = materials::bending_map(rest, warp, has_angle, moduli);
  }
}

}  // namespace

// Returns null only if the case has no clamps. While no clamp holds an edge of a dynamic body, the
// force has no triangles, and the trajectory still records its energy.
std::unique_ptr<Force> make_clamp_force(const Scene& scene) {
  if (!has_clamps(scene.source)) return nullptr;
  std::vector<ClampedTriangle> triangles;
  VaryingNumbers damping_times;
  bool is_damped = false;
  MovingPoints ghosts;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const SceneBody& body = scene.bodies[b];
    const std::vector<ClampedBy> edges = clamped_edges_of(scene, b);
    if (edges.empty()) continue;
    const std::size_t first = triangles.size();
    const bsi::Mesh mesh = bsi::build_mesh(body.atlas);
    for (std::size_t e = 0; e < edges.size(); ++e) {
      const ClampedEdge& edge = *edges[e].edge;
      const bool again = e > 0 && edges[e - 1].edge->triangle == edge.triangle;
      if (!again) triangles.push_back(triangle_of(body, mesh, edge.triangle));
      ClampedTriangle& triangle = triangles.back();
      triangle.particles[edge.edge + 3] = no_particle;
      triangle.ghosts[edge.edge] = ghosts.add(*edges[e].held, edge.ghost);
      triangle.pins[edge.edge] = edges[e].held->pin;
      triangle.body = b;
      triangle.factors[edge.edge] = 2;
      find_modulus(body, mesh, edge.triangle, triangle);
    }
    damping_times.append(static_cast<int>(triangles.size() - first),
                         body.material->bending_damping);
    is_damped |= !body.material->bending_damping.is_zero();
  }
  return std::make_unique<ClampForce>(std::move(triangles), std::move(damping_times), is_damped,
                                      std::move(ghosts), rest_positions(scene));
}

}  // namespace weft::sim
