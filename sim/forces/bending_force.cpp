#include "materials/bending.h"

#include "materials/hinge.h"
#include "sim/forces/force_arrays.h"
#include "sim/forces/stencil_array.h"
#include "sim/forces/stencil_numbers.h"
#include "sim/parallel.h"
#include "sim/scene/scene.h"

namespace weft::sim {

namespace {

using materials::lane_count;
using materials::Lanes;
using materials::Mat3Of;
using materials::Nodes3;
using materials::NodesOf;
using materials::Vec3Of;

// A triangle with the hinge of each edge, the one opposite its node, and its quadratic form in
// their angles.
struct BendingTriangle {
  std::array<int, 3> nodes{};
  std::array<int, 3> hinge{-1, -1, -1};  // -1 on the border
  std::array<bool, 3> is_second{};       // of the hinge's triangles
  Mat3 modulus = Mat3::Zero();
};

struct BendingData {
  std::vector<std::array<int, 4>> hinge_nodes;  // of interior edges, as in materials/hinge.h
  std::vector<BendingTriangle> triangles;
  StencilNumbers hinge_damping_times, triangle_damping_times;  // s
};

class BendingForce final : public Force {
 public:
  BendingForce(const BendingData& data, const std::vector<Vec3>& rest)
      : hinge_stencils_(data.hinge_nodes, static_cast<int>(rest.size())),
        triangle_stencils_(stencils_of(data), static_cast<int>(rest.size())),
        hinge_damping_times_(data.hinge_damping_times),
        triangle_damping_times_(data.triangle_damping_times),
        is_damped_(triangle_damping_times_.has_positive()) {
    pack_hinges(rest);
    pack_triangles(data);
  }

  std::string_view name() const override { return "bending"; }

  double energy(const Kinematics& state, int threads) override {
    hinge_stencils_.for_each_batch(threads, [&](int first) {
      HingeBatch& hinges = hinges_[first / lane_count];
      hinges.strain = materials::hinge_angle(
                          materials::hinge_vectors(hinge_stencils_.gather(first, state.position))) -
                      hinges.rest_angle;
    });
    return parallel_sum(static_cast<int>(triangles_.size()), threads, [&](int first, int last) {
      Lanes sum = 0;
      for (int batch = first; batch < last; ++batch) {
        const Vec3Of<Lanes> strains = of_edges(triangles_[batch], &HingeBatch::strain);
        sum += 0.5 * materials::dot(strains, triangles_[batch].times_modulus(strains));
      }
      return materials::sum_of_lanes(sum);
    });
  }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) override {
    measure(state, threads);
    hinge_stencils_.for_each_batch(threads, [&](int first) {
      const NodesOf<Lanes, 4> gradient = materials::hinge_gradient(
          materials::hinge_vectors(hinge_stencils_.gather(first, state.position)));
      hinge_stencils_.scatter(
          first, NodesOf<Lanes, 4>(-hinges_[first / lane_count].moment * gradient), force);
    });
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    triangle_stencils_.add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) override { triangle_stencils_.attach(pattern); }

  // K = B^T C B + sum_h moment_h d^2 theta_h, D = B^T C B diag(beta): Gauss-Newton plus the stress
  // part.
  void add_derivatives(const Kinematics& state, const Derivatives& into, Definiteness definiteness,
                       int threads) override {
    if (definiteness == Definiteness::exact) measure(state, threads);
    triangle_stencils_.for_each_batch(threads, [&](int first) {
      const TriangleBatch& triangles = triangles_[first / lane_count];
      const NodesOf<Lanes, 6> x = triangle_stencils_.gather(first, state.position);
      const auto hinges = hinges_around(x);
      StencilBlocks blocks = elastic_blocks(triangles, hinges);
      if (is_damped_) scatter_damping(first, into, blocks);
      if (definiteness == Definiteness::exact) {
        Vec3Of<Lanes> moments = of_edges(triangles, &HingeBatch::moment);
        for (int i = 0; i < 3; ++i)
          moments[i] = materials::choose(hinges[i].flat_triangle, 0.0, moments[i]);
        add_stress(x, moments, blocks);
      }
      triangle_stencils_.scatter(first, blocks, into.stiffness);
    });
  }

