#include "sim/particles/sphere_search.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "bsi/proximity.h"
#include "sim/scene/sphere_groups.h"

namespace weft::sim {

namespace {

// Allowance of a sphere among others when pairs are found: a multiple of its reach, and a fraction
// of its radius.
constexpr double allowed_reaches = 3.2, slack_share = 0.05;
// Margin of new lists of triangles: a multiple of the reach, and a fraction of the radius.
constexpr double surface_reaches = 6, surface_share = 0.1;
// Reaches that a sphere may move before the triangles near it are measured again.
constexpr double measured_reaches = 0.5;
// Relative difference of squared distances below which two triangles are equally close.
constexpr double equally_close = 1e-9;
// Rounding of distances moved, as a fraction of the radius.
constexpr double rounding_of_moves = 1e-9;
// Relative difference of squared distances that rounding may hide. Spheres this near overlap.
constexpr double last_digits = 1e-14;
// Way of a sphere along a surface in a step, as a fraction of the radius, from which it counts that
// the normal changes on it. On shorter ways the surface rises by far less than a rest gap.
constexpr double least_way = 1e-3;
// Least part of a change of the normal that is along the way of the sphere. In a groove, normals
// differ across the way.
constexpr double least_bend = 0.3;
// Least cosine of the angle between the normals at both ends of a step on a surface that counts as
// curved. Larger angles (11.5 degrees) are kinks, which a sphere hits.
constexpr double least_cosine_of_curves = 0.98;

// Returns the least squared distance of two points on straight paths, after they begin to move,
// from their distance vectors at both ends. It is infinite if they part from the beginning.
double least_squared_distance(const Vec3& before, const Vec3& after) {
  const Vec3 change = after - before;
  const double along = before.dot(change);
  if (along >= 0) return std::numeric_limits<double>::infinity();
  if (after.dot(change) <= 0) return after.squaredNorm();
  return before.squaredNorm() - along * along / change.squaredNorm();
}

}  // namespace

SphereSearch::SphereSearch(const Scene& scene, const SphereSurfaces& surfaces,
                           const SphereLaws& laws, Statistics& statistics)
    : surfaces_(surfaces), laws_(laws), statistics_(statistics), radii_(sphere_radii(scene)) {
  for (int b = 0; b < scene.dynamic_bodies; ++b)
    group_.insert(group_.end(), scene.bodies[b].particle_count(), b);
  for (const ObstacleSurface& surface : surfaces.all()) candidates_.emplace_back(surface, radii_);
  reach_.assign(radii_.size(), 0.0);
}

bool SphereSearch::pairs_hold(std::span<const Vec3> place, std::span<const double> reach) const {
  if (built_at_.empty()) return false;
  for (std::size_t i = 0; i < radii_.size(); ++i) {
    const double rest = allowance_[i] - (reach.empty() ? 0 : reach[i]);
    if (!(rest >= 0) || (place[i] - built_at_[i]).squaredNorm() > rest * rest) return false;
  }
  return true;
}

// Makes the pairs complete for gaps of at most the sum of the reaches of two spheres at `place`. An
// empty `reach` means 0.
void SphereSearch::cover_pairs(std::span<const Vec3> place, std::span<const double> reach) {
  if (pairs_hold(place, reach)) return;
  const PhaseTimer timer(statistics_.phases.rebuild);
  ++statistics_.counters.rebuilds;
  built_at_.assign(place.begin(), place.end());
  allowance_.resize(radii_.size());
  enlarged_.resize(radii_.size());
  for (std::size_t i = 0; i < radii_.size(); ++i) {
    const double least = reach.empty() ? 0 : reach[i];
    allowance_[i] = std::max(allowed_reaches * reach_[i], least) + slack_share * radii_[i];
    enlarged_[i] = radii_[i] + allowance_[i];
  }
  statistics_.counters.bound_tests += grid_.find_pairs(place, enlarged_, pairs_);
  statistics_.counters.candidate_pairs += pairs_.count();
}

// Makes the pairs complete for spheres that touch on their straight paths.
void SphereSearch::cover_paths(std::span<const Vec3> start, std::span<const Vec3> end) {
  if (pairs_hold(start, {}) && pairs_hold(end, {})) return;
  way_.resize(radii_.size());
  for (std::size_t i = 0; i < radii_.size(); ++i) way_[i] = (end[i] - start[i]).norm();
  cover_pairs(start, way_);
}

Vec3 SphereSearch::local(int surface, const RigidPose& pose, const Vec3& place) const {
  return surfaces_.all()[surface].motion == nullptr ? place : pose.start_of(place);
}

SphereSearch::Closest SphereSearch::closest(const ObstacleSurface& surface, int sphere,
                                            int triangle, const Vec3& local) const {
  const auto& [a, b, c] = surface.mesh->triangles[triangle];
  const bsi::Closest found = bsi::closest_vertex_triangle(local, surface.vertices[a],
                                                          surface.vertices[b], surface.vertices[c]);
  Closest result;
  const double distance = std::sqrt(found.squared_distance);
  result.triangle = triangle;
  result.normal = found.separation / distance;
  result.point = local - found.separation;
  result.gap = distance - radii_[sphere] - surface.half_thickness;
  for (int k = 0; k < 3; ++k) result.weight[k] = -found.weight[k + 1];
  return result;
}

SphereContact SphereSearch::sphere_contact(int a, int b, std::span<const Vec3> position) const {
  SphereContact contact;
  contact.sphere = a;
  contact.other = b;
  const Vec3 between = position[a] - position[b];
  const double distance = between.norm();
  contact.normal = between / distance;
  contact.gap = distance - radii_[a] - radii_[b];
  const SphereLaw& law = laws_.of(group_[a], group_[b]);
  contact.restitution = law.restitution;
  contact.friction = law.friction;
  return contact;
}

SphereContact SphereSearch::surface_contact(int surface, int sphere, const Closest& closest,
                                            const SphereStart& start) const {
  const ObstacleSurface& target = surfaces_.all()[surface];
  SphereContact contact;
  contact.sphere = sphere;
  contact.surface = surface;
  contact.triangle = closest.triangle;
  contact.normal = closest.normal;
  contact.gap = closest.gap;
  if (target.motion != nullptr) {
    contact.normal = start.poses[surface].rotation * closest.normal;
    contact.drive =
        (start.ends[surface].place(closest.point) - start.poses[surface].place(closest.point)) /
        start.length;
  }
  const SphereLaw& law = laws_.of(group_[sphere], target.body);
  contact.restitution = law.restitution;
  contact.friction = law.friction;
  return contact;
}

void SphereSearch::find_contacts(const SphereStart& start, std::span<const double> reach,
                                 double padding, std::vector<SphereContact>& contacts) {
  contacts.clear();
  reach_.assign(reach.begin(), reach.end());
  cover_pairs(start.position, reach);
  const PhaseTimer timer(statistics_.phases.narrow_phase);
  const int count = static_cast<int>(radii_.size());
  const double square = 0.5 * start.length * start.length;
  for (int a = 0; a < count; ++a) {
    for (const int b : pairs_.of(a)) {
      const double most = radii_[a] + radii_[b] + reach[a] + reach[b];
      const double squared = (start.position[a] - start.position[b]).squaredNorm();
      if (squared > most * most) continue;
      const double approach = start.length * (start.velocity[a] - start.velocity[b]).norm() +
                              square * (start.acceleration[a] - start.acceleration[b]).norm();
      const double far = radii_[a] + radii_[b] + padding + approach;
      if (squared > far * far) continue;
      contacts.push_back(sphere_contact(a, b, start.position));
    }
  }
  statistics_.counters.narrow_phase_calls += pairs_.count();
  for (int s = 0; s < surfaces_.count(); ++s) {
    for (int i = 0; i < count; ++i) add_surface_contacts(s, i, start, reach[i], contacts);
  }
}

// Makes the list of triangles near the sphere complete for gaps of up to `need` (m).
void SphereSearch::cover_surface(int surface, int sphere, const Vec3& local, double need) {
  const double wish = surface_reaches * reach_[sphere] + surface_share * radii_[sphere] + need;
  statistics_.counters.bound_tests +=
      candidates_[surface].cover(sphere, local, need + rounding_of_moves * radii_[sphere], wish);
}

void SphereSearch::add_surface_contacts(int surface, int sphere, const SphereStart& start,
                                        double reach, std::vector<SphereContact>& contacts) {
  SurfaceCandidates& candidates = candidates_[surface];
  const Vec3 place = local(surface, start.poses[surface], start.position[sphere]);
  // Two spheres meet within the sum of their reaches. A surface has none of its own, and the reach
  // of the sphere counts twice.
  const double need = 2 * reach;
  cover_surface(surface, sphere, place, need);
  double far = need + candidates.moved(sphere, place) + rounding_of_moves * radii_[sphere];
  if (candidates.least_gap(sphere) > far) return;
  candidates.measure(sphere, place, measured_reaches * reach);
  far = need + candidates.moved(sphere, place) + rounding_of_moves * radii_[sphere];
  const ObstacleSurface& target = surfaces_.all()[surface];
  near_.clear();
  for (const NearTriangle& each : candidates.of(sphere)) {
    if (each.gap > far) continue;
    ++statistics_.counters.narrow_phase_calls;
    const Closest found = closest(target, sphere, each.triangle, place);
    if (found.gap <= need) near_.push_back(found);
  }
  const std::size_t before = contacts.size();
  for (std::size_t i = 0; i < near_.size(); ++i) {
    if (is_minimum(target, sphere, i))
      contacts.push_back(surface_contact(surface, sphere, near_[i], start));
  }
  if (contacts.size() > before) look_ahead(start, std::span(contacts).subspan(before));
}

// Finds how a surface goes on for a sphere that slides or rolls on it. `contacts` are those of the
// sphere with the surface, and near_ has the triangles near it. Beside an edge of a mesh that
// stands for a curved surface a sphere has several contacts with nearly equal normals. The closest
// one bears it: sweeps would not find which.
void SphereSearch::look_ahead(const SphereStart& start, std::span<SphereContact> contacts) const {
  const SphereContact support = *std::ranges::min_element(contacts, {}, &SphereContact::gap);
  const int sphere = support.sphere;
  const ObstacleSurface& target = surfaces_.all()[support.surface];
  const bool moves = target.motion != nullptr;
  const RigidPose& end = start.ends[support.surface];
  const Vec3& normal = support.normal;
  const Vec3 relative = start.velocity[sphere] - support.drive;
  const Vec3 slide = relative - relative.dot(normal) * normal;
  const Vec3 place = start.position[sphere] + start.length * (support.drive + slide);
  Vec3 last_normal = normal;
  const double way = start.length * slide.norm();
  const bool can_bend = way > std::max(support.gap, least_way * radii_[sphere]);
  if (can_bend && (moves || near_.size() > 1)) {
    const Vec3 last_place = local(support.surface, end, place);
    double least = std::numeric_limits<double>::infinity();
    for (const Closest& each : near_) {
      if (each.gap > support.gap + 2 * way) continue;
      const Closest found = closest(target, sphere, each.triangle, last_place);
      if (!(found.gap < least)) continue;
      least = found.gap;
      last_normal = moves ? Vec3(end.rotation * found.normal) : found.normal;
    }
    // True if the surface bends along the way until it has this normal, if at all.
    const auto bends_to = [&](const Vec3& other) {
      const Vec3 change = other - normal;
      return normal.dot(other) >= least_cosine_of_curves &&
             std::abs(slide.dot(change)) >= least_bend * slide.norm() * change.norm();
    };
    const bool rises = slide.dot(last_normal) < 0 && bends_to(last_normal);
    for (SphereContact& contact : contacts) {
      if (contact.triangle != support.triangle) {
        contact.is_borne = bends_to(contact.normal);
      } else if (rises) {
        const Vec3 middle = (normal + last_normal).normalized();
        contact.bend = middle - normal;
        contact.rise = -slide.dot(middle);
      }
    }
  }
  if (!moves) return;
  for (SphereContact& contact : contacts) {
    const bool goes_on = last_normal.dot(contact.normal) >= least_cosine_of_curves;
    const double distance = contact.gap + radii_[sphere] + target.half_thickness;
    const Vec3 arm =
        place - distance * (goes_on ? last_normal : contact.normal) - end.centre - end.translation;
    contact.end_drive = end.velocity + end.angular_velocity.cross(arm);
    // Along the normal the mean velocity counts, with which gaps close.
    contact.end_drive += contact.normal.dot(contact.drive - contact.end_drive) * contact.normal;
  }
}

// True unless the closest point of a triangle of near_ lies on a corner or an edge that it shares
// with a closer triangle, or with an equally close one before it.
bool SphereSearch::is_minimum(const ObstacleSurface& surface, int sphere,
                              std::size_t candidate) const {
  const auto& triangle = surface.mesh->triangles[near_[candidate].triangle];
  std::vector<int>::size_type count = 0;
  std::array<int, 3> corners{};
  for (int k = 0; k < 3; ++k) {
    if (near_[candidate].weight[k] > 0) corners[count++] = triangle[k];
  }
  if (count == 3) return true;
  const double sum = radii_[sphere] + surface.half_thickness;
  const double own = near_[candidate].gap + sum;
  for (std::size_t i = 0; i < near_.size(); ++i) {
    if (i == candidate) continue;
    const auto& other = surface.mesh->triangles[near_[i].triangle];
    const bool shares = std::all_of(corners.begin(), corners.begin() + count, [&](int corner) {
      return std::ranges::find(other, corner) != other.end();
    });
    if (!shares) continue;
    const double distance = near_[i].gap + sum;
    if (distance < own * (1 - equally_close)) return false;
    if (distance < own * (1 + equally_close) && i < candidate) return false;
  }
  return true;
}

void SphereSearch::find_overlaps(const SphereStart& start, std::span<const Vec3> end,
                                 std::span<const char> changed,
                                 std::vector<SphereContact>& overlaps) {
  overlaps.clear();
  cover_paths(start.position, end);
  const PhaseTimer timer(statistics_.phases.narrow_phase);
  const auto is_same = [&](int sphere) { return !changed.empty() && changed[sphere] == 0; };
  const int count = static_cast<int>(radii_.size());
  for (int a = 0; a < count; ++a) {
    const bool same = is_same(a);
    for (const int b : pairs_.of(a)) {
      if (same && is_same(b)) continue;
      const Vec3 before = start.position[a] - start.position[b], after = end[a] - end[b];
      const double least = radii_[a] + radii_[b];
      if (least_squared_distance(before, after) > (1 + last_digits) * least * least) continue;
      overlaps.push_back(sphere_contact(a, b, start.position));
    }
  }
  for (int s = 0; s < surfaces_.count(); ++s) {
    for (int i = 0; i < count; ++i) {
      if (!is_same(i)) add_surface_overlaps(s, i, start, end[i], overlaps);
    }
  }
}

void SphereSearch::add_surface_overlaps(int surface, int sphere, const SphereStart& start,
                                        const Vec3& end, std::vector<SphereContact>& overlaps) {
  const SurfaceCandidates& candidates = candidates_[surface];
  const Vec3 place = local(surface, start.ends[surface], end);
  cover_surface(surface, sphere, place, 0);
  const double far = candidates.moved(sphere, place) + rounding_of_moves * radii_[sphere];
  if (candidates.least_gap(sphere) > far) return;
  const ObstacleSurface& target = surfaces_.all()[surface];
  for (const NearTriangle& each : candidates.of(sphere)) {
    if (each.gap > far || closest(target, sphere, each.triangle, place).gap >= 0) continue;
    const Vec3 before = local(surface, start.poses[surface], start.position[sphere]);
    overlaps.push_back(
        surface_contact(surface, sphere, closest(target, sphere, each.triangle, before), start));
  }
}

}  // namespace weft::sim
