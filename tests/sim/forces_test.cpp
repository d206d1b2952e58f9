// Forces, which work on batches of quads, against sums of their formulas for single elements; their
// matrices against differences of forces.
#include <optional>
#include <random>

#include "materials/bending.h"
#include "materials/drag.h"
#include "materials/fabric_membrane.h"
#include "materials/hinge.h"
#include "materials/membrane.h"
#include "materials/orthotropic_membrane.h"
#include "sim/scene/cloth_laws.h"
#include "simulated_case.h"

namespace weft::sim::forces_test {
namespace {

using materials::Nodes3;
using materials::Nodes4;

// Images whose rows hold whole batches of quads, parts of them, or both; with seams and poles.
const std::vector<std::string> images{
    R"({ type = "rectangle", size = [1.0, 1.2], resolution = [2, 2] })",
    R"({ type = "rectangle", size = [1.0, 1.2], resolution = [4, 9] })",
    R"({ type = "rectangle", size = [1.0, 1.2], resolution = [7, 13] })",
    R"({ type = "rectangle", size = [1.0, 1.2], resolution = [40, 33] })",
    R"({ type = "cylinder", radius = 0.3, length = 1.0, resolution = [11, 17] })",
    R"({ type = "torus", major_radius = 0.5, minor_radius = 0.2, resolution = [3, 4] })",
    R"({ type = "torus", major_radius = 0.5, minor_radius = 0.2, resolution = [12, 24] })",
    R"({ type = "sphere", radius = 0.5, resolution = [9] })"};

// Two bodies, the second of this image, with every particle moved and in motion at random.
class TwoBodies {
 public:
  TwoBodies(const std::string& image, const std::string& material)
      : scene_(build_scene(parse_case("[contact]\nenabled = false\n[world]\ngravity = [0, 0, 0]\n"
                                      "wind = [1, 2, 3]\n[material.cloth]\n" +
                                          material +
                                          "\n[[body]]\nname = \"first\"\nshape = " + images[0] +
                                          "\n[[body]]\nname = \"second\"\nshape = " + image,
                                      "test.toml", {}))),
        dynamics_(*scene_, statistics_),
        state_(dynamics_.initial_state()) {
    std::uniform_real_distribution<double> change(-0.01, 0.01);
    for (double& value : state_) value += change(random_);
  }

  const Scene& scene() const { return *scene_; }
  Dynamics& dynamics() { return dynamics_; }
  std::vector<double>& state() { return state_; }
  StateView now() const { return StateView::of(state_); }

  std::vector<Vec3> forces() {
    std::vector<Vec3> forces(scene_->mass.size());
    EXPECT_FALSE(dynamics_.acceleration(0, state_, forces));
    for (std::size_t i = 0; i < forces.size(); ++i) forces[i] *= scene_->mass[i];
    return forces;
  }
  std::vector<Vec3> random_vectors() {
    std::uniform_real_distribution<double> entry(-1, 1);
    std::vector<Vec3> vectors(scene_->mass.size());
    for (Vec3& v : vectors) v = Vec3::NullaryExpr([&] { return entry(random_); });
    return vectors;
  }

