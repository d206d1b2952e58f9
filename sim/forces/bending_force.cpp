#include "materials/bending.h"

#include "sim/base/parallel.h"
#include "sim/forces/force_arrays.h"
#include "sim/forces/force_group.h"
#include "sim/forces/quad_hinges.h"
#include "sim/forces/quads.h"
#include "sim/forces/stencil_array.h"
#include "sim/forces/varying_numbers.h"
#include "sim/scene/cloth_laws.h"

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

using Modulus = materials::Symmetric3Of<Lanes>;  // of a triangle, over its hinges

struct BendingQuads {
  std::vector<Surroundings> nodes;
  // The modulus of each triangle over its hinges or, where it depends on the curvature, its map
  // from the angles to the curvature.
  std::vector<std::array<Mat3, 2>> moduli;
  std::vector<std::array<materials::StrainMapOf<double>, 2>> maps;
  VaryingNumbers damping_times;  // s
  bool is_damped = false;        // at any time
};

using Slopes = QuadSlopes<Lanes>;
using Nodes = Slopes::Nodes;
using Hinges = Slopes::Hinges;  // one number per hinge
using HingeVectors = std::array<materials::HingeVectorsOf<Lanes>, hinge_count>;

// The numbers of the hinges of triangle t, and the sum over both triangles back to the hinges.
Vec3Of<Lanes> of_triangle(const Hinges& numbers, int t) {
  const auto& hinges = hinged_triangles[t].hinges;
  return {numbers[hinges[0]], numbers[hinges[1]], numbers[hinges[2]]};
}
template <class OfTriangle>
Hinges sum_of_triangles(const OfTriangle& of_one) {
  Hinges sum;
  sum.fill(0);
  for (int t = 0; t < 2; ++t) {
    const Vec3Of<Lanes> own = of_one(t);
    for (int i = 0; i < 3; ++i) sum[hinged_triangles[t].hinges[i]] += own[i];
  }
  return sum;
}

// A batch of quads whose moments are linear in the strains, the changes of the angles (rad). The
// energy W is that of the quad's own triangles; those beyond its sides add their own share of the
// sides' moments.
struct LinearBending {
  std::array<Modulus, 2> own;
  Hinges rest_angles;

  // Returns dW/d theta (N m) with damping, at strains and their rates.
  Hinges moments(const Hinges& strains, const Lanes& damping_time, const Hinges& rates) const {
    Hinges sum = strains;
    for (int h = 0; h < hinge_count; ++h) sum[h] += damping_time * rates[h];
    return moments(sum);
  }
  Hinges moments(const Hinges& strains) const {
    return sum_of_triangles([&](int t) { return own[t] * of_triangle(strains, t); });
  }
  Lanes energy(const Hinges& strains) const {
    Lanes sum = 0;
    for (int t = 0; t < 2; ++t) {
      const Vec3Of<Lanes> angles = of_triangle(strains, t);
      sum += 0.5 * materials::dot(angles, own[t] * angles);
    }
    return sum;
  }
  // Returns the moduli of damping of each triangle.
  const std::array<Modulus, 2>& viscosities(const Hinges& /*strains*/) const { return own; }
  // Returns d^2 W/d theta d theta, or a semi-definite part, plus the viscosities times the damping
  // time over gamma.
  std::array<Modulus, 2> joined(const Hinges& /*strains*/, Definiteness /*kind*/,
                                double inverse_gamma, const Lanes& damping_time) const {
    const Lanes factor = 1.0 + inverse_gamma * damping_time;
    return {own[0].scaled(factor), own[1].scaled(factor)};
  }
};

// A batch of quads whose stiffness depends on the curvature (materials/curved_bending.h).
struct CurvedBendingBatch {
  std::shared_ptr<const materials::CurvedBending> law;  // of all batches
  std::array<materials::StrainMapOf<Lanes>, 2> maps;
  Hinges rest_angles;

