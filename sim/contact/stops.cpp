// Stops of long steps: dampers on pairs of features that would meet.
#include <algorithm>
#include <cmath>
#include <utility>

#include "bsi/continuous_collision.h"
#include "sim/contact/contact.h"

namespace weft::sim {

namespace {

// A pair that would end with a smaller part of its range meets, too, if it approaches by more than
// its room: its barrier would store more energy than the pair had. A stop would pull at a slower
// pair, the harder the shorter the step.
constexpr double smallest_end = 0.2;

// Room left to a pair at the end of the step: this part of the range, or this part of its gap at
// the start if that is less.
constexpr double part_of_range = 0.5, part_of_gap = 0.8;

// The direction of a stop is taken at this fraction of the path up to the meeting, where the
// features are still apart.
constexpr double before_meeting = 0.95;

// Stiffness of a stop relative to that of its pair in the matrix of the step. The approach that a
// stop allows is exceeded by about the inverse.
constexpr double relative_stiffness = 100;

}  // namespace

// Returns the meeting of a pair, or nothing if the pair stays apart by `separation` (m) and ends
// with a sufficient gap, or approaches by no more than the room that a stop would leave it.
std::optional<Meeting> SurfaceContact::meeting_of(const Pair& pair, double range, double separation,
                                                  std::span<const Vec3> start,
                                                  std::span<const Vec3> end) const {
  bsi::FourPoints from, to;
  for (int k = 0; k < 4; ++k) {
    from[k] = start[pair.nodes[k]];
    to[k] = end[pair.nodes[k]];
  }
  const auto closest_at = [&](double fraction) {
    bsi::FourPoints x;
    for (int k = 0; k < 4; ++k) x[k] = from[k] + fraction * (to[k] - from[k]);
    return pair.edges ? bsi::closest_edge_edge(x[0], x[1], x[2], x[3])
                      : bsi::closest_vertex_triangle(x[0], x[1], x[2], x[3]);
  };
  const double fraction = pair.edges ? bsi::safe_fraction_edge_edge(from, to, separation)
                                     : bsi::safe_fraction_vertex_triangle(from, to, separation);
  bsi::Closest closest = closest_at(fraction < 1 ? before_meeting * fraction : 1);
  const double end_gap = std::sqrt(closest.squared_distance) - pair.thickness;
  if (fraction >= 1 && end_gap > smallest_end * range) return std::nullopt;
  if (!(closest.squared_distance > 0)) closest = closest_at(0);
  Meeting meeting;
  meeting.fraction = fraction;
  meeting.gap = end_gap;
  meeting.pair.nodes = pair.nodes;
  meeting.pair.weight = closest.weight;
  meeting.pair.normal = closest.separation / std::sqrt(closest.squared_distance);
  Vec3 apart = Vec3::Zero();
  for (int k = 0; k < 4; ++k) apart += closest.weight[k] * from[k];
  const double gap = std::max(meeting.pair.normal.dot(apart) - pair.thickness, 0.0);
  meeting.pair.gap = gap;
  meeting.room = gap - std::min(part_of_range * range, part_of_gap * gap);
  double change = 0;
  for (int k = 0; k < 4; ++k)
    change += meeting.pair.weight[k] * meeting.pair.normal.dot(to[k] - from[k]);
  if (fraction >= 1 && change > -meeting.room) return std::nullopt;
  return meeting;
}

std::optional<ContactFault> SurfaceContact::find_meetings(const PlacedPoints& start,
                                                          const PlacedPoints& end,
                                                          const PointStray& stray,
                                                          std::vector<Meeting>& meetings) {
  if (const auto bad = search_.update_path(start, end, stray.body))
    return ContactFault{ContactFault::Kind::not_finite, {*bad}};
  PhaseTimer timer(statistics_.phases.narrow_phase);
  begin_placing();
  const double least_gap = smallest_end * range_;
  KeptGroups kept;
  for (const PairGroup* each : groups_within(least_gap, short_range * least_gap, kept)) {
    const PairGroup& group = *each;
    place_nodes(group, start, end);
    statistics_.counters.narrow_phase_calls += static_cast<std::int64_t>(group.nodes.size());
    statistics_.counters.ccd_calls += static_cast<std::int64_t>(group.nodes.size());
    const double range = range_of(group), half = 0.5 * group.thickness;
    double largest = half;
    if (!stray.body.empty()) largest += stray.body[group.body_a] + stray.body[group.body_b];
    std::vector<int> unproved;
    bsi::find_unproved_paths(group.kind(), start.position(), end.position(), group.nodes, largest,
                             std::max(group.thickness + smallest_end * range, largest), unproved);
    for (const int i : unproved) {
      const Pair pair = group.pair(i);
      if (const auto meeting =
              meeting_of(pair, range, half + (stray.body.empty() ? 0 : stray_of(pair, stray)),
                         start.position(), end.position()))
        meetings.push_back(*meeting);
    }
  }
  return std::nullopt;
}

// Returns the slope (m/s) of the distance of a pair along its normal, as far as free particles
// change it.
double Contact::closing_rate(const ContactPair& pair, std::span<const Vec3> velocity) const {
  double rate = 0;
  StencilRoom room;
  const Stencil of = stencil(pair, room);
  for (std::size_t i = 0; i < of.particles.size(); ++i) {
    const int particle = of.particles[i];
    if (is_dynamic(particle) && scene_.pinned[particle] == 0)
      rate += of.weights[i] * pair.normal.dot(velocity[particle]);
  }
  return rate;
}

// Returns the damping (N s/m) of a stop, from the inertia of its pair in the matrix of the step.
double Contact::stop_damping(const ContactPair& pair, double gamma,
                             std::span<const Mat3> diagonal) const {
  double mobility = 0;
  StencilRoom room;
  const Stencil of = stencil(pair, room);
  for (std::size_t i = 0; i < of.particles.size(); ++i) {
    const int particle = of.particles[i];
    if (!is_dynamic(particle) || scene_.pinned[particle] != 0) continue;
    mobility += of.weights[i] * of.weights[i] *
                pair.normal.dot(diagonal[particle].ldlt().solve(pair.normal));
  }
  return mobility > 0 ? relative_stiffness / (mobility * gamma) : 0;
}

// Returns the dynamic point of a pair that has the largest weight.
int Contact::heaviest_point(const ContactPair& pair) const {
  int heaviest = -1;
  double most = -1;
  for (int k = 0; k < 4; ++k) {
    const double weight = std::abs(pair.weight[k]);
    if (pair.nodes[k] >= scene_.dynamic_points || weight <= most) continue;
    heaviest = pair.nodes[k];
    most = weight;
  }
  return heaviest;
}

std::optional<ContactFault> Contact::add_stops(const StepPath& path, double gamma,
                                               std::span<const Vec3> velocity,
                                               std::span<const Mat3> diagonal, int* added) {
  *added = 0;
  const PlacedPoints from = on_surface(path.start, start_), to = on_surface(path.end, end_);
  std::vector<Meeting> meetings;
  if (auto fault = surface_.find_meetings(from, to, on_surface(path.stray), meetings))
    return on_particles(fault, path.end.position);
  if (meetings.empty()) return std::nullopt;
  std::erase_if(stops_, [&](const Stop& stop) {
    return closing_rate(stop.pair, velocity) > stop.allowed + 1e-12;
  });
  // The deepest of the pairs that end in their barriers shows the direction best: a sphere comes
  // near the triangles beside the one below it, too.
  std::ranges::stable_sort(meetings, {}, [](const Meeting& meeting) {
    return std::pair(meeting.fraction, meeting.gap);
  });
  std::vector<char> has_new_stop(scene_.dynamic_points, 0);
  for (const Meeting& meeting : meetings) {
    char& is_taken = has_new_stop[heaviest_point(meeting.pair)];
    if (is_taken != 0) continue;
    is_taken = 1;
    const auto is_same = [&](const Stop& stop) { return stop.pair.nodes == meeting.pair.nodes; };
    const auto known = std::ranges::find_if(stops_, is_same);
    Stop stop{meeting.pair, 0};
    stop.pair.damping = stop_damping(stop.pair, gamma, diagonal);
    if (stop.pair.damping == 0) continue;
    // Prescribed points use up a part of the room, or add to it.
    double room = meeting.room;
    for (int i = 0; i < 4; ++i) {
      const int node = stop.pair.nodes[i];
      const bool is_prescribed = node >= scene_.dynamic_points ||
                                 (scene_.surface_map.is_identity() && scene_.pinned[node] != 0);
      if (is_prescribed)
        room +=
            stop.pair.weight[i] * stop.pair.normal.dot(to.position()[node] - from.position()[node]);
    }
    stop.allowed = -room / path.duration;
    if (known == stops_.end()) {
      stops_.push_back(stop);
    } else {
      *known = stop;
    }
    ++*added;
  }
  return std::nullopt;
}

void Contact::apply_stops(std::span<const Vec3> velocity, std::span<Vec3> force) {
  surface_.remove_added_pairs();
  StencilRoom room;
  for (Stop& stop : stops_) {
    stop.pair.push = -stop.pair.damping * (closing_rate(stop.pair, velocity) - stop.allowed);
    const Stencil of = stencil(stop.pair, room);
    for (std::size_t i = 0; i < of.particles.size(); ++i) {
      if (is_dynamic(of.particles[i]))
        force[of.particles[i]] += of.weights[i] * stop.pair.push * stop.pair.normal;
    }
    surface_.add_pair(stop.pair);
  }
}

}  // namespace weft::sim