 private:
  std::mt19937 random_{3};
  std::unique_ptr<const Scene> scene_;
  Statistics statistics_;
  Dynamics dynamics_;
  std::vector<double> state_;
};

double largest(const std::vector<Vec3>& vectors) {
  double norm = 0;
  for (const Vec3& v : vectors) norm = std::max(norm, v.norm());
  return norm;
}

void expect_near(const std::vector<Vec3>& found, const std::vector<Vec3>& expected, double share) {
  ASSERT_EQ(found.size(), expected.size());
  const double scale = largest(expected);
  ASSERT_GT(scale, 0);
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_LT((found[i] - expected[i]).norm(), share * scale) << "particle " << i;
}

template <std::size_t count>
materials::NodesOf<double, static_cast<int>(count)> nodes_of(
    std::span<const Vec3> values, const std::array<int, count>& particles) {
  materials::NodesOf<double, static_cast<int>(count)> nodes;
  for (std::size_t i = 0; i < count; ++i) nodes.col(i) = values[particles[i]];
  return nodes;
}

// Calls add(body, its rest positions, its part of the state and of the sum).
template <class Add>
std::vector<Vec3> sum_over_bodies(const TwoBodies& bodies, const Add& add) {
  std::vector<Vec3> sum(bodies.scene().mass.size(), Vec3::Zero());
  for (const SceneBody& body : bodies.scene().bodies) {
    const auto own = [&](auto all) {
      return all.subspan(body.first_particle, body.particle_count());
    };
    add(body, Kinematics{own(bodies.now().position), own(bodies.now().velocity)},
        own(std::span(sum)));
  }
  return sum;
}

TEST(Forces, MembranesAreTheSumOfTheirTriangles) {
  for (const std::string& image : images) {
    for (const double damping : {0.0, 0.01}) {
      SCOPED_TRACE(image);
      TwoBodies bodies(image,
                       "membrane_stiffness = 100\nstiffness_damping = " + std::to_string(damping));
      const auto expected = sum_over_bodies(
          bodies, [&](const SceneBody& body, const Kinematics& state, std::span<Vec3> sum) {
            for (const auto& triangle : body.mesh.triangles) {
              const Nodes3 forces = materials::membrane_forces(
                  materials::make_triangle_membrane(nodes_of<3>(body.rest, triangle), 100,
                                                    body.material->poisson_ratio, damping),
                  nodes_of<3>(state.position, triangle), nodes_of<3>(state.velocity, triangle));
              for (int i = 0; i < 3; ++i) sum[triangle[i]] += forces.col(i);
            }
          });
      expect_near(bodies.forces(), expected, 1e-13);
    }
  }
}

// Materials that differ by direction: a linear one, one by curves, a measured one.
const std::vector<std::string> woven_membranes{
    R"([material.cloth.orthotropic_membrane]
warp_stiffness = 100
weft_stiffness = 40
shear_modulus = 8
poisson_ratio = 0.2
)",
    R"([material.cloth.orthotropic_membrane]
warp_curve = { strains = [-0.5, 0, 0.5], tensions = [-20, 0, 70] }
weft_stiffness = 40
shear_curve = { strains = [0, 1], tensions = [0, 8] }
)",
    R"([material.cloth.measured_membrane]
warp = [50, 70, 60, 80, 90, 100]
coupling = [5, 10, 15, 20, 25, 30]
weft = [150, 170, 160, 180, 190, 120]
shear = [20, 15, 10, 5, 10, 15]
)"};

TEST(Forces, WovenMembranesAreTheSumOfTheirTriangles) {
  for (const std::string& image : images) {
    for (const std::string& material : woven_membranes) {
      for (const double damping : {0.0, 0.01}) {
        SCOPED_TRACE(image + material);
        TwoBodies bodies(image, "stiffness_damping = " + std::to_string(damping) + "\n" + material);
        const auto expected = sum_over_bodies(
            bodies, [&](const SceneBody& body, const Kinematics& state, std::span<Vec3> sum) {
              const StretchLaw law = *stretch_law(*body.material);
              for (std::size_t t = 0; t < body.mesh.triangles.size(); ++t) {
                const auto& triangle = body.mesh.triangles[t];
                const auto membrane = materials::make_fabric_membrane(
                    nodes_of<3>(body.rest, triangle), warp_direction(body, static_cast<int>(t)),
                    damping);
                const Nodes3 edges =
                    materials::opposite_edges(nodes_of<3>(state.position, triangle));
                const Nodes3 forces = std::visit(
                    [&](const auto& each) {
                      return materials::pulls_of(
                          materials::fabric_tensions(membrane, each, edges,
                                                     nodes_of<3>(state.velocity, triangle)),
                          edges);
                    },
                    law);
                for (int i = 0; i < 3; ++i) sum[triangle[i]] += forces.col(i);
              }
            });
        expect_near(bodies.forces(), expected, 1e-11);
      }
    }
  }
}