  Hinges moments(const Hinges& strains, const Lanes& damping_time, const Hinges& rates) const {
    const std::array<Modulus, 2> damping = viscosities(strains);
    return sum_of_triangles([&](int t) -> Vec3Of<Lanes> {
      return materials::law_slope(maps[t], *law, of_triangle(strains, t)) +
             damping_time * (damping[t] * of_triangle(rates, t));
    });
  }
  Hinges moments(const Hinges& strains) const {
    return sum_of_triangles(
        [&](int t) { return materials::law_slope(maps[t], *law, of_triangle(strains, t)); });
  }
  Lanes energy(const Hinges& strains) const {
    return materials::law_energy(maps[0], *law, of_triangle(strains, 0)) +
           materials::law_energy(maps[1], *law, of_triangle(strains, 1));
  }
  std::array<Modulus, 2> viscosities(const Hinges& strains) const {
    return {materials::law_viscosity(maps[0], *law, of_triangle(strains, 0)),
            materials::law_viscosity(maps[1], *law, of_triangle(strains, 1))};
  }
  std::array<Modulus, 2> joined(const Hinges& strains, Definiteness kind, double inverse_gamma,
                                const Lanes& damping_time) const {
    std::array<Modulus, 2> sum = viscosities(strains);
    for (int t = 0; t < 2; ++t) {
      const Modulus damping = sum[t].scaled(inverse_gamma * damping_time);
      if (kind == Definiteness::exact)
        sum[t] = materials::law_tangent(maps[t], *law, of_triangle(strains, t), false);
      sum[t] += damping;
    }
    return sum;
  }
};

// Returns theta - theta_rest of a batch.
template <class Batch>
Hinges strains_of(const Batch& batch, const HingeVectors& hinges) {
  Hinges strains;
  for (int h = 0; h < hinge_count; ++h)
    strains[h] = materials::hinge_angle(hinges[h]) - batch.rest_angles[h];
  return strains;
}

HingeVectors hinge_vectors(const Nodes& x) {
  HingeVectors vectors;
  for (int h = 0; h < hinge_count; ++h) {
    NodesOf<Lanes, 4> nodes;
    for (int k = 0; k < 4; ++k) nodes.col(k) = x.col(hinge_nodes[h][k]);
    vectors[h] = materials::hinge_vectors(nodes);
  }
  return vectors;
}

