// Fold watch: against the distances of all pairs of features of the quads that it covers, along
// paths of surfaces that bend, crumple and unfold again.
#include "bsi/detail/fold_watch.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <random>

#include "bsi/proximity.h"

namespace weft::bsi::fold_watch_test {
namespace {

using Positions = std::vector<Vec3>;

constexpr double spacing = 0.01;  // m, of the texels
constexpr FoldWatch::Reach reach{.vertices = 0.45 * spacing, .edges = 0.3 * spacing};

// A surface, the state of a watch over it, and the oracle.
class Watched {
 public:
  Watched(Atlas image, const Positions& rest, double neighbour_radius,
          const FoldWatch::Reach& within, double largest_room = spacing)
      : atlas_(std::move(image)), mesh_(build_mesh(atlas_)), reach_(within) {
    if (neighbour_radius > 0) neighbourhoods_.emplace(mesh_, rest, neighbour_radius);
    watch_.emplace(atlas_, mesh_, neighbourhoods_ ? &*neighbourhoods_ : nullptr, reach_,
                   largest_room);
    marks_.assign(atlas_.particle_count(), 0);
  }

  // Follows the paths, closes what it can, and checks that nothing covered is within reach.
  void follow(const Positions& start, const Positions& end, double stray) {
    std::fill(marks_.begin(), marks_.end(), 0);
    const int before = watch_->closed_count();
    const bool opens = watch_->follow({start, end}, stray, marks_, 2);
    EXPECT_EQ(opens, watch_->closed_count() < before);
    EXPECT_EQ(opens, std::ranges::count(marks_, 1) > 0);
    opened_ += before - watch_->closed_count();
    check(start, end, stray);
    const int left = watch_->closed_count();
    watch_->close({start, end}, stray, 0.05 * spacing, 2);
    EXPECT_GE(watch_->closed_count(), left);
    closed_ += watch_->closed_count() - left;
    check(start, end, stray);
  }
  void follow(const Positions& now) { follow(now, now, 0); }

  const FoldWatch& watch() const { return *watch_; }
  int opened() const { return opened_; }
  int closed() const { return closed_; }
  int within_reach() const { return within_reach_; }

 private:
  void check(const Positions& start, const Positions& end, double stray) {
    const int quads = atlas_.quad_count();
    for (int a = 0; a < quads; ++a) {
      for (int b = a; b < quads; ++b) {
        if (share_vertex(a, b)) {
          check_pair(a, b, start, end, stray);
        } else {
          EXPECT_FALSE(watch_->covers(a, b) || watch_->covers(b, a)) << a << " " << b;
        }
      }
    }
  }

  bool share_vertex(int a, int b) const {
    const auto one = atlas_.quad_particles(a), other = atlas_.quad_particles(b);
    return std::ranges::find_first_of(one, other) != one.end();
  }

  void check_pair(int a, int b, const Positions& start, const Positions& end, double stray) {
    const bool covered = watch_->covers(a, b);
    EXPECT_EQ(covered, watch_->covers(b, a));
    for (const double time : {0.0, 0.3, 0.7, 1.0}) {
      const auto at = [&](int i) { return Vec3((1 - time) * start[i] + time * end[i]); };
      const double room = least_room(a, b, at);
      if (covered) {
        EXPECT_GE(room, stray - 1e-12) << a << " " << b;
      }
      if (room < 0) ++within_reach_;
    }
  }