// Returns the nodes of the hinge at the edge opposite node i of a triangle: the edge's ends, node
// i, and the node across. Returns none on the border.
std::optional<std::array<int, 4>> hinge_of(const bsi::Mesh& mesh, int triangle, int i) {
  const bsi::Edge& edge = mesh.edges[mesh.triangle_edges[triangle][i]];
  if (edge.triangle[1] < 0) return std::nullopt;
  const auto& own = mesh.triangles[triangle];
  return std::array{own[(i + 1) % 3], own[(i + 2) % 3], own[i],
                    edge.opposite[edge.triangle[0] == triangle ? 1 : 0]};
}

// Adds -sum moments_i d theta_i / d x of every triangle, with the moments of its angles.
// moments_of(triangle, rest positions, edges with an angle, strains, rates) returns them.
template <class MomentsOf>
void add_bending(const SceneBody& body, const Kinematics& state, const MomentsOf& moments_of,
                 std::span<Vec3> sum) {
  const bsi::Mesh mesh = bsi::build_mesh(body.atlas);
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
    std::array<bool, 3> has_angle{};
    Vec3 strains = Vec3::Zero(), rates = Vec3::Zero();
    std::array<Nodes4, 3> gradients;
    for (int i = 0; i < 3; ++i) {
      const auto hinge = hinge_of(mesh, t, i);
      has_angle[i] = hinge.has_value();
      if (!hinge) continue;
      const Nodes4 x = nodes_of<4>(state.position, *hinge);
      gradients[i] = materials::hinge_gradient(x);
      rates[i] = gradients[i].cwiseProduct(nodes_of<4>(state.velocity, *hinge)).sum();
      strains[i] =
          materials::hinge_angle(x) - materials::hinge_angle(nodes_of<4>(body.rest, *hinge));
    }
    const Vec3 moments =
        moments_of(t, nodes_of<3>(body.rest, mesh.triangles[t]), has_angle, strains, rates);
    for (int i = 0; i < 3; ++i) {
      const auto hinge = hinge_of(mesh, t, i);
      for (int k = 0; hinge && k < 4; ++k) sum[(*hinge)[k]] -= moments[i] * gradients[i].col(k);
    }
  }
}

TEST(Forces, BendingIsTheSumOfItsHinges) {
  for (const std::string& image : images) {
    for (const double damping : {0.0, 0.3}) {
      SCOPED_TRACE(image);
      TwoBodies bodies(image,
                       "membrane_stiffness = 0\nbending_stiffness = 0.5\nbending_damping = " +
                           std::to_string(damping));
      const auto expected = sum_over_bodies(
          bodies, [&](const SceneBody& body, const Kinematics& state, std::span<Vec3> sum) {
            const auto moments_of = [&](int, const Nodes3& rest, const auto& has_angle,
                                        const Vec3& strains, const Vec3& rates) -> Vec3 {
              return materials::triangle_bending_modulus(rest, has_angle, 0.5,
                                                         body.material->poisson_ratio) *
                     (strains + damping * rates);
            };
            add_bending(body, state, moments_of, sum);
          });
      expect_near(bodies.forces(), expected, 1e-12);
    }
  }
}

// Bending that differs by direction, without and with a dependence on the curvature.
const std::vector<std::string> woven_bendings{
    "[material.cloth.orthotropic_bending]\nwarp = [0.5]\nbias = [0.3]\nweft = [0.2]\n",
    "[material.cloth.orthotropic_bending]\nwarp = [0.5, 0.8, 0.6]\nbias = [0.3, 0.4, 0.5]\n"
    "weft = [0.2, 0.3, 0.3]\ncurvatures = [0, 0.3, 1.0]\n"};

