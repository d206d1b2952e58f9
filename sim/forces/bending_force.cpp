#include "materials/bending.h"

#include "sim/base/parallel.h"
#include "sim/forces/force_arrays.h"
#include "sim/forces/quad_hinges.h"
#include "sim/forces/quads.h"
#include "sim/forces/stencil_array.h"
#include "sim/forces/varying_numbers.h"
#include "sim/scene/scene.h"

namespace weft::sim {

namespace {

using materials::lane_count;
using materials::Lanes;
using materials::Mat3;
using materials::Mat3Of;
using materials::Nodes3;
using materials::NodesOf;
using materials::Vec3Of;

using Surroundings = std::array<int, QuadSurroundings::count>;

struct BendingQuads {
  std::vector<Surroundings> nodes;
  std::vector<std::array<Mat3, 2>> moduli;  // of both triangles, over the hinges of each
  VaryingNumbers damping_times;             // s
  bool is_damped = false;                   // at any time
};

// The symmetric matrix C of a triangle, row by row from its diagonal.
struct Modulus {
  std::array<Lanes, 6> entries;

  static constexpr int index(int i, int j) {
    return i <= j ? materials::StencilMatrix<Lanes, 3>::index(i, j) : index(j, i);
  }
  const Lanes& operator()(int i, int j) const { return entries[index(i, j)]; }
  Modulus scaled(const Lanes& factor) const {
    Modulus result = *this;
    for (Lanes& entry : result.entries) entry *= factor;
    return result;
  }
  Vec3Of<Lanes> operator*(const Vec3Of<Lanes>& a) const {
    const auto& c = entries;
    return {c[0] * a[0] + c[1] * a[1] + c[2] * a[2], c[1] * a[0] + c[3] * a[1] + c[4] * a[2],
            c[2] * a[0] + c[4] * a[1] + c[5] * a[2]};
  }
};

using Slopes = QuadSlopes<Lanes>;
using Nodes = Slopes::Nodes;
using Hinges = Slopes::Hinges;  // one number per hinge
using HingeVectors = std::array<materials::HingeVectorsOf<Lanes>, hinge_count>;

// The moduli and rest angles of a batch of quads.
struct BendingBatch {
  std::array<Modulus, 2> moduli;
  Hinges rest_angles;

  Hinges strains(const HingeVectors& hinges) const {
    Hinges strains;
    for (int h = 0; h < hinge_count; ++h)
      strains[h] = materials::hinge_angle(hinges[h]) - rest_angles[h];
    return strains;
  }
  // Returns dW/d theta, N m. W is the energy of the quad's own triangles; those beyond its sides
  // add their own share of the sides' moments.
  Hinges moments(const Hinges& strains) const {
    Hinges sum;
    sum.fill(0);
    for (int t = 0; t < 2; ++t) {
      const Vec3Of<Lanes> own = moduli[t] * of_triangle(strains, t);
      for (int i = 0; i < 3; ++i) sum[hinged_triangles[t].hinges[i]] += own[i];
    }
    return sum;
  }
  Lanes energy(const Hinges& strains) const {
    Lanes sum = 0;
    for (int t = 0; t < 2; ++t) {
      const Vec3Of<Lanes> own = of_triangle(strains, t);
      sum += 0.5 * materials::dot(own, moduli[t] * own);
    }
    return sum;
  }

 private:
  static Vec3Of<Lanes> of_triangle(const Hinges& numbers, int t) {
    const auto& hinges = hinged_triangles[t].hinges;
    return {numbers[hinges[0]], numbers[hinges[1]], numbers[hinges[2]]};
  }
};

HingeVectors hinge_vectors(const Nodes& x) {
  HingeVectors vectors;
  for (int h = 0; h < hinge_count; ++h) {
    NodesOf<Lanes, 4> nodes;
    for (int k = 0; k < 4; ++k) nodes.col(k) = x.col(hinge_nodes[h][k]);
    vectors[h] = materials::hinge_vectors(nodes);
  }
  return vectors;
}

// The blocks of factor * B^T C B, where B = d theta / d x.
class ElasticBlocks {
 public:
  ElasticBlocks(const BendingBatch& batch, const Slopes& slopes, const Lanes& factor)
      : moduli_{batch.moduli[0].scaled(factor), batch.moduli[1].scaled(factor)}, slopes_(slopes) {
    multiply<0>();
    multiply<1>();
  }

  template <int a, int b>
  Mat3Of<Lanes> block() const {
    Mat3Of<Lanes> sum = Mat3Of<Lanes>::Zero();
    add<0, a, b>(sum);
    add<1, a, b>(sum);
    return sum;
  }

