#include "sim/particles/sphere_search.h"

#include <algorithm>
#include <cmath>

#include "bsi/proximity.h"
#include "sim/base/parallel.h"
#include "sim/scene/sphere_groups.h"

namespace weft::sim {

namespace {

// Allowance of a sphere at a rebuild: a multiple of its reach, and a fraction of its radius. It
// lets candidates serve several steps.
constexpr double allowed_reaches = 3, slack_share = 0.05;
// Relative difference of squared distances below which two triangles are equally close.
constexpr double equally_close = 1e-9;

std::vector<Vec3> in_frame(const RigidPose& pose, std::span<const Vec3> position) {
  std::vector<Vec3> local;
  local.reserve(position.size());
  for (const Vec3& x : position) local.push_back(pose.start_of(x));
  return local;
}

}  // namespace

SphereSearch::SphereSearch(const Scene& scene, const SphereSurfaces& surfaces,
                           const SphereLaws& laws, Statistics& statistics)
    : surfaces_(surfaces),
      laws_(laws),
      statistics_(statistics),
      threads_(scene.threads),
      radii_(sphere_radii(scene)) {
  for (int b = 0; b < scene.dynamic_bodies; ++b)
    group_.insert(group_.end(), scene.bodies[b].particle_count(), b);
}

bool SphereSearch::covers(const SphereStart& start, std::span<const double> reach) const {
  if (built_at_.empty()) return false;
  const auto holds = [&](std::size_t i, const Vec3& before, const Vec3& now) {
    const double rest = allowance_[i] - reach[i];
    return rest >= 0 && (now - before).squaredNorm() <= rest * rest;
  };
  for (std::size_t i = 0; i < radii_.size(); ++i) {
    if (!holds(i, built_at_[i], start.position[i])) return false;
  }
  for (int s = 0; s < surfaces_.count(); ++s) {
    if (surfaces_.all()[s].motion == nullptr) continue;
    for (std::size_t i = 0; i < radii_.size(); ++i) {
      if (!holds(i, built_local_[s][i], start.poses[s].start_of(start.position[i]))) return false;
    }
  }
  return true;
}

bool SphereSearch::prepare(const SphereStart& start, std::span<const double> reach) {
  if (covers(start, reach)) return false;
  rebuild(start, reach);
  return true;
}

void SphereSearch::rebuild(const SphereStart& start, std::span<const double> reach) {
  built_at_.assign(start.position.begin(), start.position.end());
  built_local_.assign(surfaces_.count(), {});
  allowance_.resize(radii_.size());
  std::vector<double> enlarged(radii_.size());
  for (std::size_t i = 0; i < radii_.size(); ++i) {
    allowance_[i] = allowed_reaches * reach[i] + slack_share * radii_[i];
    enlarged[i] = radii_[i] + allowance_[i];
  }
  {
    const PhaseTimer timer(statistics_.phases.rebuild);
    ++statistics_.counters.rebuilds;
    hierarchy_.rebuild(start.position, enlarged);
  }
  const PhaseTimer timer(statistics_.phases.traverse);
  pairs_ = hierarchy_.near_pairs(0, statistics_.counters.bound_tests);
  touches_.clear();
  for (int s = 0; s < surfaces_.count(); ++s) {
    if (surfaces_.all()[s].motion == nullptr) {
      find_surface_candidates(s, start.position);
    } else {
      built_local_[s] = in_frame(start.poses[s], start.position);
      find_surface_candidates(s, built_local_[s]);
    }
  }
  std::ranges::sort(touches_);
  statistics_.counters.candidate_pairs +=
      static_cast<std::int64_t>(pairs_.size() + touches_.size());
}

// The reach of a sphere counts twice at a surface, as its displacement counts once: the sum is at
// most twice the allowance.
void SphereSearch::find_surface_candidates(int surface, std::span<const Vec3> local) {
  const ObstacleSurface& target = surfaces_.all()[surface];
  bsi::TraversalCounters counters;
  std::vector<int> found;
  for (std::size_t i = 0; i < local.size(); ++i) {
    found.clear();
    bsi::single_traversal(target.pyramid, local[i], radii_[i] + target.half_thickness,
                          {.margin = 2 * allowance_[i], .threads = 1}, found, counters);
    for (const int triangle : found) touches_.push_back({surface, static_cast<int>(i), triangle});
  }
  ++statistics_.counters.pair_traversals;
  statistics_.counters.bound_tests += counters.bound_tests;
}

SphereSearch::Closest SphereSearch::closest(const Touch& touch, const Vec3& local) const {
  const ObstacleSurface& surface = surfaces_.all()[touch.surface];
  const auto& [a, b, c] = surface.mesh->triangles[touch.triangle];
  const bsi::Closest found = bsi::closest_vertex_triangle(local, surface.vertices[a],
                                                          surface.vertices[b], surface.vertices[c]);
  Closest result;
  const double distance = std::sqrt(found.squared_distance);
  result.normal = found.separation / distance;
  result.point = local - found.separation;
  result.gap = distance - radii_[touch.sphere] - surface.half_thickness;
  for (int k = 0; k < 3; ++k) result.weight[k] = -found.weight[k + 1];
  return result;
}

SphereContact SphereSearch::sphere_contact(const bsi::LeafPair& pair,
                                           std::span<const Vec3> position) const {
  SphereContact contact;
  contact.sphere = pair.a;
  contact.other = pair.b;
  const Vec3 between = position[pair.a] - position[pair.b];
  const double distance = between.norm();
  contact.normal = between / distance;
  contact.gap = distance - radii_[pair.a] - radii_[pair.b];
  const SphereLaw& law = laws_.of(group_[pair.a], group_[pair.b]);
  contact.restitution = law.restitution;
  contact.friction = law.friction;
  return contact;
}

SphereContact SphereSearch::surface_contact(const Touch& touch, const Closest& closest,
                                            const SphereStart& start) const {
  const ObstacleSurface& surface = surfaces_.all()[touch.surface];
  SphereContact contact;
  contact.sphere = touch.sphere;
  contact.surface = touch.surface;
  contact.triangle = touch.triangle;
  contact.normal = closest.normal;
  contact.gap = closest.gap;
  if (surface.motion != nullptr) {
    contact.normal = start.poses[touch.surface].rotation * closest.normal;
    contact.drive = (start.ends[touch.surface].place(closest.point) -
                     start.poses[touch.surface].place(closest.point)) /
                    start.length;
  }
  const SphereLaw& law = laws_.of(group_[touch.sphere], surface.body);
  contact.restitution = law.restitution;
  contact.friction = law.friction;
  return contact;
}

std::vector<SphereContact> SphereSearch::find_contacts(const SphereStart& start,
                                                       std::span<const double> reach) {
  const PhaseTimer timer(statistics_.phases.narrow_phase);
  std::vector<SphereContact> contacts;
  find_closest(start);
  if (reach.empty()) return contacts;
  for (const bsi::LeafPair& pair : pairs_) {
    const double most = radii_[pair.a] + radii_[pair.b] + reach[pair.a] + reach[pair.b];
    if ((start.position[pair.a] - start.position[pair.b]).squaredNorm() > most * most) continue;
    contacts.push_back(sphere_contact(pair, start.position));
  }
  statistics_.counters.narrow_phase_calls +=
      static_cast<std::int64_t>(pairs_.size() + touches_.size());
  add_surface_contacts(start, reach, contacts);
  return contacts;
}

void SphereSearch::find_closest(const SphereStart& start) {
  closest_.resize(touches_.size());
  parallel_chunks(static_cast<int>(touches_.size()), threads_, [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      const Touch& touch = touches_[i];
      const bool moves = surfaces_.all()[touch.surface].motion != nullptr;
      const Vec3& x = start.position[touch.sphere];
      closest_[i] = closest(touch, moves ? start.poses[touch.surface].start_of(x) : x);
    }
  });
}

