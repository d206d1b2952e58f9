#include "materials/bending.h"

#include "materials/hinge.h"
#include "sim/forces/force_arrays.h"
#include "sim/forces/stencil_array.h"
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
  double damping_time = 0;  // s
};

struct BendingData {
  std::vector<std::array<int, 4>> hinge_nodes;  // of interior edges, as in materials/hinge.h
  std::vector<double> hinge_damping_times;      // s
  std::vector<BendingTriangle> triangles;
};

class BendingForce final : public Force {
 public:
  BendingForce(const BendingData& data, const std::vector<Vec3>& rest)
      : hinge_stencils_(data.hinge_nodes, static_cast<int>(rest.size())),
        triangle_stencils_(stencils_of(data), static_cast<int>(rest.size())) {
    pack_hinges(data, rest);
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
        const Vec3Of<Lanes> strains = strains_of(triangles_[batch]);
        sum += 0.5 * materials::dot(strains, triangles_[batch].modulus * strains);
      }
      return materials::sum_of_lanes(sum);
    });
  }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) override {
    measure(state, threads);
    hinge_stencils_.for_each_batch(threads, [&](int first) {
      const HingeBatch& hinges = hinges_[first / lane_count];
      Lanes moments;
      for (int lane = 0; lane < lane_count; ++lane)
        moments.values[lane] = moment(std::min(first + lane, hinge_stencils_.count() - 1));
      hinge_stencils_.scatter(first, NodesOf<Lanes, 4>(-moments * hinges.gradient), force);
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
    measure(state, threads);
    triangle_stencils_.for_each_batch(threads, [&](int first) {
      const TriangleBatch& triangles = triangles_[first / lane_count];
      StencilBlocks blocks = elastic_blocks(triangles);
      if (is_damped_)
        triangle_stencils_.scatter_damping(first, blocks.scaled(triangles.damping_time), into,
                                           blocks);
      if (definiteness == Definiteness::exact) add_stress(first, state.position, blocks);
      triangle_stencils_.scatter(first, blocks, into.stiffness);
    });
  }

 private:
  // Of a triangle: its own nodes, then the node across each edge.
  using StencilBlocks = materials::StencilMatrix<Lanes, 6>;

  struct HingeBatch {
    Lanes rest_angle, damping_time;
    Lanes strain = 0;    // theta - theta_rest + beta theta', rad
    Lanes has_area = 0;  // 0 where a triangle has none, and the angle no derivatives; else 1
    NodesOf<Lanes, 4> gradient = NodesOf<Lanes, 4>::Zero();
  };
  struct TriangleBatch {
    Mat3Of<Lanes> modulus;
    Lanes damping_time;
    Vec3Of<Lanes> moments;  // dW/d theta of its three hinges, of this triangle alone, N m
    // Twice the number of each edge's hinge, and one more for the second of its triangles. Border
    // edges have a hinge beyond the last, whose strain and gradient stay zero.
    std::array<std::array<int, lane_count>, 3> hinge;
  };

  // The hinges' strains and gradients, and the moments that each triangle gives them.
  void measure(const Kinematics& state, int threads) {
    hinge_stencils_.for_each_batch(threads, [&](int first) {
      const auto vectors = materials::hinge_vectors(hinge_stencils_.gather(first, state.position));
      const NodesOf<Lanes, 4> v = hinge_stencils_.gather(first, state.velocity);
      HingeBatch& hinges = hinges_[first / lane_count];
      hinges.gradient = materials::hinge_gradient(vectors);
      hinges.has_area = materials::choose(vectors.flat_triangle, 0.0, 1.0);
      Lanes angle_rate = 0;
      for (int node = 0; node < 4; ++node)
        angle_rate += materials::dot(hinges.gradient.col(node), v.col(node));
      hinges.strain =
          materials::hinge_angle(vectors) - hinges.rest_angle + hinges.damping_time * angle_rate;
    });
    triangle_stencils_.for_each_batch(threads, [&](int first) {
      TriangleBatch& triangles = triangles_[first / lane_count];
      triangles.moments = triangles.modulus * strains_of(triangles);
    });
  }

  Vec3Of<Lanes> strains_of(const TriangleBatch& triangles) const {
    Vec3Of<Lanes> strains;
    for (int i = 0; i < 3; ++i) {
      for (int lane = 0; lane < lane_count; ++lane) {
        const int h = triangles.hinge[i][lane] / 2;
        strains[i].values[lane] = hinges_[h / lane_count].strain.values[h % lane_count];
      }
    }
    return strains;
  }

  // dW/d theta of a hinge, from both its triangles.
  double moment(int hinge) const {
    double sum = 0;
    for (const auto& [triangle, edge] : triangles_of_hinge_[hinge])
      sum += triangles_[triangle / lane_count].moments[edge].values[triangle % lane_count];
    return sum;
  }

  // d theta / d x of the hinges of edge i at one of their nodes: 0 and 1 the ends of the edge as it
  // runs round the triangle, 2 the triangle's own node across it, 3 that of the other triangle.
  Vec3Of<Lanes> gradient(const TriangleBatch& triangles, int i, int node) const {
    Vec3Of<Lanes> result;
    for (int lane = 0; lane < lane_count; ++lane) {
      const int code = triangles.hinge[i][lane];
      const HingeBatch& hinges = hinges_[code / 2 / lane_count];
      const int column = node ^ (code & 1);  // the second triangle sees the hinge from behind
      for (int axis = 0; axis < 3; ++axis)
        result[axis].values[lane] = hinges.gradient(axis, column).values[code / 2 % lane_count];
    }
    return result;
  }

  // B^T C B. The angle of edge i depends on the triangle's own nodes and on node 3 + i.
  StencilBlocks elastic_blocks(const TriangleBatch& triangles) const {
    Vec3Of<Lanes> inner[3][3], across[3], stress[3][3];  // [edge][own node]
    for (int i = 0; i < 3; ++i) {
      inner[i][(i + 1) % 3] = gradient(triangles, i, 0);
      inner[i][(i + 2) % 3] = gradient(triangles, i, 1);
      inner[i][i] = gradient(triangles, i, 2);
      across[i] = gradient(triangles, i, 3);
    }
    const Mat3Of<Lanes>& modulus = triangles.modulus;
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

  // Each triangle's part of moment_h d^2 theta_h, over its own nodes.
  void add_stress(int first, std::span<const Vec3> position, StencilBlocks& blocks) const {
    const TriangleBatch& triangles = triangles_[first / lane_count];
    Vec3Of<Lanes> moments;
    for (int i = 0; i < 3; ++i) {
      for (int lane = 0; lane < lane_count; ++lane) {
        const int h = triangles.hinge[i][lane] / 2;
        moments[i].values[lane] =
            h < hinge_stencils_.count()
                ? moment(h) * hinges_[h / lane_count].has_area.values[h % lane_count]
                : 0;
      }
    }
    const NodesOf<Lanes, 3> x = triangle_stencils_.gather(first, position).leftCols<3>();
    const auto stress = materials::hinge_hessians(x, moments);
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

  void pack_hinges(const BendingData& data, const std::vector<Vec3>& rest) {
    const int count = hinge_stencils_.count();
    hinges_.resize(batches_of(count) + 1);  // the last: that of border edges
    for (int h = 0; h < count; ++h)
      hinges_[h / lane_count].damping_time.values[h % lane_count] = data.hinge_damping_times[h];
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
    triangles_of_hinge_.resize(data.hinge_nodes.size());
    for (int t = 0; t < static_cast<int>(triangles_.size()) * lane_count; ++t) {
      TriangleBatch& batch = triangles_[t / lane_count];
      const int lane = t % lane_count;
      const BendingTriangle triangle = t < count ? data.triangles[t] : BendingTriangle{};
      for (int k = 0; k < 9; ++k) batch.modulus.data()[k].values[lane] = triangle.modulus.data()[k];
      batch.damping_time.values[lane] = triangle.damping_time;
      is_damped_ |= triangle.damping_time > 0;
      for (int i = 0; i < 3; ++i) {
        const int h = triangle.hinge[i];
        batch.hinge[i][lane] = 2 * (h >= 0 ? h : border) + (triangle.is_second[i] ? 1 : 0);
        if (h >= 0) triangles_of_hinge_[h][triangle.is_second[i] ? 1 : 0] = {t, i};
      }
    }
  }

  StencilArray<4> hinge_stencils_;
  StencilArray<6> triangle_stencils_;
  std::vector<HingeBatch> hinges_;                                      // eight a batch
  std::vector<TriangleBatch> triangles_;                                // eight a batch
  std::vector<std::array<std::pair<int, int>, 2>> triangles_of_hinge_;  // (triangle, edge in it)
  bool is_damped_ = false;
};

void add_body(const SceneBody& body, BendingData& data) {
  const MaterialCase& material = *body.material;
  std::vector<int> hinge_of_edge(body.mesh.edges.size(), -1);
  for (std::size_t e = 0; e < body.mesh.edges.size(); ++e) {
    const bsi::Edge& edge = body.mesh.edges[e];
    if (edge.triangle[1] < 0) continue;
    // The first triangle holds the edge in this direction: (x0, x1, x2); the second, (x1, x0, x3).
    std::array<int, 4> nodes{edge.vertex[0], edge.vertex[1], edge.opposite[0], edge.opposite[1]};
    for (int& node : nodes) node += body.first_particle;
    hinge_of_edge[e] = static_cast<int>(data.hinge_nodes.size());
    data.hinge_nodes.push_back(nodes);
    data.hinge_damping_times.push_back(material.bending_damping);
  }
  for (std::size_t t = 0; t < body.mesh.triangles.size(); ++t) {
    BendingTriangle triangle;
    triangle.damping_time = material.bending_damping;
    std::array<bool, 3> has_angle{};
    Nodes3 rest;
    for (int i = 0; i < 3; ++i) {
      const int edge = body.mesh.triangle_edges[t][i];
      triangle.nodes[i] = body.mesh.triangles[t][i] + body.first_particle;
      triangle.hinge[i] = hinge_of_edge[edge];
      triangle.is_second[i] = body.mesh.edges[edge].triangle[0] != static_cast<int>(t);
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
  return std::make_unique<BendingForce>(data, rest_positions(scene));
}

}  // namespace weft::sim