 private:
  // Of a triangle: its own nodes, then the node across each edge.
  using StencilBlocks = materials::StencilMatrix<Lanes, 6>;
  using HingeVectors = materials::HingeVectorsOf<Lanes>;

  struct HingeBatch {
    Lanes rest_angle;
    Lanes strain = 0;  // theta - theta_rest + beta theta', rad
    Lanes moment = 0;  // dW/d theta, N m
  };
  struct TriangleBatch {
    std::array<Lanes, 6> modulus;  // a symmetric matrix, row by row from its diagonal
    // The hinge of each edge; of the border, one beyond the last whose strain and moment stay zero.
    std::array<std::array<int, lane_count>, 3> hinge;

    static int index(int i, int j) {
      return i <= j ? materials::StencilMatrix<Lanes, 3>::index(i, j) : index(j, i);
    }
    Vec3Of<Lanes> times_modulus(const Vec3Of<Lanes>& a) const {
      const auto& c = modulus;
      return {c[0] * a[0] + c[1] * a[1] + c[2] * a[2], c[1] * a[0] + c[3] * a[1] + c[4] * a[2],
              c[2] * a[0] + c[4] * a[1] + c[5] * a[2]};
    }
  };

  // The hinges' strains, and their moments from both triangles. Gradients are cheaper computed
  // where they are used than kept: twelve numbers a hinge.
  void measure(const Kinematics& state, int threads) {
    hinge_stencils_.for_each_batch(threads, [&](int first) {
      const auto vectors = materials::hinge_vectors(hinge_stencils_.gather(first, state.position));
      HingeBatch& hinges = hinges_[first / lane_count];
      hinges.strain = materials::hinge_angle(vectors) - hinges.rest_angle;
      hinges.moment = 0;
      if (!is_damped_) return;
      const NodesOf<Lanes, 4> v = hinge_stencils_.gather(first, state.velocity);
      const NodesOf<Lanes, 4> gradient = materials::hinge_gradient(vectors);
      Lanes angle_rate = 0;
      for (int node = 0; node < 4; ++node)
        angle_rate += materials::dot(gradient.col(node), v.col(node));
      hinges.strain += hinge_damping_times_.batch(first) * angle_rate;
    });
    triangle_stencils_.for_each_batch(threads, [&](int first) {
      const TriangleBatch& triangles = triangles_[first / lane_count];
      add_moments(triangles, triangles.times_modulus(of_edges(triangles, &HingeBatch::strain)));
    });
  }

  // A number of the hinges of each edge.
  Vec3Of<Lanes> of_edges(const TriangleBatch& triangles, Lanes HingeBatch::*number) const {
    Vec3Of<Lanes> result;
    for (int i = 0; i < 3; ++i) {
      for (int lane = 0; lane < lane_count; ++lane) {
        const int h = triangles.hinge[i][lane];
        result[i].values[lane] = (hinges_[h / lane_count].*number).values[h % lane_count];
      }
    }
    return result;
  }

  // Two triangles of a hinge share particles, and are not at work side by side.
  void add_moments(const TriangleBatch& triangles, const Vec3Of<Lanes>& moments) {
    for (int i = 0; i < 3; ++i) {
      for (int lane = 0; lane < lane_count; ++lane) {
        const int h = triangles.hinge[i][lane];
        if (h < hinge_stencils_.count())
          hinges_[h / lane_count].moment.values[h % lane_count] += moments[i].values[lane];
      }
    }
  }

  // Of edge i: its ends as it runs round the triangle, the triangle's own node across it, and that
  // of the other triangle.
  static std::array<HingeVectors, 3> hinges_around(const NodesOf<Lanes, 6>& x) {
    std::array<HingeVectors, 3> hinges;
    for (int i = 0; i < 3; ++i) {
      NodesOf<Lanes, 4> nodes;
      nodes << x.col((i + 1) % 3), x.col((i + 2) % 3), x.col(i), x.col(3 + i);
      hinges[i] = materials::hinge_vectors(nodes);
    }
    return hinges;
  }

