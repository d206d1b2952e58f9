#include "bsi/continuous_collision.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace weft::bsi {

namespace {

constexpr int most_queries = 512;
// A path that is not proved safe is cut where the gap has fallen to this fraction of the starting
// gap.
constexpr double left_part = 0.1;
// Each advance along the path stops where the projected gap has fallen to this fraction of the gap
// at the start of the advance. Once the place of the cut is known, only a proof is sought: advances
// then go as far as the projection allows, which takes the fewest queries.
constexpr double aimed_part = 0.05;
// The search for a proof stops where the gap has fallen to this fraction of the starting gap.
constexpr double hopeless_part = 1e-12;
// Upper bound of the rounding error of a projected gap, as a fraction of `size` in
// relative_motion(). The gap is a sum of a dozen terms, none larger than `size`.
constexpr double rounding_part = 16 * std::numeric_limits<double>::epsilon();
// Pairs that are larger (m), or whose features are closer at the start, have no proof: products of
// lengths could overflow or underflow.
constexpr double largest_size = 1e75, smallest_distance = 1e-75;

// The pair of features in the frame of its first point, which rests at the origin. Motion common to
// all points then takes no queries. `size` (m) is the sum of the lengths of the pair and of its
// paths; `rounding` (m) bounds the rounding error of a gap.
struct Motion {
  std::array<Vec3, 4> position;
  std::array<Vec3, 4> displacement;
  double size = 0, rounding = 0;
};

Motion relative_motion(const FourPoints& start, const FourPoints& end) {
  Motion motion;
  const Vec3 first_displacement = end[0] - start[0];
  motion.size = first_displacement.lpNorm<1>();
  motion.position[0] = motion.displacement[0] = Vec3::Zero();
  for (int i = 1; i < 4; ++i) {
    const Vec3 displacement = end[i] - start[i];
    motion.position[i] = start[i] - start[0];
    motion.displacement[i] = displacement - first_displacement;
    // A sum propagates NaN; a maximum would drop it.
    motion.size += displacement.lpNorm<1>() + motion.position[i].lpNorm<1>();
  }
  motion.rounding = rounding_part * motion.size;
  return motion;
}

// The projections (shadows) of both features on the line along `direction`. Positions, speeds and
// gaps are multiplied by the length of `direction`. The first `first_count` points (1 or 2) belong
// to the first feature, the others to the second. The gap is the smallest difference between a
// point of the first feature and a point of the second. Each difference is linear in time.
template <int first_count>
struct Shadows {
  std::array<double, 4> place, speed;

  Shadows(const std::array<Vec3, 4>& position, const Motion& motion, const Vec3& direction) {
    for (int i = 0; i < 4; ++i) {
      place[i] = direction.dot(position[i]);
      speed[i] = direction.dot(motion.displacement[i]);
    }
  }

  // Returns the gap after another fraction `part` of the path.
  double gap_after(double part) const {
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < first_count; ++i)
      for (int j = first_count; j < 4; ++j)
        least = std::min(least, place[i] - place[j] + part * (speed[i] - speed[j]));
    return least;
  }

  // Returns the fraction of the path after which the gap has fallen to `aim`, or infinity if it
  // never does.
  double advance_to(double aim) const {
    double advance = std::numeric_limits<double>::infinity();
    for (int i = 0; i < first_count; ++i) {
      for (int j = first_count; j < 4; ++j) {
        const double rate = speed[i] - speed[j];
        if (rate < 0) advance = std::min(advance, (aim - (place[i] - place[j])) / rate);
      }
    }
    return advance;
  }
};

template <int first_count>
double safe_fraction(const FourPoints& start, const FourPoints& end, double minimum_separation) {
  assert(minimum_separation >= 0);
  constexpr auto closest = first_count == 1 ? closest_vertex_triangle : closest_edge_edge;
  const Motion motion = relative_motion(start, end);
  const double least = minimum_separation + motion.rounding;
  if (!(motion.size < largest_size)) return 0;  // also if the size is NaN
  std::array<Vec3, 4> position = motion.position;
  double fraction = 0, starting_gap = 0, left_at = -1;
  for (int query = 0; query < most_queries; ++query) {
    const Vec3 separation = closest(position[0], position[1], position[2], position[3]).separation;
    const double distance = separation.norm();
    // The proof is the gap between the shadows alone. A separation that rounding has turned away
    // from the closest points makes the gap smaller and proves no less.
    const Shadows<first_count> shadows(position, motion, separation);
    const double scaled_gap = shadows.gap_after(0) - least * distance;
    if (query == 0) {
      if (!(scaled_gap > 0 && distance > smallest_distance)) return 0;
      starting_gap = scaled_gap / distance;
    }
    if (scaled_gap > 0 && shadows.gap_after(1 - fraction) > least * distance) return 1;
    if (left_at < 0 && scaled_gap <= left_part * starting_gap * distance) left_at = fraction;
    if (!(scaled_gap > hopeless_part * starting_gap * distance)) break;
    const double aim = left_at < 0 ? aimed_part * scaled_gap : 0;
    const double advance = shadows.advance_to(least * distance + aim);
    if (!(advance > 0)) break;
    fraction += advance;
    if (fraction >= 1) return 1;
    for (int i = 1; i < 4; ++i)
      position[i] = motion.position[i] + fraction * motion.displacement[i];
  }
  return left_at < 0 ? fraction : left_at;
}

}  // namespace

double safe_fraction_vertex_triangle(const FourPoints& start, const FourPoints& end,
                                     double minimum_separation) {
  return safe_fraction<1>(start, end, minimum_separation);
}

double safe_fraction_edge_edge(const FourPoints& start, const FourPoints& end,
                               double minimum_separation) {
  return safe_fraction<2>(start, end, minimum_separation);
}

}  // namespace weft::bsi