  // Returns the least distance of two features of two quads without a common vertex, less their
  // reach.
  template <class At>
  double least_room(int a, int b, const At& at) const {
    double least = 1;
    const auto note = [&](const Closest& closest, bool near, double within) {
      least = std::min(least, std::sqrt(closest.squared_distance) - (near ? 0 : within));
    };
    for (const auto& [one, other] : {std::pair(a, b), std::pair(b, a)}) {
      for (const int v : atlas_.quad_particles(one)) {
        for (const int t : {2 * other, 2 * other + 1}) {
          const auto [i, j, k] = mesh_.triangles[t];
          if (v == i || v == j || v == k) continue;
          note(closest_vertex_triangle(at(v), at(i), at(j), at(k)),
               neighbourhoods_ && neighbourhoods_->contains(v, t), reach_.vertices);
        }
      }
    }
    for (const Edge* e : edges_of(a)) {
      for (const Edge* f : edges_of(b)) {
        const auto [i, j] = e->vertex;
        const auto [k, l] = f->vertex;
        if (i == k || i == l || j == k || j == l) continue;
        note(closest_edge_edge(at(i), at(j), at(k), at(l)),
             neighbourhoods_ && neighbourhoods_->are_neighbours(*e, *f), reach_.edges);
      }
    }
    return least;
  }

  std::vector<const Edge*> edges_of(int quad) const {
    std::vector<const Edge*> edges;
    for (const int t : {2 * quad, 2 * quad + 1})
      for (const int e : mesh_.triangle_edges[t]) edges.push_back(&mesh_.edges[e]);
    return edges;
  }

