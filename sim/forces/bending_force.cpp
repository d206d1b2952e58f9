#include "materials/bending.h"

#include "materials/hinge.h"
#include "sim/forces/force_arrays.h"
#include "sim/forces/stencil_array.h"
#include "sim/parallel.h"
#include "sim/scene/scene.h"

namespace weft::sim {

namespace {

using materials::Nodes3;
using materials::Nodes4;

// An interior edge: nodes as in materials/hinge.h.
struct Hinge {
  double rest_angle = 0;    // rad
  double damping_time = 0;  // s
};

// A triangle with the hinges of its edges (-1 on the border) and its quadratic form in their
// angles.
struct BendingTriangle {
  std::array<int, 3> hinge{-1, -1, -1};
  Mat3 modulus = Mat3::Zero();
};

struct BendingData {
  std::vector<std::array<int, 4>> hinge_nodes;
  std::vector<Hinge> hinges;
  std::vector<BendingTriangle> triangles;
};

class BendingForce final : public Force {
 public:
  BendingForce(BendingData data, int particle_count)
      : hinge_stencils_(data.hinge_nodes, particle_count),
        hinges_(std::move(data.hinges)),
        triangles_(std::move(data.triangles)),
        state_of_hinge_(hinges_.size()) {
    find_triangles_of_hinges();
    build_triangle_stencils(data.hinge_nodes, particle_count);
  }

  std::string_view name() const override { return "bending"; }

  double energy(const Kinematics& state, int threads) override {
    measure_angles(state, threads);
    return parallel_sum(static_cast<int>(triangles_.size()), threads, [&](int first, int last) {
      double sum = 0;
      for (int t = first; t < last; ++t) {
        Vec3 angle = Vec3::Zero();
        for (int i = 0; i < 3; ++i) {
          const int h = triangles_[t].hinge[i];
          if (h >= 0) angle[i] = state_of_hinge_[h].strain;
        }
        sum += 0.5 * angle.dot(triangles_[t].modulus * angle);
      }
      return sum;
    });
  }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) override {
    measure_hinges(state, threads);
    hinge_stencils_.for_each(threads, [&](int h) {
      const HingeState& hinge = state_of_hinge_[h];
      const double m = moment(h);
      for (int node = 0; node < 4; ++node)
        force[hinge_stencils_[h][node]] -= m * hinge.gradient.col(node);
    });
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    triangle_stencils_.add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) override {
    hinge_stencils_.attach(pattern);
    triangle_stencils_.attach(pattern);
  }

  // K = B^T C B + sum_h moment_h d^2 theta_h, D = B^T C B diag(beta): Gauss-Newton plus the stress
  // part.
  void add_derivatives(const Kinematics& state, BlockMatrix& stiffness, BlockMatrix& damping,
                       Definiteness definiteness, int threads) override {
    measure_hinges(state, threads);
    triangle_stencils_.for_each(threads, [&](int t) {
      const Eigen::Matrix<double, 3, 18> gradient = angle_gradients(t);
      const Eigen::Matrix<double, 18, 18> elastic =
          gradient.transpose() * triangles_[t].modulus * gradient;
      triangle_stencils_.add_block_matrix(t, elastic, stiffness);
      if (damping_time(t) > 0) {
        triangle_stencils_.add_block_matrix(
            t, Eigen::Matrix<double, 18, 18>(damping_time(t) * elastic), damping);
      }
    });
    if (definiteness == Definiteness::semi_definite) return;
    hinge_stencils_.for_each(threads, [&](int h) {
      const materials::Mat12 geometric =
          moment(h) * materials::hinge_hessian(gather(h, state.position));
      hinge_stencils_.add_block_matrix(h, geometric, stiffness);
    });
  }

 private:
  struct HingeState {
    double strain = 0;  // theta - theta_rest + beta theta', rad
    Nodes4 gradient = Nodes4::Zero();
  };

  Nodes4 gather(int hinge, std::span<const Vec3> values) const {
    Nodes4 nodes;
    for (int i = 0; i < 4; ++i) nodes.col(i) = values[hinge_stencils_[hinge][i]];
    return nodes;
  }

  // Strains without their rates, and no gradients: all that the energy asks for.
  void measure_angles(const Kinematics& state, int threads) {
    parallel_chunks(static_cast<int>(hinges_.size()), threads, [&](int first, int last) {
      for (int h = first; h < last; ++h) {
        state_of_hinge_[h].strain =
            materials::hinge_angle(materials::hinge_vectors(gather(h, state.position))) -
            hinges_[h].rest_angle;
      }
    });
  }

  void measure_hinges(const Kinematics& state, int threads) {
    parallel_chunks(static_cast<int>(hinges_.size()), threads, [&](int first, int last) {
      for (int h = first; h < last; ++h) {
        const Nodes4 x = gather(h, state.position);
        HingeState& hinge = state_of_hinge_[h];
        const materials::HingeVectors vectors = materials::hinge_vectors(x);
        hinge.gradient = materials::hinge_gradient(vectors);
        hinge.strain = materials::hinge_angle(vectors) - hinges_[h].rest_angle;
        if (hinges_[h].damping_time > 0) {
          hinge.strain += hinges_[h].damping_time *
                          hinge.gradient.cwiseProduct(gather(h, state.velocity)).sum();
        }
      }
    });
  }

