#include "sim/forces/quad_bending.h"

namespace weft::sim {

namespace {

using materials::Lanes;
using materials::Mat3Of;
using materials::NodesOf;
using materials::Vec3Of;
using Hinges = QuadBending::Hinges;
using Modulus = QuadBending::Modulus;
using Nodes = QuadBending::Nodes;
using Slopes = QuadBending::Slopes;

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

  // Adds the part of triangle t to the block of nodes a and b. The angle of an edge of the triangle
  // depends on the nodes of the triangle and on the node across the edge.
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
  Vec3Of<Lanes> products_[2][3][3];  // C d theta / d x, by triangle, hinge and node
};

// The blocks of sum_h moment_h d^2 theta_h / dx dx. They are sums over six triangles: the two of
// the quad and the four beyond its sides.
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

}  // namespace

QuadBending::QuadBending(const BendingQuads& quads, int particle_count)
    : quads_(quads.nodes, particle_count),
      varying_times_(quads.damping_times),
      damping_times_(varying_times_.numbers()),
      is_damped_(quads.is_damped) {}

WEFT_FLATTEN void QuadBending::add_elastic(int first, const std::array<Modulus, 2>& moduli,
                                           const Slopes& slopes, const BlockTarget& into) const {
  const ElasticBlocks elastic(moduli, slopes);
  quads_.scatter_blocks(
      first, [&](auto a, auto b) { return elastic.block<a, b>(); }, into);
}

WEFT_FLATTEN void QuadBending::add_stressed(int first, const std::array<Modulus, 2>& moduli,
                                            const Slopes& slopes, const Nodes& x,
                                            const Hinges& moments, BlockMatrix& matrix) const {
  const ElasticBlocks elastic(moduli, slopes);
  const StressBlocks stress(x, moments);
  quads_.scatter_blocks(first,
                        [&](auto a, auto b) {
                          Mat3Of<Lanes> block = elastic.block<a, b>();
                          stress.add<a, b>(block);
                          return block;
                        },
                        {matrix});
}

void QuadBending::add_damping(int first, const std::array<Modulus, 2>& viscosities,
                              const Slopes& slopes, const Derivatives& into) const {
  const Lanes damping_times = damping_times_.batch(first);
  if (!into.is_joined()) {
    return add_elastic(first,
                       {viscosities[0].scaled(damping_times), viscosities[1].scaled(damping_times)},
                       slopes, {*into.damping});
  }
  const Hinges rates = slopes.along(quads_.gather(first, into.along));
  Hinges pulls = sum_of_triangles([&](int t) { return viscosities[t] * of_triangle(rates, t); });
  for (Lanes& pull : pulls) pull *= damping_times;
  quads_.scatter(first, slopes.times(pulls), into.product);
}

}  // namespace weft::sim
