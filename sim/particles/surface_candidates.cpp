#include "sim/particles/surface_candidates.h"

#include <algorithm>
#include <cmath>

#include "bsi/proximity.h"

namespace weft::sim {

namespace {

// Entries of old lists are removed once they are more than those in use, and more than this.
constexpr std::size_t least_garbage = 4096;

}  // namespace

SurfaceCandidates::SurfaceCandidates(const ObstacleSurface& surface, std::span<const double> radii)
    : surface_(surface), radii_(radii), lists_(radii.size()) {
  low_ = high_ = surface.vertices.front();
  for (const Vec3& x : surface.vertices) {
    low_ = low_.cwiseMin(x);
    high_ = high_.cwiseMax(x);
  }
}

double SurfaceCandidates::distance_to_box(const Vec3& place) const {
  return (low_ - place).cwiseMax(place - high_).cwiseMax(0.0).norm();
}

std::int64_t SurfaceCandidates::cover(int sphere, const Vec3& place, double need, double wish) {
  List& list = lists_[sphere];
  const double left = list.margin - need;
  if (left >= 0 && (place - list.place).squaredNorm() <= left * left) return 0;
  ++lists_made_;
  live_ -= list.end - list.first;
  list.place = place;
  list.first = list.end = pool_.size();
  const double own = radii_[sphere] + surface_.half_thickness;
  const double away = distance_to_box(place) - own;
  if (away > wish) {
    list.margin = list.least_gap = away;
    return 0;
  }
  list.margin = list.least_gap = wish;
  bsi::TraversalCounters counters;
  found_.clear();
  bsi::single_traversal(surface_.pyramid, place, own, {.margin = wish, .threads = 1}, found_,
                        counters);
  fill(sphere);
  return counters.bound_tests;
}

double SurfaceCandidates::gap(int sphere, int triangle, const Vec3& place) const {
  const auto& [a, b, c] = surface_.mesh->triangles[triangle];
  const bsi::Closest found = bsi::closest_vertex_triangle(
      place, surface_.vertices[a], surface_.vertices[b], surface_.vertices[c]);
  return std::sqrt(found.squared_distance) - radii_[sphere] - surface_.half_thickness;
}

// Appends the triangles of found_ to the pool, as the list of the sphere.
void SurfaceCandidates::fill(int sphere) {
  List& list = lists_[sphere];
  std::ranges::sort(found_);
  for (const int triangle : found_) {
    const double gap = this->gap(sphere, triangle, list.place);
    if (gap > list.margin) continue;
    pool_.push_back({triangle, gap});
    list.least_gap = std::min(list.least_gap, gap);
  }
  list.end = pool_.size();
  live_ += list.end - list.first;
  if (pool_.size() - live_ > std::max(live_, least_garbage)) compact();
}

void SurfaceCandidates::measure(int sphere, const Vec3& place, double far) {
  List& list = lists_[sphere];
  const double moved = (place - list.place).norm();
  if (moved <= far) return;
  list.place = place;
  list.margin -= moved;
  if (list.first == list.end) {
    list.least_gap -= moved;
    return;
  }
  list.least_gap = list.margin;
  for (std::size_t k = list.first; k < list.end; ++k) {
    pool_[k].gap = gap(sphere, pool_[k].triangle, place);
    list.least_gap = std::min(list.least_gap, pool_[k].gap);
  }
}

void SurfaceCandidates::compact() {
  spare_.clear();
  for (List& list : lists_) {
    const std::size_t first = spare_.size();
    spare_.insert(spare_.end(), pool_.begin() + list.first, pool_.begin() + list.end);
    list.first = first;
    list.end = spare_.size();
  }
  pool_.swap(spare_);
}

}  // namespace weft::sim
