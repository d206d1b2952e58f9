// The oracle of searches on the device: every leaf against every other, from the contract.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <span>
#include <tuple>
#include <vector>

#include "gpu/compute_traversal.h"

namespace weft::gpu {

struct LeafBox {
  Eigen::Vector3f low, high;
  std::vector<int> particles;
};

inline std::vector<LeafBox> leaf_boxes(const bsi::Atlas& atlas, const BodyImage& image, Leaf leaf) {
  std::vector<LeafBox> boxes;
  const auto add = [&](auto begin, auto end) {
    LeafBox box{Eigen::Vector3f::Constant(std::numeric_limits<float>::max()),
                Eigen::Vector3f::Constant(-std::numeric_limits<float>::max()),
                {begin, end}};
    for (const int particle : box.particles) {
      for (const std::span<const Vec3> positions : {image.start, image.end}) {
        if (positions.empty()) continue;
        const Eigen::Vector3f p = positions[particle].cast<float>();
        box.low = box.low.cwiseMin(p);
        box.high = box.high.cwiseMax(p);
      }
    }
    boxes.push_back(std::move(box));
  };
  for (int quad = 0; quad < atlas.quad_count(); ++quad) {
    const auto corners = atlas.quad_particles(quad);
    if (leaf == Leaf::quad) {
      add(corners.begin(), corners.end());
    } else {
      for (const auto& triangle : bsi::quad_triangles(corners)) {
        add(triangle.begin(), triangle.end());
      }
    }
  }
  return boxes;
}

inline float largest_coordinate(const std::vector<LeafBox>& boxes) {
  float largest = 0;
  for (const LeafBox& box : boxes) {
    largest = std::max(largest, box.low.cwiseAbs().cwiseMax(box.high.cwiseAbs()).maxCoeff());
  }
  return largest;
}

inline bool overlap(const LeafBox& a, const LeafBox& b, float half) {
  const auto wide_low = [half](const LeafBox& box) { return box.low.array() - half; };
  const auto wide_high = [half](const LeafBox& box) { return box.high.array() + half; };
  return (wide_low(a) <= wide_high(b)).all() && (wide_low(b) <= wide_high(a)).all();
}

inline bool share_particle(const LeafBox& a, const LeafBox& b) {
  return std::ranges::any_of(a.particles, [&](int particle) {
    return std::ranges::find(b.particles, particle) != b.particles.end();
  });
}

// Returns the pairs of a query without certificate and filter; `a` and `b` are the leaves of its
// bodies.
inline std::vector<Candidate> pairs_of_leaves(const std::vector<LeafBox>& a,
                                              const std::vector<LeafBox>& b, const PairQuery& query,
                                              std::uint32_t number, Leaf leaf) {
  EXPECT_FALSE(query.certificate || query.distance_filter);
  std::vector<Candidate> found;
  const float half = bsi::half_margin(query.margin, largest_coordinate(a), largest_coordinate(b));
  const bool self = query.body_a == query.body_b;
  for (std::uint32_t i = 0; i < a.size(); ++i) {
    for (std::uint32_t j = self ? i : 0; j < b.size(); ++j) {
      if (!overlap(a[i], b[j], half)) continue;
      if (self && leaf == Leaf::triangle && share_particle(a[i], b[j])) continue;
      found.push_back({number, i, j});
    }
  }
  return found;
}

inline std::vector<Candidate> leaves_near_balls(std::span<const Ball> balls, double margin,
                                                const std::vector<LeafBox>& boxes) {
  std::vector<Candidate> found;
  for (std::uint32_t i = 0; i < balls.size(); ++i) {
    const Eigen::Vector3f centre = balls[i].centre.cast<float>();
    const LeafBox point{centre, centre, {}};
    const float half = bsi::half_margin(margin + balls[i].radius, largest_coordinate(boxes),
                                        centre.cwiseAbs().maxCoeff());
    for (std::uint32_t j = 0; j < boxes.size(); ++j) {
      if (overlap(point, boxes[j], half)) found.push_back({i, i, j});
    }
  }
  return found;
}

inline bool before(const Candidate& c, const Candidate& d) {
  return std::tuple(c.query, c.a, c.b) < std::tuple(d.query, d.a, d.b);
}

inline std::vector<Candidate> sorted(std::span<const Candidate> candidates) {
  std::vector<Candidate> result(candidates.begin(), candidates.end());
  std::ranges::sort(result, before);
  return result;
}

}  // namespace weft::gpu