TEST(Forces, WovenBendingIsTheSumOfItsHinges) {
  for (const std::string& image : images) {
    for (const std::string& material : woven_bendings) {
      for (const double damping : {0.0, 0.3}) {
        SCOPED_TRACE(image + material);
        TwoBodies bodies(image, "membrane_stiffness = 0\nbending_damping = " +
                                    std::to_string(damping) + "\n" + material);
        const auto expected = sum_over_bodies(
            bodies, [&](const SceneBody& body, const Kinematics& state, std::span<Vec3> sum) {
              const BendingLaw law = *bending_law(*body.material);
              const auto moments_of = [&](int t, const Nodes3& rest, const auto& has_angle,
                                          const Vec3& strains, const Vec3& rates) -> Vec3 {
                const auto map = materials::bending_map(rest, warp_direction(body, t), has_angle,
                                                        flat_bending_moduli(*body.material));
                return std::visit(
                    [&](const auto& each) -> Vec3 {
                      return materials::law_slope(map, each, strains) +
                             damping * (materials::law_viscosity(map, each, strains) * rates);
                    },
                    law);
              };
              add_bending(body, state, moments_of, sum);
            });
        expect_near(bodies.forces(), expected, 1e-11);
      }
    }
  }
}

TEST(Forces, DragIsTheSumOfItsTriangles) {
  for (const std::string& image : images) {
    SCOPED_TRACE(image);
    TwoBodies bodies(image, "membrane_stiffness = 0\nnormal_drag = 2\ntangential_drag = 0.5");
    const WorldCase& world = bodies.scene().source.world;
    const materials::Drag drag{2 * world.air_density.constant(),
                               0.5 * world.air_density.constant()};
    const auto expected = sum_over_bodies(
        bodies, [&](const SceneBody& body, const Kinematics& state, std::span<Vec3> sum) {
          for (const auto& triangle : body.mesh.triangles) {
            const Vec3 force =
                materials::drag_force(drag, nodes_of<3>(state.position, triangle),
                                      nodes_of<3>(state.velocity, triangle), world.wind.constant());
            for (const int node : triangle) sum[node] += force / 3;
          }
        });
    expect_near(bodies.forces(), expected, 1e-13);
  }
}

// Returns minus the change of the forces along a direction of positions (half 0) or velocities (1).
// The step is so small that no triangle passes a corner of the curve of its material.
std::vector<Vec3> difference_of_forces(TwoBodies& bodies, int half,
                                       const std::vector<Vec3>& direction) {
  constexpr double step = 1e-7;
  const std::vector<double> state = bodies.state();
  std::array<std::vector<Vec3>, 2> forces;
  for (const int side : {0, 1}) {
    for (std::size_t i = 0; i < 3 * direction.size(); ++i) {
      bodies.state()[half * state.size() / 2 + i] +=
          (side == 0 ? step : -step) * direction[i / 3][i % 3];
    }
    forces[side] = bodies.forces();
    bodies.state() = state;
  }
  for (std::size_t i = 0; i < direction.size(); ++i)
    forces[1][i] = (forces[1][i] - forces[0][i]) / (2 * step);
  return forces[1];
}

void expect_derivative(TwoBodies& bodies, int half,
                       const BlockMatrix& (Dynamics::*matrix)() const) {
  const std::vector<Vec3> direction = bodies.random_vectors();
  std::vector<Vec3> product(direction.size());
  bodies.dynamics().assemble(0, bodies.state());
  (bodies.dynamics().*matrix)().multiply(direction, product, 1);
  expect_near(product, difference_of_forces(bodies, half, direction), 1e-5);
}

TEST(Forces, MatricesAreTheirDerivatives) {
  for (const std::string& image : images) {
    std::vector<std::string> all{"membrane_stiffness = 100",
                                 "membrane_stiffness = 0\nbending_stiffness = 0.5"};
    all.insert(all.end(), woven_membranes.begin(), woven_membranes.end());
    for (const std::string& bending : woven_bendings)
      all.push_back("membrane_stiffness = 0\n" + bending);
    for (const std::string& material : all) {
      SCOPED_TRACE(image + " " + material);
      TwoBodies bodies(image, material);
      expect_derivative(bodies, 0, &Dynamics::stiffness);
    }
  }
}