 private:
  template <int t>
  void multiply() {
    const auto of_node = [&]<int a>(std::integral_constant<int, a>) {
      constexpr int node = hinged_triangles[t].nodes[a];
      const Vec3Of<Lanes> g0 = slopes_.of<t, 0, node>(), g1 = slopes_.of<t, 1, node>(),
                          g2 = slopes_.of<t, 2, node>();
      for (int i = 0; i < 3; ++i) {
        const Modulus& modulus = moduli_[t];
        products_[t][i][a] = modulus(i, 0) * g0 + modulus(i, 1) * g1 + modulus(i, 2) * g2;
      }
    };
    of_node(std::integral_constant<int, 0>());
    of_node(std::integral_constant<int, 1>());
    of_node(std::integral_constant<int, 2>());
  }

  // The angle of a triangle's edge depends on the triangle's nodes and on the node across the edge.
  template <int t, int a, int b>
  void add(Mat3Of<Lanes>& sum) const {
    constexpr HingedTriangle triangle = hinged_triangles[t];
    constexpr int own_a = triangle.own(a), own_b = triangle.own(b);
    constexpr int across_a = triangle.across(a), across_b = triangle.across(b);
    const auto& products = products_[t];
    if constexpr (own_a >= 0 && own_b >= 0) {
      sum += materials::outer(slopes_.of<t, 0, a>(), products[0][own_b]);
      sum += materials::outer(slopes_.of<t, 1, a>(), products[1][own_b]);
      sum += materials::outer(slopes_.of<t, 2, a>(), products[2][own_b]);
    } else if constexpr (own_a >= 0 && across_b >= 0) {
      sum += materials::outer(products[across_b][own_a], slopes_.of<t, across_b, b>());
    } else if constexpr (across_a >= 0 && own_b >= 0) {
      sum += materials::outer(slopes_.of<t, across_a, a>(), products[across_a][own_b]);
    } else if constexpr (across_a >= 0 && across_b >= 0) {
      const Vec3Of<Lanes> product = moduli_[t](across_a, across_b) * slopes_.of<t, across_a, a>();
      sum += materials::outer(product, slopes_.of<t, across_b, b>());
    }
  }

  std::array<Modulus, 2> moduli_;
  const Slopes& slopes_;
  Vec3Of<Lanes> products_[2][3][3];  // C d theta / d x: [triangle][hinge][own node]
};

// The blocks of sum_h moment_h d^2 theta_h / dx dx, from the quad's triangles and those beyond its
// sides.
class StressBlocks {
 public:
  StressBlocks(const Nodes& x, const Hinges& moments)
      : parts_{of_own(x, moments, 0),    of_own(x, moments, 1),    of_beyond(x, moments, 1),
               of_beyond(x, moments, 2), of_beyond(x, moments, 3), of_beyond(x, moments, 4)} {}

  template <int a, int b>
  void add(Mat3Of<Lanes>& sum) const {
    add_part<0, a, b>(sum);
    add_part<1, a, b>(sum);
    add_part<2, a, b>(sum);
    add_part<3, a, b>(sum);
    add_part<4, a, b>(sum);
    add_part<5, a, b>(sum);
  }

 private:
  using Stress = materials::HingeStress<Lanes>;

  static constexpr std::array<int, 3> nodes_of(int part) {
    if (part < 2) return hinged_triangles[part].nodes;
    const auto& nodes = hinge_nodes[part - 1];
    return {nodes[1], nodes[0], nodes[3]};
  }
  template <int part, int a, int b>
  void add_part(Mat3Of<Lanes>& sum) const {
    constexpr HingedTriangle triangle{nodes_of(part), {}};
    constexpr int row = triangle.own(a), column = triangle.own(b);
    if constexpr (row >= 0 && column >= 0) sum += parts_[part].block(row, column);
  }

  static NodesOf<Lanes, 3> nodes(const Nodes& x, const std::array<int, 3>& places) {
    NodesOf<Lanes, 3> nodes;
    for (int i = 0; i < 3; ++i) nodes.col(i) = x.col(places[i]);
    return nodes;
  }
  static Stress of_own(const Nodes& x, const Hinges& moments, int t) {
    const HingedTriangle& triangle = hinged_triangles[t];
    Stress stress(nodes(x, triangle.nodes), 0, moments[triangle.hinges[0]]);
    stress.add(1, moments[triangle.hinges[1]]);
    stress.add(2, moments[triangle.hinges[2]]);
    return stress;
  }
  static Stress of_beyond(const Nodes& x, const Hinges& moments, int hinge) {
    return Stress(nodes(x, nodes_of(hinge + 1)), 2, moments[hinge]);
  }

