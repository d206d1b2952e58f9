// The example of docs/bsi.md: finds where a cloth that another program holds comes near itself.
#include <cmath>
#include <iostream>
#include <numbers>
#include <stdexcept>
#include <string>

#include "bsi/narrow_phase.h"
#include "bsi/traversal.h"

// Prints the pairs of triangles without a common vertex that are within `margin` of each other.
// `cloth` holds x, y, z of rows * cols vertices, row by row; u runs along the columns. Metres.
void print_self_contact(const double* cloth, int rows, int cols, bool wrap_u, bool wrap_v,
                        double margin) {
  using namespace weft::bsi;
  static_assert(sizeof(Vec3) == 3 * sizeof(double));  // The cloth is read where it lies.
  const std::span positions(reinterpret_cast<const Vec3*>(cloth), std::size_t(rows) * cols);
  const Atlas atlas({{rows, cols, wrap_u, wrap_v}});
  const Mesh mesh = build_mesh(atlas);
  Pyramid pyramid(atlas);  // A simulation keeps these three and rebuilds the pyramid at each step.
  if (pyramid.rebuild(positions)) throw std::domain_error("a position is not finite");
  TraversalCounters tests;
  std::vector<LeafPair> candidates;
  self_traversal(pyramid, {.margin = margin}, candidates, tests);
  NarrowPhaseCounters work;
  TriangleHits hits;
  const TriangleSet set{positions, mesh.triangles};
  find_triangle_hits(set, set, candidates, {.margin = margin, .distances = true}, hits, work);
  for (std::size_t i = 0; i < hits.pairs.size(); ++i) {
    std::cout << hits.pairs[i].a << ' ' << hits.pairs[i].b << ' ' << hits.distances[i] << '\n';
  }
  std::cout << candidates.size() << " candidates, " << hits.pairs.size() << " hits\n";
}

// A sheet in a spiral of three turns whose layers are 1 mm apart; the argument is the margin.
int main(int, char** arguments) {
  std::vector<double> cloth;
  for (int i = 0; i < 5 * 97; ++i) {
    const double turns = (i % 97) / 32.0, angle = 2 * std::numbers::pi * turns;
    const double radius = 0.02 + 0.001 * turns;
    cloth.insert(cloth.end(), {radius * cos(angle), radius * sin(angle), 0.005 * (i / 97)});
  }
  print_self_contact(cloth.data(), 5, 97, false, false, std::stod(arguments[1]));
}
