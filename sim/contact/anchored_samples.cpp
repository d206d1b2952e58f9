// Anchors of the samples in contact: where they are, and where steps drag them.
#include <algorithm>

#include "sim/contact/surface_contact.h"

namespace weft::sim {

AnchorKey SurfaceContact::anchor_key(int point, int body, int surface) const {
  return {case_index_[body], point - scene_.bodies[body].first_point, case_index_[surface]};
}

// Returns the vector (m) from an anchor to its sample.
Vec3 SurfaceContact::from_anchor(const Anchor& anchor, std::span<const Vec3> position) const {
  const auto first_of = [&](int case_body) {
    return scene_.bodies[scene_.case_order[case_body]].first_point;
  };
  Vec3 vector = position[first_of(anchor.key.body) + anchor.key.point];
  for (int k = 0; k < 3; ++k)
    vector -= anchor.weights[k] * position[first_of(anchor.key.surface) + anchor.corners[k]];
  return vector;
}

SurfaceContact::AnchorRates SurfaceContact::rates_of(const Anchor& anchor,
                                                     std::span<const Vec3> velocity) const {
  AnchorRates rates;
  const auto add = [&](int case_body, int own_point, double weight) {
    const int point = scene_.bodies[scene_.case_order[case_body]].first_point + own_point;
    if (!is_dynamic(point)) {
      rates.obstacles += weight * velocity[point];
    } else if (scene_.pinned[scene_.main_particle(point)] == 0) {
      rates.free += weight * velocity[point];
    }
  };
  add(anchor.key.body, anchor.key.point, 1);
  for (int k = 0; k < 3; ++k) add(anchor.key.surface, anchor.corners[k], -anchor.weights[k]);
  return rates;
}

// Computes the positions of the corners of all anchors on obstacles that are given by their poses.
void SurfaceContact::place_anchors(const PlacedPoints& now) {
  for (const Anchor& anchor : anchors_->selected()) {
    const int body = scene_.case_order[anchor.key.surface];
    const int number = search_.obstacles().of_body(body);
    if (now.pose(number) == nullptr) continue;
    for (const int corner : anchor.corners) {
      const int point = scene_.bodies[body].first_point + corner;
      if (marks_.is_new(point)) now.place(search_.obstacles().all()[number], point);
    }
  }
}

void SurfaceContact::advance_anchors(Anchors& anchors) const {
  Anchors next;
  for (const Anchor& anchor : anchors)
    if (!scene_.bodies[scene_.case_order[anchor.key.body]].dynamic) next.push_back(anchor);
  for (std::size_t i = 0; i < pairs_.size();) {
    // The terms of a sample with one surface follow each other.
    const int vertex = pairs_[i].nodes[0], surface = pairs_[i].surface;
    const ContactPair* nearest = nullptr;
    for (; i < pairs_.size() && pairs_[i].nodes[0] == vertex && pairs_[i].surface == surface; ++i) {
      // Anchors would keep spheres from rolling.
      const bool counts =
          surface >= 0 && pairs_[i].sliding >= 0 && !sliding_[pairs_[i].sliding].has_spins();
      if (counts && (nearest == nullptr || pairs_[i].gap < nearest->gap)) nearest = &pairs_[i];
    }
    if (nearest == nullptr) continue;
    Footing foot{.normal = nearest->normal};
    for (int k = 0; k < 3; ++k) {
      foot.corners[k] = nearest->nodes[k + 1] - scene_.bodies[surface].first_point;
      foot.weights[k] = -nearest->weight[k + 1];
      foot.x[k] = measured_at_[nearest->nodes[k + 1]];
    }
    const AnchorKey key = anchor_key(vertex, scene_.body_index_of_point(vertex), surface);
    const Anchor* const before = find_anchor(anchors, key);
    const Vec3 offset = before == nullptr ? Vec3::Zero() : from_anchor(*before, measured_at_);
    next.push_back(
        advanced_anchor(key, before, offset, foot, *scene_.source.contact.sticking_distance));
  }
  std::ranges::sort(next, {}, &Anchor::key);
  anchors.swap(next);
}

}  // namespace weft::sim