  std::array<Stress, 6> parts_;
};

class BendingForce final : public Force {
 public:
  BendingForce(const BendingQuads& quads, const std::vector<Vec3>& rest)
      : quads_(quads.nodes, static_cast<int>(rest.size())),
        varying_times_(quads.damping_times),
        damping_times_(varying_times_.numbers()),
        is_damped_(quads.is_damped) {
    batches_.resize((quads.nodes.size() + lane_count - 1) / lane_count);
    for (std::size_t q = 0; q < lane_count * batches_.size(); ++q) {
      for (int t = 0; t < 2; ++t) {
        const Mat3 modulus = q < quads.moduli.size() ? quads.moduli[q][t] : Mat3(Mat3::Zero());
        auto& entries = batches_[q / lane_count].moduli[t].entries;
        for (int i = 0; i < 3; ++i) {
          for (int j = i; j < 3; ++j)
            entries[Modulus::index(i, j)].values[q % lane_count] = modulus(i, j);
        }
      }
    }
    // Rest angles are computed by the operations that later compute angles: a body at rest then
    // feels no force at all.
    quads_.for_each_batch(1, [&](int first) {
      BendingBatch& batch = batches_[first / lane_count];
      batch.rest_angles.fill(0);
      batch.rest_angles = batch.strains(hinge_vectors(quads_.gather(first, rest)));
    });
  }

  std::string_view name() const override { return "bending"; }
  bool has_damping() const override { return is_damped_; }
  bool varies() const override { return varying_times_.varies(); }
  void set_time(const Instant& now) override { varying_times_.update(now, damping_times_); }
  double evaluation_work() const override { return 1.2; }

  double energy(const Kinematics& state, int threads) override {
    return parallel_sum(static_cast<int>(batches_.size()), threads, [&](int first, int last) {
      Lanes sum = 0;
      for (int batch = first; batch < last; ++batch)
        sum += batch_energy(lane_count * batch, state.position);
      return materials::sum_of_lanes(sum);
    });
  }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) override {
    quads_.for_each_batch(threads, [&](int first) { add_batch(first, state, force); });
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    quads_.add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) override { quads_.attach(pattern); }

  // K = B^T C B + sum_h moment_h d^2 theta_h / dx dx, the Gauss-Newton part plus the stress part. D
  // = beta B^T C B.
  void add_derivatives(const Kinematics& state, const Derivatives& into, Definiteness definiteness,
                       int threads) override {
    quads_.for_each_batch(
        threads, [&](int first) { add_batch_derivatives(first, state, into, definiteness); });
  }

 private:
  // Returns theta - theta_rest + beta theta', rad.
  Hinges strains(int first, const HingeVectors& hinges, const Slopes& slopes,
                 const Kinematics& state) const {
    Hinges strains = batches_[first / lane_count].strains(hinges);
    if (!is_damped_) return strains;
    const Lanes damping_times = damping_times_.batch(first);
    const Hinges rates = slopes.along(quads_.gather(first, state.velocity));
    for (int h = 0; h < hinge_count; ++h) strains[h] += damping_times * rates[h];
    return strains;
  }

  WEFT_FLATTEN Lanes batch_energy(int first, std::span<const Vec3> position) const {
    const BendingBatch& batch = batches_[first / lane_count];
    return batch.energy(batch.strains(hinge_vectors(quads_.gather(first, position))));
  }
  WEFT_FLATTEN void add_batch(int first, const Kinematics& state, std::span<Vec3> force) const {
    const HingeVectors hinges = hinge_vectors(quads_.gather(first, state.position));
    const Slopes slopes(hinges);
    Hinges pulls = batches_[first / lane_count].moments(strains(first, hinges, slopes, state));
    for (Lanes& pull : pulls) pull = -pull;
    quads_.scatter(first, slopes.times(pulls), force);
  }

  WEFT_FLATTEN void add_batch_derivatives(int first, const Kinematics& state,
                                          const Derivatives& into,
                                          Definiteness definiteness) const {
    const BendingBatch& batch = batches_[first / lane_count];
    const Nodes x = quads_.gather(first, state.position);
    const HingeVectors hinges = hinge_vectors(x);
    const Slopes slopes(hinges);
    const ElasticBlocks elastic(batch, slopes, is_damped_ ? add_damping(first, into, slopes) : 1);
    if (definiteness == Definiteness::semi_definite)
      return add_elastic(first, elastic, into.stiffness);
    Hinges moments = batch.moments(strains(first, hinges, slopes, state));
    for (int h = 0; h < hinge_count; ++h)
      moments[h] = materials::choose(hinges[h].flat_triangle, 0.0, moments[h]);
    const StressBlocks stress(x, moments);
    quads_.scatter_blocks(
        first,
        [&](auto a, auto b) {
          Mat3Of<Lanes> block = elastic.block<a, b>();
          stress.add<a, b>(block);
          return block;
        },
        into.stiffness);
  }