  Atlas atlas_;
  Mesh mesh_;
  FoldWatch::Reach reach_;
  std::optional<Neighbourhoods> neighbourhoods_;
  std::optional<FoldWatch> watch_;
  std::vector<char> marks_;
  int opened_ = 0, closed_ = 0, within_reach_ = 0;
};

// Returns positions by texel, for u and v in spacings.
Positions placed(int rows, int cols, const std::function<Vec3(int, int)>& place) {
  Positions x;
  for (int row = 0; row < rows; ++row)
    for (int col = 0; col < cols; ++col) x.push_back(place(row, col));
  return x;
}

// A sheet whose columns form waves, whose edges turn by 1.05 `height` (rad) at most, far from
// the origin. Rows turn by `turn` (rad) about the z axis in all.
Positions waves(int rows, int cols, double height, double turn) {
  return placed(rows, cols, [&](int row, int col) {
    // An arc whose slope varies: no edge changes its length.
    Vec3 x = Vec3(40, -30, 7);
    for (int c = 0; c < col; ++c) {
      const double slope = height * std::sin(1.1 * c + 0.5);
      x += spacing * Vec3(std::cos(slope), 0, std::sin(slope));
    }
    x.y() += spacing * row;
    const Vec3 arm = x - Vec3(40, -30, 7);
    return Vec3(Vec3(40, -30, 7) + Eigen::AngleAxisd(turn, Vec3::UnitZ()) * arm);
  });
}

TEST(FoldWatch, CoversNothingWithinReachOnWavesThatRiseAndFall) {
  Watched sheet(Atlas({Patch{.rows = 5, .cols = 9}}), waves(5, 9, 0, 0), 0, reach);
  const auto at = [](int k) {
    return waves(5, 9, 2.75 * std::sin(std::numbers::pi * k / 40), 0.01 * k);
  };
  sheet.follow(at(0));
  EXPECT_EQ(sheet.watch().closed_count(), sheet.watch().window_count());
  for (int k = 1; k <= 40; ++k) {
    sheet.follow(at(k));
    sheet.follow(at(k), at(k % 5 == 0 ? k + 3 : k + 1), k % 3 == 0 ? 0.02 * spacing : 0);
  }
  EXPECT_EQ(sheet.watch().window_count(), 3 * 7);
  EXPECT_GT(sheet.opened(), 10);
  EXPECT_GT(sheet.closed(), sheet.watch().window_count() + 10);
  EXPECT_GT(sheet.within_reach(), 100);
}

// Wide images are handled in blocks of texels and windows, which end in the midst of rows.
TEST(FoldWatch, CoversNothingWithinReachAnywhereOnWideSheets) {
  for (const int cols : {17, 18, 19, 34, 36, 51}) {
    const Positions flat = waves(4, cols, 0, 0);
    Watched sheet(Atlas({Patch{.rows = 4, .cols = cols}}), flat, 0, reach);
    sheet.follow(flat);
    EXPECT_EQ(sheet.watch().closed_count(), 2 * (cols - 2));
    // A narrow fold goes through the sheet, from its last columns to its first ones.
    for (int fold = cols - 2; fold > 0; --fold) {
      const auto at = [&](double angle) {
        return placed(4, cols, [&](int row, int col) {
          const double beyond = spacing * (col - fold);
          const Vec3 x(spacing * fold, spacing * row, 0);
          if (beyond <= 0) return Vec3(x + beyond * Vec3::UnitX());
          return Vec3(x + beyond * Vec3(std::cos(angle), 0, std::sin(angle)));
        });
      };
      sheet.follow(at(0), at(2.9), 0);
      EXPECT_LT(sheet.watch().closed_count(), 2 * (cols - 2)) << fold;
      sheet.follow(at(2.9), at(0), 0);
      sheet.follow(flat);
      EXPECT_EQ(sheet.watch().closed_count(), 2 * (cols - 2)) << fold;
    }
    EXPECT_GT(sheet.within_reach(), cols);
  }
}

// Vertices of a flat sheet move within it, along the diagonals of quads: those across from a
// diagonal come within reach of it, although windows are close to linear images of the grid.
TEST(FoldWatch, CoversNothingWithinReachWhereASheetIsSquashedInItsPlane) {
  std::mt19937 random(5);
  int within_reach = 0, closed = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const double shear = trial % 4 == 1 ? 0.2 : 0,
                 largest = spacing * (trial % 3 == 0 ? 0.06 : 0.135);
    std::uniform_int_distribution sign(-1, 1);
    const Vec3 along = Vec3(1, trial % 2 == 0 ? 1 : -1, 0).normalized();
    const Positions x = placed(6, 6, [&](int row, int col) {
      const Vec3 linear(spacing * (col + shear * row), spacing * row, 0);
      // In every second pair of trials, one vertex approaches the ends of a diagonal, which
      // approach it.
      const int from_middle = row == 2 && col == 2                         ? 1
                              : std::abs(row - 2) + std::abs(col - 2) == 1 ? -1
                                                                           : 0;
      return Vec3(linear + largest * (trial % 4 < 2 ? sign(random) : from_middle) * along);
    });
    Watched sheet(Atlas({Patch{.rows = 6, .cols = 6}}), x, 0, reach, 0.1 * spacing);
    sheet.follow(x);
    within_reach += sheet.within_reach();
    closed += sheet.closed();
  }
  EXPECT_GT(within_reach, 100);
  EXPECT_GT(closed, 100);
}

// One corner of the sheet folds over and back.
TEST(FoldWatch, OpensWhereACornerFolds) {
  const auto at = [](double angle) {
    return placed(7, 7, [&](int row, int col) {
      const double beyond = (row + col - 9) * spacing * std::numbers::sqrt2 / 2;
      Vec3 x(spacing * col, spacing * row, 0);
      if (beyond <= 0) return x;
      const Vec3 across = Vec3(1, 1, 0).normalized();
      return Vec3(x - beyond * across +
                  beyond * (std::cos(angle) * across + std::sin(angle) * Vec3::UnitZ()));
    });
  };
  Watched sheet(Atlas({Patch{.rows = 7, .cols = 7}}), at(0), 0, reach);
  sheet.follow(at(0));
  for (const double angle : {0.5, 1.0, 1.5, 2.0, 2.3, 2.6, 2.9}) sheet.follow(at(angle));
  // The fold runs along a diagonal of the image: only windows on it and beside it open.
  EXPECT_GE(sheet.opened(), 3);
  EXPECT_LE(sheet.opened(), 9);
  EXPECT_GT(sheet.within_reach(), 0);
  for (const double angle : {2.0, 1.0, 0.0}) sheet.follow(at(angle));
  EXPECT_EQ(sheet.watch().closed_count(), sheet.watch().window_count());
}

// A path from a flat sheet to a flat sheet, through one that is pressed flat in itself: every edge
// of a column turns round.
TEST(FoldWatch, OpensForPathsThroughFoldsBetweenFlatEnds) {
  const Positions flat = waves(4, 4, 0, 0), turned = waves(4, 4, 0, std::numbers::pi);
  Watched sheet(Atlas({Patch{.rows = 4, .cols = 4}}), flat, 0, reach);
  sheet.follow(flat);
  sheet.follow(flat, turned, 0);
  EXPECT_EQ(sheet.watch().closed_count(), 0);
  sheet.follow(turned);
  EXPECT_EQ(sheet.watch().closed_count(), sheet.watch().window_count());
}

// On a fine mesh, neighbours at rest are within the reach of others.
TEST(FoldWatch, LetsNeighboursComeCloseButNotMeet) {
  constexpr FoldWatch::Reach far{.vertices = 1.5 * spacing, .edges = 1.2 * spacing};
  const auto at = [](int k) { return waves(5, 8, 2.9 * std::sin(std::numbers::pi * k / 40), 0); };
  Watched sheet(Atlas({Patch{.rows = 5, .cols = 8}}), at(0), 1.8 * spacing, far);
  sheet.follow(at(0));
  EXPECT_EQ(sheet.watch().closed_count(), sheet.watch().window_count());
  for (int k = 0; k < 40; ++k) sheet.follow(at(k), at(k + 1), 0);
  EXPECT_GT(sheet.opened(), 3);
  EXPECT_GT(sheet.closed(), sheet.watch().window_count());
}

// Windows extend across the border of a wrapped axis. Two borders that are sewn have none between.
TEST(FoldWatch, HasWindowsAcrossWrappedBordersAndNotAcrossSeams) {
  const auto tube = [](int columns, double radius) {
    return [=](int row, int col) {
      const double angle = 2 * std::numbers::pi * col / columns;
      return Vec3(radius * std::cos(angle), radius * std::sin(angle), spacing * row);
    };
  };
  const double radius = 8 * spacing / (2 * std::numbers::pi);
  const Positions round = placed(5, 8, tube(8, radius));
  Watched wrapped(Atlas({Patch{.rows = 5, .cols = 8, .wrap_u = true}}), round, 0, reach);
  wrapped.follow(round);
  EXPECT_EQ(wrapped.watch().window_count(), 3 * 8);
  EXPECT_EQ(wrapped.watch().closed_count(), 3 * 8);
  EXPECT_TRUE(wrapped.watch().covers(0, 7));
  Positions pressed = round;
  for (Vec3& p : pressed) p.x() *= 0.05;
  wrapped.follow(round, pressed, 0);
  EXPECT_LT(wrapped.watch().closed_count(), 3 * 8);

  std::vector<int> sewn;  // the last column is the first one
  for (int row = 0; row < 5; ++row)
    for (int col = 0; col < 9; ++col) sewn.push_back(row * 8 + col % 8);
  Watched seam(Atlas({Patch{.rows = 5, .cols = 9}}, sewn), round, 0, reach);
  seam.follow(round);
  EXPECT_EQ(seam.watch().window_count(), 3 * 7);
  EXPECT_EQ(seam.watch().closed_count(), 3 * 7);
  EXPECT_FALSE(seam.watch().covers(0, 7));
}

// Each vertex in turn comes close to one beside it, on its own.
TEST(FoldWatch, CoversNothingWithinReachOfSingleVertices) {
  constexpr int rows = 4, cols = 19;
  const Positions flat = waves(rows, cols, 0, 0);
  Watched sheet(Atlas({Patch{.rows = rows, .cols = cols}}), flat, 0, reach);
  sheet.follow(flat);
  for (int i = 0; i < rows * cols; ++i) {
    Positions moved = flat;
    const double to_inside = i % cols == cols - 1 ? -1 : 1;
    moved[i] += 0.9 * spacing * Vec3(to_inside, i / cols == rows - 1 ? -1 : 1, 0);
    const int before = sheet.within_reach();
    sheet.follow(flat, moved, 0);
    EXPECT_LT(sheet.watch().closed_count(), sheet.watch().window_count()) << i;
    EXPECT_GT(sheet.within_reach(), before) << i;
    sheet.follow(flat);
    EXPECT_EQ(sheet.watch().closed_count(), sheet.watch().window_count()) << i;
  }
}

// A dent goes round a tube, across the border of its image.
TEST(FoldWatch, CoversNothingWithinReachAnywhereOnWideTubes) {
  constexpr int rows = 5, cols = 22;
  const double radius = cols * spacing / (2 * std::numbers::pi);
  const auto dented = [&](int at, double depth) {
    return placed(rows, cols, [&](int row, int col) {
      const int from = std::min((col - at + cols) % cols, (at - col + cols) % cols);
      const double angle = 2 * std::numbers::pi * col / cols;
      const double r = radius - depth * std::max(0.0, 1 - from / 2.0);
      return Vec3(r * std::cos(angle), r * std::sin(angle), spacing * row);
    });
  };
  const Positions round = dented(0, 0);
  Watched tube(Atlas({Patch{.rows = rows, .cols = cols, .wrap_u = true}}), round, 0, reach);
  tube.follow(round);
  EXPECT_EQ(tube.watch().closed_count(), 3 * cols);
  for (int col = 0; col < cols; ++col) {
    tube.follow(round, dented(col, 6 * spacing), 0);
    EXPECT_LT(tube.watch().closed_count(), 3 * cols) << col;
    tube.follow(round);
    EXPECT_EQ(tube.watch().closed_count(), 3 * cols) << col;
  }
  EXPECT_GT(tube.within_reach(), cols);
}

// Motion is measured in float32, from the first particle. The room of windows half a kilometre away
// is known to a millimetre only.
TEST(FoldWatch, CountsTheRoundingOfDistantPositions) {
  const Positions near = waves(4, 20, 0, 0);
  Positions flat = near;
  for (const Vec3& p : near) flat.push_back(p + Vec3(500, 0, 0));
  for (const Vec3& p : near) flat.push_back(p + Vec3(0, 1, 0));
  const Patch patch{.rows = 4, .cols = 20};
  const double room = std::sqrt(0.5) * spacing - reach.vertices;
  for (const double left : {2e-3, 7e-4}) {
    Watched sheets(Atlas({patch, patch, patch}), flat, 0, reach);
    sheets.follow(flat, flat, room - left);
    EXPECT_EQ(sheets.watch().closed_count(), left > 1e-3 ? 3 * 2 * 18 : 0) << left;
  }
}

// The diagonals of a flat sheet are sqrt(1/2) spacings from the vertices beside them.
TEST(FoldWatch, OpensWherePathsAreLessWellKnown) {
  const Positions flat = waves(4, 4, 0, 0);
  Watched sheet(Atlas({Patch{.rows = 4, .cols = 4}}), flat, 0, reach);
  const double room = std::sqrt(0.5) * spacing - reach.vertices;
  sheet.follow(flat, flat, 0.7 * room);
  EXPECT_EQ(sheet.watch().closed_count(), sheet.watch().window_count());
  sheet.follow(flat, flat, 1.1 * room);
  EXPECT_EQ(sheet.watch().closed_count(), 0);
}

// A single row of quads has no inner texels.
TEST(FoldWatch, HasNoWindowsOnAStrip) {
  const Positions strip = waves(2, 9, 1.4, 0);
  Watched watched(Atlas({Patch{.rows = 2, .cols = 9}}), strip, 0, reach);
  watched.follow(strip);
  EXPECT_EQ(watched.watch().window_count(), 0);
}

}  // namespace
}  // namespace weft::bsi::fold_watch_test