  // B^T C B. The angle of edge i depends on the triangle's own nodes and on node 3 + i. On the
  // border, where C is zero, what is across does not matter.
  static StencilBlocks elastic_blocks(const TriangleBatch& triangles,
                                      const std::array<HingeVectors, 3>& hinges) {
    const auto modulus = [&](int i, int j) {
      return triangles.modulus[TriangleBatch::index(i, j)];
    };
    Vec3Of<Lanes> inner[3][3], across[3], stress[3][3];  // d theta / d x, [edge][own node]
    for (int i = 0; i < 3; ++i) {
      const NodesOf<Lanes, 4> gradient = materials::hinge_gradient(hinges[i]);
      inner[i][(i + 1) % 3] = gradient.col(0);
      inner[i][(i + 2) % 3] = gradient.col(1);
      inner[i][i] = gradient.col(2);
      across[i] = gradient.col(3);
    }
    for (int i = 0; i < 3; ++i) {
      for (int a = 0; a < 3; ++a) {
        stress[i][a] =
            modulus(i, 0) * inner[0][a] + modulus(i, 1) * inner[1][a] + modulus(i, 2) * inner[2][a];
      }
    }
    StencilBlocks blocks;
    for (int a = 0; a < 3; ++a) {
      for (int b = a; b < 3; ++b) {
        blocks(a, b) = materials::outer(inner[0][a], stress[0][b]) +
                       materials::outer(inner[1][a], stress[1][b]) +
                       materials::outer(inner[2][a], stress[2][b]);
      }
      for (int j = 0; j < 3; ++j) blocks(a, 3 + j) = materials::outer(stress[j][a], across[j]);
    }
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j)
        blocks(3 + i, 3 + j) = materials::outer<Lanes>(modulus(i, j) * across[i], across[j]);
    }
    return blocks;
  }

  // Adds D, the elastic blocks times beta; where it is joined to K, to those blocks themselves.
  void scatter_damping(int first, const Derivatives& into, StencilBlocks& blocks) const {
    const Lanes damping_times = triangle_damping_times_.batch(first);
    if (!into.is_joined()) {
      triangle_stencils_.scatter(first, blocks.scaled(damping_times), *into.damping);
      return;
    }
    const NodesOf<Lanes, 6> product = blocks.times(triangle_stencils_.gather(first, into.along));
    triangle_stencils_.scatter(first, NodesOf<Lanes, 6>(damping_times * product), into.product);
    blocks.scale(1.0 + into.inverse_gamma * damping_times);
  }

  // Each triangle's part of moment_h d^2 theta_h, over its own nodes.
  static void add_stress(const NodesOf<Lanes, 6>& x, const Vec3Of<Lanes>& moments,
                         StencilBlocks& blocks) {
    const auto stress = materials::hinge_hessians<Lanes>(x.leftCols<3>(), moments);
    for (int a = 0; a < 3; ++a) {
      for (int b = a; b < 3; ++b) blocks(a, b) += stress(a, b);
    }
  }

  // A border edge has no node across: its place repeats a node of the triangle, with no gradient.
  static std::vector<std::array<int, 6>> stencils_of(const BendingData& data) {
    std::vector<std::array<int, 6>> stencils;
    stencils.reserve(data.triangles.size());
    for (const BendingTriangle& triangle : data.triangles) {
      const auto& own = triangle.nodes;
      std::array<int, 6> stencil{own[0], own[1], own[2], own[0], own[0], own[0]};
      for (int i = 0; i < 3; ++i) {
        if (triangle.hinge[i] >= 0)
          stencil[3 + i] = data.hinge_nodes[triangle.hinge[i]][triangle.is_second[i] ? 2 : 3];
      }
      stencils.push_back(stencil);
    }
    return stencils;
  }

  static int batches_of(int count) { return (count + lane_count - 1) / lane_count; }

  void pack_hinges(const std::vector<Vec3>& rest) {
    const int count = hinge_stencils_.count();
    hinges_.resize(batches_of(count) + 1);  // the last: that of border edges
    // By the operations that find the angles later, so that a body at rest feels no force at all.
    hinge_stencils_.for_each_batch(1, [&](int first) {
      hinges_[first / lane_count].rest_angle =
          materials::hinge_angle(materials::hinge_vectors(hinge_stencils_.gather(first, rest)));
    });
  }

  void pack_triangles(const BendingData& data) {
    const int count = triangle_stencils_.count();
    triangles_.resize(batches_of(count));
    const int border = lane_count * batches_of(hinge_stencils_.count());
    for (int t = 0; t < static_cast<int>(triangles_.size()) * lane_count; ++t) {
      TriangleBatch& batch = triangles_[t / lane_count];
      const int lane = t % lane_count;
      const BendingTriangle triangle = t < count ? data.triangles[t] : BendingTriangle{};
      for (int i = 0; i < 3; ++i) {
        for (int j = i; j < 3; ++j)
          batch.modulus[TriangleBatch::index(i, j)].values[lane] = triangle.modulus(i, j);
        batch.hinge[i][lane] = triangle.hinge[i] >= 0 ? triangle.hinge[i] : border;
      }
    }
  }

  StencilArray<4> hinge_stencils_;
  StencilArray<6> triangle_stencils_;
  std::vector<HingeBatch> hinges_;        // eight a batch
  std::vector<TriangleBatch> triangles_;  // eight a batch
  StencilNumbers hinge_damping_times_, triangle_damping_times_;
  bool is_damped_ = false;
};