  // Adds D, the elastic blocks times beta, unless it is joined to K. Returns the factor of the
  // elastic blocks in the stiffness.
  Lanes add_damping(int first, const Derivatives& into, const Slopes& slopes) const {
    const Lanes damping_times = damping_times_.batch(first);
    const BendingBatch& batch = batches_[first / lane_count];
    if (!into.is_joined()) {
      add_elastic(first, ElasticBlocks(batch, slopes, damping_times), *into.damping);
      return 1;
    }
    Hinges pulls = batch.moments(slopes.along(quads_.gather(first, into.along)));
    for (Lanes& pull : pulls) pull *= damping_times;
    quads_.scatter(first, slopes.times(pulls), into.product);
    return 1.0 + into.inverse_gamma * damping_times;
  }
  void add_elastic(int first, const ElasticBlocks& elastic, BlockMatrix& matrix) const {
    quads_.scatter_blocks(
        first, [&](auto a, auto b) { return elastic.block<a, b>(); }, matrix);
  }

  StencilArray<QuadSurroundings::count, QuadSurroundings> quads_;
  std::vector<BendingBatch> batches_;
  VaryingNumbers varying_times_;
  StencilNumbers damping_times_;  // s, at the time set
  bool is_damped_ = false;        // at any time
};

// The edges of a triangle that are hinges, and the nodes across them.
struct TriangleHinges {
  std::array<bool, 3> has_angle{};
  std::array<int, 3> across{no_node, no_node, no_node};
};
TriangleHinges hinges_of(const bsi::Mesh& mesh, int triangle) {
  TriangleHinges hinges;
  for (int i = 0; i < 3; ++i) {
    const bsi::Edge& edge = mesh.edges[mesh.triangle_edges[triangle][i]];
    hinges.has_angle[i] = edge.triangle[1] >= 0;
    if (hinges.has_angle[i]) hinges.across[i] = edge.opposite[edge.triangle[0] == triangle ? 1 : 0];
  }
  return hinges;
}

void add_body(const Scene& scene, int index, BendingQuads& quads) {
  const SceneBody& body = scene.bodies[index];
  const MaterialCase& material = *body.material;
  const std::vector<char> at_clamps = triangles_at_clamps(scene, index);
  const bsi::Mesh mesh = bsi::build_mesh(body.atlas);  // the body's own mesh may have no edges
  for (int q = 0; q < quad_count(body); ++q) {
    Surroundings nodes;
    nodes.fill(no_node);
    const Quad corners = quad_corners(body, q);
    for (int i = 0; i < 4; ++i) nodes[quad_corner_nodes[i]] = corners[i];
    auto& moduli = quads.moduli.emplace_back();
    for (int t = 0; t < 2; ++t) {
      const TriangleHinges hinges = hinges_of(mesh, 2 * q + t);
      Nodes3 rest;
      for (int i = 0; i < 3; ++i) {
        const auto& of_hinge = hinge_nodes[hinged_triangles[t].hinges[i]];
        rest.col(i) = body.rest[corners[corners_of[t][i]]];
        if (hinged_triangles[t].hinges[i] != 0) nodes[of_hinge[3]] = hinges.across[i];
      }
      const bool is_at_clamp = !at_clamps.empty() && at_clamps[2 * q + t] != 0;
      moduli[t] = is_at_clamp ? Mat3(Mat3::Zero())
                              : materials::triangle_bending_modulus(rest, hinges.has_angle,
                                                                    material.bending_stiffness,
                                                                    material.poisson_ratio);
    }
    for (int& node : nodes) {
      if (node != no_node) node += body.first_particle;
    }
    quads.nodes.push_back(nodes);
  }
  quads.damping_times.append(quad_count(body), material.bending_damping);
  quads.is_damped |= !material.bending_damping.is_zero();
}

}  // namespace

std::unique_ptr<Force> make_bending_force(const Scene& scene) {
  BendingQuads quads;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    if (scene.bodies[b].material->bending_stiffness > 0) add_body(scene, b, quads);
  }
  if (quads.nodes.empty()) return nullptr;
  return std::make_unique<BendingForce>(quads, rest_positions(scene));
}

}  // namespace weft::sim
