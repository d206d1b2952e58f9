#include "bench/approach.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "bsi/narrow_phase.h"
#include "bsi/traversal.h"

namespace weft::bench {

namespace {

using bsi::Vec3;
using Matrix3 = Eigen::Matrix3d;
constexpr double pi = std::numbers::pi;

// Returns the distance of a point from the core circle of the resting torus.
double distance_from_core(const Vec3& p) {
  return std::hypot(std::hypot(p.x(), p.y()) - torus_major, p.z());
}

// Returns the least value of `f` on [low, high], which must contain a single minimum, by golden
// section.
template <class Function>
double least_value(const Function& f, double low, double high) {
  const double ratio = std::numbers::phi - 1;
  for (int i = 0; i < 60; ++i) {
    const double a = high - ratio * (high - low), b = low + ratio * (high - low);
    if (f(a) < f(b)) {
      high = b;
    } else {
      low = a;
    }
  }
  return f(0.5 * (low + high));
}

// Returns the largest s in [near_side, far_side] with touches(s), to within `accuracy`.
// Precondition: touches(near_side) and not touches(far_side).
template <class Test>
double last_touch(const Test& touches, double near_side, double far_side, double accuracy) {
  while (far_side - near_side > accuracy) {
    const double middle = 0.5 * (near_side + far_side);
    (touches(middle) ? near_side : far_side) = middle;
  }
  return near_side;
}

// Returns direction `i` of `count` spread evenly: a Fibonacci lattice on the sphere.
Vec3 direction_of(int i, int count) {
  const double z = 1 - (2 * i + 1.0) / count, angle = 2 * pi * i / std::numbers::phi;
  const double radius = std::sqrt(1 - z * z);
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

double longest_edge(const Body& body) {
  double longest = 0;
  for (const auto& t : body.triangles) {
    for (int k : {0, 2}) {  // not the diagonals
      longest = std::max(longest, (body.start[t[k]] - body.start[t[(k + 1) % 3]]).norm());
    }
  }
  return longest;
}

// A torus at rest and one that moves.
class MovingTori {
 public:
  explicit MovingTori(const Body& torus)
      : rest_(torus), moved_(torus.start), of_rest_(torus.atlas), of_moved_(torus.atlas) {
    static_cast<void>(of_rest_.rebuild(rest_.start, 1));
  }

  // Returns the number of pairs of triangles that meet if the second torus is rotated and shifted.
  long hits(const Matrix3& turn, const Vec3& shift) {
    for (std::size_t i = 0; i < moved_.size(); ++i) moved_[i] = turn * rest_.start[i] + shift;
    static_cast<void>(of_moved_.rebuild(moved_, 1));
    candidates_.clear();
    bsi::TraversalCounters traversal;
    bsi::dual_traversal(of_rest_, of_moved_, {.margin = 0, .threads = 1}, candidates_, traversal);
    bsi::TriangleHits found;
    bsi::NarrowPhaseCounters narrow;
    bsi::find_triangle_hits({rest_.start, rest_.triangles}, {moved_, rest_.triangles}, candidates_,
                            {.margin = 0, .distances = false, .threads = 1}, found, narrow);
    return static_cast<long>(found.pairs.size());
  }

 private:
  const Body& rest_;
  std::vector<Vec3> moved_;
  bsi::Pyramid of_rest_, of_moved_;
  std::vector<bsi::LeafPair> candidates_;
};

// Returns the first s at which `touches` holds, searched from `far` in steps and then by bisection;
// negative if there is none.
template <class Test>
double first_touch(const Test& touches, double far, double step, double accuracy) {
  double s = far;
  while (s > 0) {
    const double next = std::max(0.0, s - step);
    if (touches(next)) return last_touch(touches, next, s, accuracy);
    s = next;
  }
  return -1;
}

Approach approach_from(const Vec3& direction, const Matrix3& turn, double leaf, MovingTori& tori) {
  Approach approach;
  approach.direction = direction;
  approach.leaf = leaf;
  const double far = 2 * (torus_major + torus_minor) + leaf;
  const auto meets = [&](double s) {
    ++approach.steps;
    const long hits = tori.hits(turn, s * direction);
    if (hits > 0) approach.hits = hits;
    return hits > 0;
  };
  approach.found = first_touch(meets, far, 0.25 * leaf, 1e-6);
  approach.expected = first_touch(
      [&](double s) { return torus_distance(turn, s * direction) <= 0; }, far, 1e-3, 1e-12);
  approach.touched = approach.found >= 0;
  return approach;
}

}  // namespace

double torus_distance(const Matrix3& turn, const Vec3& shift) {
  const auto at = [&](double angle) {
    const Vec3 core(torus_major * std::cos(angle), torus_major * std::sin(angle), 0);
    return distance_from_core(turn * core + shift);
  };
  // The minima are far wider than these intervals.
  constexpr int intervals = 90;
  std::array<double, intervals> sample{};
  for (int i = 0; i < intervals; ++i) sample[i] = at(2 * pi * i / intervals);
  double least = sample[0];
  for (int i = 0; i < intervals; ++i) {
    const double before = sample[(i + intervals - 1) % intervals];
    const double after = sample[(i + 1) % intervals];
    if (sample[i] > before || sample[i] > after) continue;
    least = std::min(least,
                     least_value(at, 2 * pi * (i - 1) / intervals, 2 * pi * (i + 1) / intervals));
  }
  return least - 2 * torus_minor;
}

std::vector<Approach> approach_from_all_sides(const Body& torus, int directions) {
  MovingTori tori(torus);
  const double leaf = longest_edge(torus);
  std::vector<Approach> approaches;
  for (int i = 0; i < directions; ++i) {
    const Matrix3 turn(
        Eigen::AngleAxisd(2.4 * i, direction_of((7 * i + 3) % directions, directions)));
    approaches.push_back(approach_from(direction_of(i, directions), turn, leaf, tori));
  }
  return approaches;
}

}  // namespace weft::bench