void add_body(const SceneBody& body, BendingData& data) {
  const MaterialCase& material = *body.material;
  const bsi::Mesh mesh = bsi::build_mesh(body.atlas);  // that of the body may have no edges
  std::vector<int> hinge_of_edge(mesh.edges.size(), -1);
  for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
    const bsi::Edge& edge = mesh.edges[e];
    if (edge.triangle[1] < 0) continue;
    // The first triangle holds the edge in this direction: (x0, x1, x2); the second, (x1, x0, x3).
    std::array<int, 4> nodes{edge.vertex[0], edge.vertex[1], edge.opposite[0], edge.opposite[1]};
    for (int& node : nodes) node += body.first_particle;
    hinge_of_edge[e] = static_cast<int>(data.hinge_nodes.size());
    data.hinge_nodes.push_back(nodes);
    data.hinge_damping_times.push_back(material.bending_damping);
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    BendingTriangle triangle;
    std::array<bool, 3> has_angle{};
    Nodes3 rest;
    for (int i = 0; i < 3; ++i) {
      const int edge = mesh.triangle_edges[t][i];
      triangle.nodes[i] = mesh.triangles[t][i] + body.first_particle;
      triangle.hinge[i] = hinge_of_edge[edge];
      triangle.is_second[i] = mesh.edges[edge].triangle[0] != static_cast<int>(t);
      has_angle[i] = triangle.hinge[i] >= 0;
      rest.col(i) = body.rest[mesh.triangles[t][i]];
    }
    if (!has_angle[0] && !has_angle[1] && !has_angle[2]) continue;
    triangle.modulus = materials::triangle_bending_modulus(
        rest, has_angle, material.bending_stiffness, material.poisson_ratio);
    data.triangles.push_back(triangle);
    data.triangle_damping_times.push_back(material.bending_damping);
  }
}

}  // namespace

std::unique_ptr<Force> make_bending_force(const Scene& scene) {
  BendingData data;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    if (scene.bodies[b].material->bending_stiffness > 0) add_body(scene.bodies[b], data);
  }
  if (data.triangles.empty()) return nullptr;
  return std::make_unique<BendingForce>(data, rest_positions(scene));
}

}  // namespace weft::sim