// The blocks of B^T C B, where B = d theta / d x.
class ElasticBlocks {
 public:
  ElasticBlocks(const std::array<Modulus, 2>& moduli, const Slopes& slopes)
      : moduli_(moduli), slopes_(slopes) {
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

// Makes the batches of quads, without their rest angles. Lanes beyond the last quad have no
// stiffness.
std::vector<LinearBending> linear_batches(const BendingQuads& quads) {
  std::vector<LinearBending> batches((quads.nodes.size() + lane_count - 1) / lane_count);
  for (std::size_t q = 0; q < lane_count * batches.size(); ++q) {
    for (int t = 0; t < 2; ++t) {
      const Mat3 modulus = q < quads.moduli.size() ? quads.moduli[q][t] : Mat3(Mat3::Zero());
      Modulus& own = batches[q / lane_count].own[t];
      for (int i = 0; i < 3; ++i) {
        for (int j = i; j < 3; ++j) own(i, j).values[q % lane_count] = modulus(i, j);
      }
    }
  }
  return batches;
}
std::vector<CurvedBendingBatch> curved_batches(const BendingQuads& quads,
                                               materials::CurvedBending law) {
  std::vector<CurvedBendingBatch> batches((quads.nodes.size() + lane_count - 1) / lane_count);
  const auto shared = std::make_shared<const materials::CurvedBending>(std::move(law));
  for (CurvedBendingBatch& batch : batches) batch.law = shared;
  for (std::size_t q = 0; q < quads.maps.size(); ++q) {
    for (int t = 0; t < 2; ++t) {
      materials::StrainMapOf<Lanes>& map = batches[q / lane_count].maps[t];
      for (int i = 0; i < 9; ++i)
        map.map.data()[i].values[q % lane_count] = quads.maps[q][t].map.data()[i];
      map.area.values[q % lane_count] = quads.maps[q][t].area;
    }
  }
  return batches;
}

template <class Batch>
class BendingForce final : public Force {
 public:
  BendingForce(const BendingQuads& quads, std::vector<Batch> batches, const std::vector<Vec3>& rest)
      : quads_(quads.nodes, static_cast<int>(rest.size())),
        batches_(std::move(batches)),
        varying_times_(quads.damping_times),
        damping_times_(varying_times_.numbers()),
        is_damped_(quads.is_damped) {
    // Rest angles are computed by the operations that later compute angles: a body at rest then
    // feels no force at all.
    quads_.for_each_batch(1, [&](int first) {
      Batch& batch = batches_[first / lane_count];
      batch.rest_angles.fill(0);
      batch.rest_angles = strains_of(batch, hinge_vectors(quads_.gather(first, rest)));
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
  // Returns dW/d theta with damping, at given strains.
  Hinges moments(int first, const Hinges& strains, const Slopes& slopes,
                 const Kinematics& state) const {
    const Batch& batch = batches_[first / lane_count];
    if (!is_damped_) return batch.moments(strains);
    return batch.moments(strains, damping_times_.batch(first),
                         slopes.along(quads_.gather(first, state.velocity)));
  }

  WEFT_FLATTEN Lanes batch_energy(int first, std::span<const Vec3> position) const {
    const Batch& batch = batches_[first / lane_count];
    return batch.energy(strains_of(batch, hinge_vectors(quads_.gather(first, position))));
  }
  WEFT_FLATTEN void add_batch(int first, const Kinematics& state, std::span<Vec3> force) const {
    const HingeVectors hinges = hinge_vectors(quads_.gather(first, state.position));
    const Slopes slopes(hinges);
    Hinges pulls = moments(first, strains_of(batches_[first / lane_count], hinges), slopes, state);
    for (Lanes& pull : pulls) pull = -pull;
    quads_.scatter(first, slopes.times(pulls), force);
  }

  WEFT_FLATTEN void add_batch_derivatives(int first, const Kinematics& state,
                                          const Derivatives& into,
                                          Definiteness definiteness) const {
    const Batch& batch = batches_[first / lane_count];
    const Nodes x = quads_.gather(first, state.position);
    const HingeVectors hinges = hinge_vectors(x);
    const Slopes slopes(hinges);
    const Hinges strains = strains_of(batch, hinges);
    if (is_damped_) add_damping(first, into, slopes, strains);
    const ElasticBlocks elastic(
        batch.joined(strains, definiteness, into.inverse_gamma,
                     is_damped_ ? Lanes(damping_times_.batch(first)) : Lanes(0)),
        slopes);
    if (definiteness == Definiteness::semi_definite)
      return add_elastic(first, elastic, into.stiffness);
    Hinges stress = moments(first, strains, slopes, state);
    for (int h = 0; h < hinge_count; ++h)
      stress[h] = materials::choose(hinges[h].flat_triangle, 0.0, stress[h]);
    const StressBlocks stress_blocks(x, stress);
    quads_.scatter_blocks(
        first,
        [&](auto a, auto b) {
          Mat3Of<Lanes> block = elastic.block<a, b>();
          stress_blocks.add<a, b>(block);
          return block;
        },
        into.stiffness);
  }

  // Adds D or, if it is joined to K, its product.
  void add_damping(int first, const Derivatives& into, const Slopes& slopes,
                   const Hinges& strains) const {
    const Lanes damping_times = damping_times_.batch(first);
    std::array<Modulus, 2> viscosities = batches_[first / lane_count].viscosities(strains);
    if (!into.is_joined()) {
      for (Modulus& each : viscosities) each = each.scaled(damping_times);
      return add_elastic(first, ElasticBlocks(viscosities, slopes), *into.damping);
    }
    const Hinges rates = slopes.along(quads_.gather(first, into.along));
    Hinges pulls = sum_of_triangles([&](int t) { return viscosities[t] * of_triangle(rates, t); });
    for (Lanes& pull : pulls) pull *= damping_times;
    quads_.scatter(first, slopes.times(pulls), into.product);
  }
  void add_elastic(int first, const ElasticBlocks& elastic, BlockMatrix& matrix) const {
    quads_.scatter_blocks(
        first, [&](auto a, auto b) { return elastic.block<a, b>(); }, matrix);
  }

  StencilArray<QuadSurroundings::count, QuadSurroundings> quads_;
  std::vector<Batch> batches_;
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

// The law of a triangle over the angles of its hinges: its modulus, or its map to the curvature.
void add_triangle(const SceneBody& body, int triangle, const Nodes3& rest,
                  const std::array<bool, 3>& has_angle, bool is_held, BendingQuads& quads) {
  const MaterialCase& material = *body.material;
  const int t = triangle % 2;
  if (is_held) return;  // by a clamp, which bends it
  if (!material.orthotropic_bending) {
    quads.moduli.back()[t] = materials::triangle_bending_modulus(
        rest, has_angle, material.bending_stiffness, material.poisson_ratio);
    return;
  }
  const Vec3 warp = warp_direction(body, triangle);
  const materials::OrthotropicModuli moduli = flat_bending_moduli(material);
  if (material.orthotropic_bending->warp.size() == 1) {
    quads.moduli.back()[t] = materials::triangle_bending_modulus(rest, warp, has_angle, moduli);
  } else {
    quads.maps.back()[t] = materials::bending_map(rest, warp, has_angle, moduli);
  }
}

void add_body(const Scene& scene, int index, BendingQuads& quads) {
  const SceneBody& body = scene.bodies[index];
  const std::vector<char> at_clamps = triangles_at_clamps(scene, index);
  const bsi::Mesh mesh = bsi::build_mesh(body.atlas);  // the body's own mesh may have no edges
  for (int q = 0; q < quad_count(body); ++q) {
    Surroundings nodes;
    nodes.fill(no_node);
    const Quad corners = quad_corners(body, q);
    for (int i = 0; i < 4; ++i) nodes[quad_corner_nodes[i]] = corners[i];
    quads.moduli.push_back({Mat3::Zero(), Mat3::Zero()});
    quads.maps.emplace_back();
    for (int t = 0; t < 2; ++t) {
      const TriangleHinges hinges = hinges_of(mesh, 2 * q + t);
      Nodes3 rest;
      for (int i = 0; i < 3; ++i) {
        const auto& of_hinge = hinge_nodes[hinged_triangles[t].hinges[i]];
        rest.col(i) = body.rest[corners[corners_of[t][i]]];
        if (hinged_triangles[t].hinges[i] != 0) nodes[of_hinge[3]] = hinges.across[i];
      }
      const bool is_at_clamp = !at_clamps.empty() && at_clamps[2 * q + t] != 0;
      add_triangle(body, 2 * q + t, rest, hinges.has_angle, is_at_clamp, quads);
    }
    for (int& node : nodes) {
      if (node != no_node) node += body.first_particle;
    }
    quads.nodes.push_back(nodes);
  }
  quads.damping_times.append(quad_count(body), body.material->bending_damping);
  quads.is_damped |= !body.material->bending_damping.is_zero();
}

// Collects the quads of the bodies whose materials are selected.
template <class Selects>
BendingQuads quads_that(const Scene& scene, const Selects& selects) {
  BendingQuads quads;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const MaterialCase& material = *scene.bodies[b].material;
    if (!material.is_shell() && material.resists_bending() && selects(material))
      add_body(scene, b, quads);
  }
  return quads;
}

bool is_curved(const MaterialCase& material) {
  return material.orthotropic_bending && material.orthotropic_bending->warp.size() > 1;
}

// Returns null where no body is made of the material.
std::unique_ptr<Force> make_curved(const Scene& scene, const MaterialCase& material) {
  const BendingQuads quads =
      quads_that(scene, [&](const MaterialCase& each) { return each.name == material.name; });
  if (quads.nodes.empty()) return nullptr;
  return std::make_unique<BendingForce<CurvedBendingBatch>>(
      quads, curved_batches(quads, std::get<materials::CurvedBending>(*bending_law(material))),
      rest_positions(scene));
}

}  // namespace

std::unique_ptr<Force> make_bending_force(const Scene& scene) {
  std::vector<std::unique_ptr<Force>> members;
  const BendingQuads linear =
      quads_that(scene, [](const MaterialCase& material) { return !is_curved(material); });
  if (!linear.nodes.empty())
    members.push_back(std::make_unique<BendingForce<LinearBending>>(linear, linear_batches(linear),
                                                                    rest_positions(scene)));
  for (const MaterialCase& material : scene.source.material) {
    if (is_curved(material)) members.push_back(make_curved(scene, material));
  }
  return grouped(std::move(members));
}

}  // namespace weft::sim
