// Checks whether paths of the surfaces meet, and whether states have gaps.
#include <algorithm>
#include <cmath>
#include <limits>

#include "bsi/continuous_collision.h"
#include "sim/base/parallel.h"
#include "sim/contact/surface_contact.h"
#include "sim/contact/surface_features.h"

namespace weft::sim {

namespace {

// Returns the thickness (m) of a shell beside a sphere, or 0 for other pairs of bodies.
double shell_beside_sphere(const SceneBody& one, const SceneBody& other) {
  if (one.spheres != nullptr && other.spline) return other.thickness;
  if (other.spheres != nullptr && one.spline) return one.thickness;
  return 0;
}

}  // namespace

// Returns an upper bound of the stray of both features together, m. A point of a feature is a
// convex combination of the feature's corners, so it strays no more than the corner that strays
// most.
double SurfaceContact::stray_of(const Pair& pair, const PointStray& stray) const {
  double side[2] = {0, 0};
  const int split = pair.edges ? 2 : 1;
  for (int i = 0; i < 4; ++i) {
    double& largest = side[i < split ? 0 : 1];
    const int node = pair.nodes[i];
    largest = std::max(largest, is_dynamic(node) ? stray.point[node]
                                                 : stray.body[scene_.body_index_of_point(node)]);
  }
  return side[0] + side[1];
}

// Returns the distance (m) that features must keep on a path. It is half the thickness, so that a
// path is refused only if it comes clearly closer than its end. Spheres keep nearly all of theirs.
double SurfaceContact::path_distance(const PairGroup& group) const {
  const double half = 0.5 * group.thickness;
  return group.has_spheres() ? std::max(half, group.thickness - short_range * range_) : half;
}

std::optional<ContactFault> SurfaceContact::check_path(const PlacedPoints& start,
                                                       const PlacedPoints& end,
                                                       const PointStray& stray,
                                                       const CurveStray& curve) {
  return find_path_fault(start, end, {.gap = true, .stray = stray, .curve = curve});
}

std::optional<ContactFault> SurfaceContact::check_crossing(const PlacedPoints& start,
                                                           const PlacedPoints& end,
                                                           const CurveStray& curve) {
  return find_path_fault(start, end, {.gap = false, .stray = {}, .curve = curve});
}

std::optional<ContactFault> SurfaceContact::find_path_fault(const PlacedPoints& start,
                                                            const PlacedPoints& end,
                                                            const PathDemand& demand) {
  open_.clear();
  std::span<const double> reach = demand.stray.body;
  if (!demand.curve.body.empty()) {
    body_reach_.assign(demand.curve.body.begin(), demand.curve.body.end());
    for (std::size_t b = 0; b < reach.size(); ++b) body_reach_[b] += reach[b];
    reach = body_reach_;
  }
  if (const auto bad = search_.update_path(start, end, reach)) {
    return ContactFault{ContactFault::Kind::not_finite, {*bad}};
  }
  PhaseTimer timer(statistics_.phases.narrow_phase);
  begin_placing();
  std::vector<const PairGroup*> groups = groups_within(0, 0, on_path_);
  const std::vector<PairGroup> near = neighbours();
  for (const PairGroup& group : near) groups.push_back(&group);
  for (const PairGroup* each : groups) {
    const PairGroup& group = *each;
    place_nodes(group, start, end);
    const int count = static_cast<int>(group.nodes.size());
    statistics_.counters.narrow_phase_calls += count;
    statistics_.counters.ccd_calls += count;
    struct Checked {
      std::optional<ContactFault> fault;
      std::vector<OpenPair> open;
    };
    const auto check = [&](int first, int last, Checked& part) {
      part.fault =
          check_part(group, first, last, start.position(), end.position(), demand, part.open);
    };
    const auto parts = parallel_parts<Checked>(count, scene_.threads, check);
    for (const Checked& part : parts)
      if (part.fault) return part.fault;
    for (const Checked& part : parts) open_.insert(open_.end(), part.open.begin(), part.open.end());
  }
  return std::nullopt;
}

// Returns the first fault of the pairs first .. last - 1. A cheap test finds most pairs free of
// faults.
std::optional<ContactFault> SurfaceContact::check_part(
    const PairGroup& group, std::size_t first, std::size_t last, std::span<const Vec3> start,
    std::span<const Vec3> end, const PathDemand& demand, std::vector<OpenPair>& open) const {
  // If a gap is demanded, the end must keep the whole thickness.
  const double kept = demand.gap ? path_distance(group) : 0.0;
  const PointStray& stray = demand.stray;
  // The strays of a shell leave out what its thickness covers. Beside a sphere, paths do not keep
  // it.
  const double shell = demand.curve.body.empty() ? 0
                                                 : shell_beside_sphere(scene_.bodies[group.body_a],
                                                                       scene_.bodies[group.body_b]);
  const double uncovered =
      shell > 0 ? demand.curve.covered * shell + (demand.gap ? group.thickness - kept : 0) : 0;
  // The cheap test uses the largest strays of both bodies. The stray of a single pair may be
  // smaller.
  double largest = kept + uncovered;
  for (const std::span<const double> by_body : {stray.body, demand.curve.body}) {
    if (!by_body.empty()) largest += by_body[group.body_a] + by_body[group.body_b];
  }
  std::vector<int> unproved;
  bsi::find_unproved_paths(group.kind(), start, end,
                           std::span(group.nodes).subspan(first, last - first), largest,
                           demand.gap ? std::max(group.thickness, largest) : largest, unproved);
  for (int i : unproved) {
    const Pair pair = group.pair(first + i);
    const bsi::Closest at_end = closest_of(pair.edges, pair.nodes, end);
    const double gap = std::sqrt(at_end.squared_distance) - pair.thickness;
    if (demand.gap && !(gap > 0)) {
      return ContactFault{ContactFault::Kind::touching, pair.nodes, gap};
    }
    double separation = kept;
    if (!stray.body.empty()) separation += stray_of(pair, stray);
    const double curve = demand.curve.body.empty() ? 0 : stray_of(pair, demand.curve) + uncovered;
    bsi::FourPoints from, to;
    for (int k = 0; k < 4; ++k) {
      from[k] = start[pair.nodes[k]];
      to[k] = end[pair.nodes[k]];
    }
    const auto is_safe = [&](double apart) {
      return (pair.edges ? bsi::safe_fraction_edge_edge(from, to, apart)
                         : bsi::safe_fraction_vertex_triangle(from, to, apart)) >= 1;
    };
    if (is_safe(separation + curve)) continue;
    if (curve == 0 || !is_safe(separation))
      return ContactFault{ContactFault::Kind::crossing, pair.nodes, gap};
    const double left_by =
        uncovered > 0 ? curve : curve + 2 * demand.curve.covered * group.thickness;
    open.push_back({pair.nodes, pair.edges ? 2 : 1, left_by});
  }
  return std::nullopt;
}

std::optional<ContactFault> SurfaceContact::check_state(std::span<const Vec3> position,
                                                        double* smallest_gap) {
  if (const auto bad = search_.update(position))
    return ContactFault{ContactFault::Kind::not_finite, {*bad}};
  *smallest_gap = std::numeric_limits<double>::infinity();
  std::optional<ContactFault> fault;
  KeptGroups kept;
  for (const PairGroup* each : groups_within(range_, range_, kept)) {
    const PairGroup& group = *each;
    for (std::size_t i = 0; i < group.nodes.size(); ++i) {
      const Pair pair = group.pair(i);
      const double gap =
          std::sqrt(closest_of(pair.edges, pair.nodes, position).squared_distance) - pair.thickness;
      if (gap < *smallest_gap) *smallest_gap = gap;
      if (!(gap > 0) && !fault) fault = ContactFault{ContactFault::Kind::touching, pair.nodes, gap};
    }
  }
  if (fault) return fault;
  for (const PairGroup& group : neighbours()) {
    for (std::size_t i = 0; i < group.nodes.size(); ++i) {
      const Pair pair = group.pair(i);
      if (!(closest_of(pair.edges, pair.nodes, position).squared_distance > 0))
        return ContactFault{ContactFault::Kind::touching, pair.nodes, 0};
    }
  }
  return std::nullopt;
}

}  // namespace weft::sim