  // dW/d theta of a hinge: from the two triangles it belongs to.
  double moment(int h) const {
    double sum = 0;
    for (const auto& [t, local] : triangles_of_hinge_[h]) {
      if (t < 0) continue;
      for (int i = 0; i < 3; ++i) {
        const int other = triangles_[t].hinge[i];
        if (other >= 0) sum += triangles_[t].modulus(local, i) * state_of_hinge_[other].strain;
      }
    }
    return sum;
  }

  double damping_time(int t) const {
    for (int h : triangles_[t].hinge) {
      if (h >= 0) return hinges_[h].damping_time;
    }
    return 0;
  }

  // d theta_i / d x over the six nodes of a triangle's stencil.
  Eigen::Matrix<double, 3, 18> angle_gradients(int t) const {
    Eigen::Matrix<double, 3, 18> gradient = Eigen::Matrix<double, 3, 18>::Zero();
    for (int i = 0; i < 3; ++i) {
      const int h = triangles_[t].hinge[i];
      if (h < 0) continue;
      for (int node = 0; node < 4; ++node) {
        gradient.block<1, 3>(i, 3 * place_in_stencil_[t][i][node]) =
            state_of_hinge_[h].gradient.col(node).transpose();
      }
    }
    return gradient;
  }

  void find_triangles_of_hinges() {
    triangles_of_hinge_.assign(hinges_.size(), {{{-1, 0}, {-1, 0}}});
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      for (int i = 0; i < 3; ++i) {
        const int h = triangles_[t].hinge[i];
        if (h < 0) continue;
        auto& places = triangles_of_hinge_[h];
        places[places[0].first < 0 ? 0 : 1] = {static_cast<int>(t), i};
      }
    }
  }

  // Six nodes a triangle: its hinges' nodes, each once; unused places repeat the first node.
  void build_triangle_stencils(const std::vector<std::array<int, 4>>& hinge_nodes,
                               int particle_count) {
    std::vector<std::array<int, 6>> stencils;
    for (const BendingTriangle& triangle : triangles_) {
      std::vector<int> nodes;
      std::array<std::array<int, 4>, 3> places{};
      for (int i = 0; i < 3; ++i) {
        if (triangle.hinge[i] < 0) continue;
        for (int node = 0; node < 4; ++node) {
          const int particle = hinge_nodes[triangle.hinge[i]][node];
          const auto found = std::find(nodes.begin(), nodes.end(), particle);
          places[i][node] = static_cast<int>(found - nodes.begin());
          if (found == nodes.end()) nodes.push_back(particle);
        }
      }
      std::array<int, 6> stencil{};
      stencil.fill(nodes.front());
      std::copy(nodes.begin(), nodes.end(), stencil.begin());
      stencils.push_back(stencil);
      place_in_stencil_.push_back(places);
    }
    triangle_stencils_ = StencilArray<6>(std::move(stencils), particle_count);
  }

  StencilArray<4> hinge_stencils_;
  StencilArray<6> triangle_stencils_;
  std::vector<Hinge> hinges_;
  std::vector<BendingTriangle> triangles_;
  std::vector<std::array<std::pair<int, int>, 2>> triangles_of_hinge_;  // (triangle, edge in it)
  std::vector<std::array<std::array<int, 4>, 3>> place_in_stencil_;  // [triangle][edge][hinge node]
  std::vector<HingeState> state_of_hinge_;
};

void add_body(const SceneBody& body, BendingData& data) {
  const MaterialCase& material = *body.material;
  std::vector<int> hinge_of_edge(body.mesh.edges.size(), -1);
  for (std::size_t e = 0; e < body.mesh.edges.size(); ++e) {
    const bsi::Edge& edge = body.mesh.edges[e];
    if (edge.triangle[1] < 0) continue;
    // The first triangle holds the edge in this direction: (x0, x1, x2); the second, (x1, x0, x3).
    const std::array<int, 4> local{edge.vertex[0], edge.vertex[1], edge.opposite[0],
                                   edge.opposite[1]};
    Nodes4 rest;
    std::array<int, 4> nodes{};
    for (int i = 0; i < 4; ++i) {
      rest.col(i) = body.rest[local[i]];
      nodes[i] = local[i] + body.first_particle;
    }
    hinge_of_edge[e] = static_cast<int>(data.hinges.size());
    data.hinges.push_back({materials::hinge_angle(rest), material.bending_damping});
    data.hinge_nodes.push_back(nodes);
  }
  for (std::size_t t = 0; t < body.mesh.triangles.size(); ++t) {
    BendingTriangle triangle;
    std::array<bool, 3> has_angle{};
    Nodes3 rest;
    for (int i = 0; i < 3; ++i) {
      triangle.hinge[i] = hinge_of_edge[body.mesh.triangle_edges[t][i]];
      has_angle[i] = triangle.hinge[i] >= 0;
      rest.col(i) = body.rest[body.mesh.triangles[t][i]];
    }
    if (!has_angle[0] && !has_angle[1] && !has_angle[2]) continue;
    triangle.modulus = materials::triangle_bending_modulus(
        rest, has_angle, material.bending_stiffness, material.poisson_ratio);
    data.triangles.push_back(triangle);
  }
}

}  // namespace

std::unique_ptr<Force> make_bending_force(const Scene& scene) {
  BendingData data;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    if (scene.bodies[b].material->bending_stiffness > 0) add_body(scene.bodies[b], data);
  }
  if (data.triangles.empty()) return nullptr;
  return std::make_unique<BendingForce>(std::move(data), scene.dynamic_particles);
}

}  // namespace weft::sim