// The damping matrix of drag is exact if both drag coefficients are equal.
TEST(Forces, DampingIsTheirDerivativeByTheVelocities) {
  for (const std::string& image : images) {
    SCOPED_TRACE(image);
    TwoBodies bodies(image,
                     "membrane_stiffness = 100\nstiffness_damping = 0.1\nbending_stiffness = "
                     "0.5\nbending_damping = 0.2\nnormal_drag = 1\ntangential_drag = 1");
    expect_derivative(bodies, 1, &Dynamics::damping);
  }
}

TEST(Forces, WovenDampingIsTheDerivativeByTheVelocities) {
  for (const std::string& image : images) {
    for (const std::string& membrane : woven_membranes) {
      for (const std::string& bending : woven_bendings) {
        SCOPED_TRACE(image + membrane + bending);
        TwoBodies bodies(image,
                         "stiffness_damping = 0.1\nbending_damping = 0.2\n" + membrane + bending);
        expect_derivative(bodies, 1, &Dynamics::damping);
      }
    }
  }
}

// The joined matrix K + D / gamma and the product D u are those of the separate matrices.
TEST(Forces, JoinedMatricesAreTheSum) {
  constexpr double gamma = 0.02;
  for (const std::string& membrane : woven_membranes) {
    for (const std::string& bending : woven_bendings) {
      SCOPED_TRACE(membrane + bending);
      TwoBodies bodies(images[3],
                       "stiffness_damping = 0.1\nbending_damping = 0.2\n" + membrane + bending);
      for (const Definiteness kind : {Definiteness::exact, Definiteness::semi_definite}) {
        Dynamics& dynamics = bodies.dynamics();
        const std::vector<Vec3> along = bodies.random_vectors(), test = bodies.random_vectors();
        std::vector<Vec3> stiff(along.size()), damped(along.size()), joined(along.size()),
            product(along.size());
        dynamics.assemble(0, bodies.state(), kind);
        dynamics.stiffness().multiply(test, stiff, 1);
        dynamics.damping().multiply(test, damped, 1);
        dynamics.damping().multiply(along, product, 1);
        for (std::size_t i = 0; i < along.size(); ++i) stiff[i] += damped[i] / gamma;
        dynamics.assemble_joined(0, bodies.state(), kind, gamma, along);
        dynamics.stiffness().multiply(test, joined, 1);
        expect_near(joined, stiff, 1e-5);
        expect_near({dynamics.damping_product().begin(), dynamics.damping_product().end()}, product,
                    1e-5);
      }
    }
  }
}

// The order of sums is that of the stencils, not of the threads.
TEST(Forces, SameBitsForAnyNumberOfThreads) {
  std::vector<std::string> all;
  for (const char* laws :
       {"membrane_stiffness = 100\nbending_stiffness = 0.5\n", woven_membranes[2].c_str()}) {
    all.push_back(std::string("stiffness_damping = 0.1\nbending_damping = 0.2\nnormal_drag = 1\n") +
                  laws + (laws == woven_membranes[2].c_str() ? woven_bendings[1] : ""));
  }
  for (const std::string& image : images) {
    for (const std::string& material : all) {
      SCOPED_TRACE(image);
      TwoBodies one(image, material + "[compute]\nthreads = 1"),
          two(image, material + "[compute]\nthreads = 2");
      EXPECT_EQ(one.forces(), two.forces());
      one.dynamics().assemble(0, one.state());
      two.dynamics().assemble(0, two.state());
      const std::vector<Vec3> direction = one.random_vectors();
      std::vector<Vec3> product(direction.size()), other(direction.size());
      one.dynamics().stiffness().multiply(direction, product, 1);
      two.dynamics().stiffness().multiply(direction, other, 1);
      EXPECT_EQ(product, other);
    }
  }
}

}  // namespace
}  // namespace weft::sim::forces_test