void SphereSearch::add_surface_contacts(const SphereStart& start, std::span<const double> reach,
                                        std::vector<SphereContact>& contacts) const {
  for (std::size_t first = 0; first < touches_.size();) {
    std::size_t end = first + 1;
    while (end < touches_.size() && touches_[end].sphere == touches_[first].sphere &&
           touches_[end].surface == touches_[first].surface)
      ++end;
    for (std::size_t i = first; i < end; ++i) {
      if (closest_[i].gap > 2 * reach[touches_[i].sphere] || !is_minimum(i, first, end)) continue;
      contacts.push_back(surface_contact(touches_[i], closest_[i], start));
    }
    first = end;
  }
}

// True unless the closest point of a candidate lies on a corner or an edge that it shares with a
// closer triangle, or with an equally close one before it. The candidates from `first` to `end` are
// those of the same sphere and surface.
bool SphereSearch::is_minimum(std::size_t candidate, std::size_t first, std::size_t end) const {
  const ObstacleSurface& surface = surfaces_.all()[touches_[candidate].surface];
  const auto& triangle = surface.mesh->triangles[touches_[candidate].triangle];
  std::vector<int>::size_type count = 0;
  std::array<int, 3> corners{};
  for (int k = 0; k < 3; ++k) {
    if (closest_[candidate].weight[k] > 0) corners[count++] = triangle[k];
  }
  if (count == 3) return true;
  const double sum = radii_[touches_[candidate].sphere] + surface.half_thickness;
  const double own = closest_[candidate].gap + sum;
  for (std::size_t i = first; i < end; ++i) {
    if (i == candidate) continue;
    const auto& other = surface.mesh->triangles[touches_[i].triangle];
    const bool shares = std::all_of(corners.begin(), corners.begin() + count, [&](int corner) {
      return std::ranges::find(other, corner) != other.end();
    });
    if (!shares) continue;
    const double distance = closest_[i].gap + sum;
    if (distance < own * (1 - equally_close)) return false;
    if (distance < own * (1 + equally_close) && i < candidate) return false;
  }
  return true;
}

std::vector<SphereContact> SphereSearch::find_overlaps(const SphereStart& start,
                                                       std::span<const Vec3> end) {
  const PhaseTimer timer(statistics_.phases.narrow_phase);
  std::vector<SphereContact> overlaps;
  for (const bsi::LeafPair& pair : pairs_) {
    const double least = radii_[pair.a] + radii_[pair.b];
    if ((end[pair.a] - end[pair.b]).squaredNorm() >= least * least) continue;
    overlaps.push_back(sphere_contact(pair, start.position));
  }
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    const Touch& touch = touches_[i];
    const ObstacleSurface& surface = surfaces_.all()[touch.surface];
    const Vec3& x = end[touch.sphere];
    if (surface.motion == nullptr) {
      const double gap = closest_[i].gap;
      if (gap > 0 && (x - start.position[touch.sphere]).squaredNorm() <= gap * gap) continue;
    }
    const Vec3 local = surface.motion == nullptr ? x : start.ends[touch.surface].start_of(x);
    if (closest(touch, local).gap >= 0) continue;
    overlaps.push_back(surface_contact(touch, closest_[i], start));
  }
  return overlaps;
}

}  // namespace weft::sim
