#include "sim/solver/coarse_axis.h"

#include <algorithm>
#include <cmath>

namespace weft::sim {

namespace {

// Largest weight that counts as zero, because rounding may have caused it.
constexpr double no_weight = 1e-12;

}  // namespace

// A basis function spans degree + 1 elements. A closed spline needs that many on every level, so
// twice as many on a level that can be coarsened.
bool CoarseAxis::can_be_coarsened() const {
  const int least = degree > 0 && wraps ? 2 * (degree + 1) : 4;
  return intervals == quads ? quads >= least : intervals % 2 == 0 && intervals >= least;
}

// Returns the axis with about half of the intervals. The first coarser level has 2, 3 or (4 .. 7)
// 2^k intervals, because these numbers can be halved often. Among them, the number with the ratio
// to quads / 2 nearest to one is chosen.
CoarseAxis CoarseAxis::coarser() const {
  CoarseAxis result = *this;
  if (intervals != quads) {
    result.intervals = intervals / 2;
    return result;
  }
  int best = quads >= 5 ? 3 : 2;
  const auto distance = [&](int m) { return std::abs(std::log(0.5 * quads / m)); };
  for (int scale = 1; scale <= quads / 4; scale *= 2) {
    for (int m = 4 * scale; m < 8 * scale; m += scale) {
      if (distance(m) < distance(best)) best = m;
    }
  }
  result.intervals = best;
  return result;
}

// A position halfway between two texels is rounded towards the middle of the axis. An axis and its
// mirror image across a seam then keep the same texels, except for a node in the middle between two
// texels, which is rounded up.
int CoarseAxis::start(int interval) const {
  if (!wraps) interval = std::clamp(interval, 0, intervals);
  const int rounds = interval >= 0 ? interval / intervals : (interval + 1) / intervals - 1;
  const int j = interval - rounds * intervals;
  const auto rounded = [&](int i) {
    return (2 * i * static_cast<long>(quads) + intervals) / (2L * intervals);
  };
  return static_cast<int>(2 * j <= intervals ? rounded(j) : quads - rounded(intervals - j)) +
         rounds * quads;
}

// Returns the position of a node along the axis, in intervals of the finest level. For a control
// point, this is the mean of the `degree` knots within its basis function (Greville abscissa).
double CoarseAxis::centre(int node) const {
  if (degree == 0) return start(node);
  double sum = 0;
  for (int k = 1; k <= degree; ++k) sum += knot(node + k);
  return sum / degree;
}

std::vector<int> CoarseAxis::nearest_nodes(const CoarseAxis& coarse) const {
  const int count = coarse.nodes();
  std::vector<int> nearest(count);
  int next = 0;
  for (int j = 0; j < count; ++j) {
    const auto distance = [&](int i) { return std::abs(centre(i) - coarse.centre(j)); };
    int i = next;
    while (i + 1 < nodes() && distance(i + 1) < distance(i)) ++i;
    nearest[j] = i;
    next = i + 1;
  }
  if (wraps) return nearest;
  for (int j = 0; 2 * j < count - 1; ++j) nearest[count - 1 - j] = nodes() - 1 - nearest[j];
  return nearest;
}

std::vector<std::vector<CoarseAxis::Share>> CoarseAxis::shares(const CoarseAxis& coarse) const {
  std::vector<std::vector<Share>> result(nodes());
  int j = 0;
  for (int i = 0; i < nodes(); ++i) {
    if (degree > 0) {
      result[i] = spline_share(coarse, i);
      continue;
    }
    const int texel = start(i);
    while (j + 1 < coarse.nodes() && coarse.start(j + 1) <= texel) ++j;
    const int before = coarse.start(j);
    // An open axis has no node after its last one.
    const double after =
        texel == before ? 0 : (texel - before) / static_cast<double>(coarse.start(j + 1) - before);
    result[i].push_back({j, 1 - after});
    if (after > 0) result[i].push_back({(j + 1) % coarse.nodes(), after});
  }
  return result;
}

// Knot insertion (Ramshaw 1989, Blossoms are polar forms). Control point i of the finer spline is
// the blossom of the coarse spline at the knots i + 1 .. i + degree, on an interval within the
// basis function of i. Each step of de Boor's algorithm takes one of these knots.
std::vector<CoarseAxis::Share> CoarseAxis::spline_share(const CoarseAxis& coarse, int node) const {
  int element = node - degree / 2;
  if (!wraps) element = std::clamp(element, 0, intervals - 1);
  int within = 0;  // the coarse element that contains the fine one
  if (start(element) >= 0) {
    while (coarse.start(within + 1) <= start(element)) ++within;
  } else {
    while (coarse.start(within) > start(element)) --within;
  }
  const int span = within + degree;
  std::vector<double> weight{1};
  for (int d = 1; d <= degree; ++d) {
    const double at = knot(node + d);
    weight.push_back(0);
    double saved = 0;
    for (int i = 0; i < d; ++i) {
      const double right = coarse.knot(span + i + 1) - at;
      const double left = at - coarse.knot(span + 1 - d + i);
      const double share = weight[i] / (right + left);
      weight[i] = saved + right * share;
      saved = left * share;
    }
    weight[d] = saved;
  }
  std::vector<Share> result;
  for (int i = 0; i <= degree; ++i) {
    if (std::abs(weight[i]) < no_weight) continue;
    const int count = coarse.nodes();
    result.push_back({((within + i) % count + count) % count, weight[i]});
  }
  return result;
}

}  // namespace weft::sim
