// Disc and cone, made of 12 patches. In a single square image, the corners would be flattened to
// 180 degrees on the rim. With 12 patches, three patches meet at each corner of an inner square, at
// angles between 105 and 150 degrees. All patches have the same number of vertices, and their cells
// have similar sizes.
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "bsi/detail/sewn_patches.h"
#include "bsi/shapes.h"

namespace weft::bsi {

namespace {

constexpr double quarter_turn = std::numbers::pi / 4;  // half the angle that a side spans

// Distance of the square's corners from the centre of the unit disc. With this distance and
// roundness, the smallest angle on fine images is about 31.5 degrees, near the largest possible.
constexpr double corner_distance = 0.52;
// Roundness of the square's sides: 0 for straight lines, 1 for circular arcs.
constexpr double roundness = 0.7;

// The vertices of the disc on a lattice of quads. The square covers |i|, |j| <= n. The ring around
// it is n quads wide. Label {i, j, k} is point (i, j) of the square if k = 0. Otherwise (i, j) is
// on the square's border, and the label is the point k quads outside it on the ray from the centre.
struct DiscLattice {
  int n = 0;

  // Returns the label of point (i, j) of the square or of its border.
  static Label in_square(int i, int j) { return {i, j, 0}; }

  // Returns the label of a point of the ring. Its border point is `around` quads counter-clockwise
  // from the corner (n, -n). The point is `across` quads outside the border.
  Label in_ring(int around, int across) const {
    const int along = around % (2 * n) - n;
    switch (around / (2 * n) % 4) {
      case 0:
        return {n, along, across};
      case 1:
        return {-along, n, across};
      case 2:
        return {-n, -along, across};
      default:
        return {along, -n, across};
    }
  }

  std::vector<Label> labels() const;
  Vec3 position(const Label& label) const;
};

// Returns the labels of all texels, patch by patch. The image of each quarter of the square is
// rotated so that the diagonals of its quads run outwards from the centre. One of them splits the
// angle at the square's corner.
std::vector<Label> DiscLattice::labels() const {
  std::vector<Label> result;
  for (int quarter = 0; quarter < 4; ++quarter) {
    for (int row = 0; row <= n; ++row) {
      for (int col = 0; col <= n; ++col) {
        int i = n - row, j = col;
        for (int turn = 0; turn < quarter; ++turn) {
          const int old = i;
          i = -j;
          j = old;
        }
        result.push_back(in_square(i, j));
      }
    }
  }
  for (int patch = 0; patch < 8; ++patch) {
    for (int row = 0; row <= n; ++row) {
      for (int col = 0; col <= n; ++col) result.push_back(in_ring(patch * n + col, n - row));
    }
  }
  return result;
}

// Returns the point of the square's right side on the ray at the angle s * 45 degrees, for s in -1
// .. 1.
Vec3 side_point(double s) {
  const double angle = s * quarter_turn;
  const double straight = 1 / (std::numbers::sqrt2 * std::cos(angle));
  const double distance = corner_distance * (straight + roundness * (1 - straight));
  return {distance * std::cos(angle), distance * std::sin(angle), 0};
}

// Returns the position of a label in the unit disc. The square is the Coons patch of its four
// sides.
Vec3 DiscLattice::position(const Label& label) const {
  const double s = static_cast<double>(label[0]) / n;
  const double t = static_cast<double>(label[1]) / n;
  const Vec3 at_s = side_point(s), at_t = side_point(t);
  const double corner = corner_distance / std::numbers::sqrt2;
  Vec3 inner(s * (at_t.x() - corner) + at_s.y(), t * (at_s.x() - corner) + at_t.y(), 0);
  if (label[2] == 0) return inner;
  const double outside = static_cast<double>(label[2]) / n;
  return (1 - outside) * inner + outside * inner.normalized();
}

// Makes a surface from the disc's patches of n x n vertices. position(p) returns the position (m)
// of the vertex at point p of the unit disc.
template <typename Position>
Surface make_from_disc(int n, Position position) {
  if (n < 2) throw std::invalid_argument("an open axis needs at least 2 vertices");
  const DiscLattice lattice{n - 1};
  return make_sewn(std::vector<Patch>(12, Patch{n, n}), lattice.labels(),
                   [&](const Label& label) -> Vec3 { return position(lattice.position(label)); });
}

}  // namespace

Surface make_disc(double radius, int n) {
  check_size("the disc's radius", radius);
  return make_from_disc(n, [radius](const Vec3& p) -> Vec3 { return radius * p; });
}

Surface make_cone(double radius, double length, int n) {
  check_size("the cone's radius", radius);
  check_size("the cone's length", length);
  return make_from_disc(n, [=](const Vec3& p) -> Vec3 {
    return {radius * p.x(), radius * p.y(), length * (0.5 - p.norm())};
  });
}

}  // namespace weft::bsi
