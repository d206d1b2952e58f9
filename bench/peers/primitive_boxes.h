// The boxes that define candidates, for libraries whose user supplies boxes.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "bench/peers/peer.h"

namespace weft::bench {

// Four lanes of float32; the fourth is always 0 and so passes every test.
using Float4 [[gnu::vector_size(16)]] = float;
using Int4 [[gnu::vector_size(16)]] = int;
using Long2 [[gnu::vector_size(16)]] = long long;

struct Box {
  Float4 low{}, high{};
};

inline bool all(Int4 mask) {
  const auto halves = reinterpret_cast<Long2>(mask);
  return (halves[0] & halves[1]) == -1;
}

inline Float4 lanes(float value) { return Float4{value, value, value, 0}; }

// True if the boxes, each widened by half a margin, overlap or touch, computed in float32 as
// written.
inline bool near(const Box& a, const Box& b, Float4 half) {
  return all((a.low - half <= b.high + half) & (b.low - half <= a.high + half));
}

// Boxes of the primitives of a body, their points rounded to float32.
class PrimitiveBoxes {
 public:
  PrimitiveBoxes() = default;
  explicit PrimitiveBoxes(const PeerBody& body)
      : body_(body), points_(body.point_count), boxes_(body.primitive_count()) {}

  // Finds the boxes from the positions of the body. O(points + triangles), no allocation.
  void update() {
    for (std::size_t i = 0; i < points_.size(); ++i) points_[i] = box_of_point(i);
    if (body_.is_particles()) {
      boxes_ = points_;
      return;
    }
    for (std::size_t t = 0; t < boxes_.size(); ++t) {
      const auto& [i, j, k] = body_.triangles[t];
      boxes_[t] = joined(joined(points_[i], points_[j]), points_[k]);
    }
  }

  std::size_t size() const { return boxes_.size(); }
  const Box& operator[](std::size_t i) const { return boxes_[i]; }
  const std::vector<Box>& boxes() const { return boxes_; }

  bool share_point(int a, int b) const {
    for (const int i : body_.triangles[a]) {
      for (const int j : body_.triangles[b]) {
        if (i == j) return true;
      }
    }
    return false;
  }

 private:
  static Box joined(const Box& a, const Box& b) {
    return {a.low < b.low ? a.low : b.low, a.high > b.high ? a.high : b.high};
  }
  static Float4 rounded(const double* p) {
    return Float4{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]), 0};
  }
  Box box_of_point(std::size_t i) const {
    const Float4 start = rounded(body_.start + 3 * i);
    if (body_.end == nullptr) return {start, start};
    const Float4 end = rounded(body_.end + 3 * i);
    return joined({start, start}, {end, end});
  }

  PeerBody body_;
  std::vector<Box> points_;
  std::vector<Box> boxes_;
};

// The boxes of a whole scene, with the test that makes a pair a candidate.
class SceneBoxes {
 public:
  explicit SceneBoxes(const PeerScene& scene)
      : self_(scene.is_self()),
        half_margin_(scene.half_margin),
        half_(lanes(scene.half_margin)),
        particle_half_margins_(scene.particle_half_margins) {
    for (const PeerBody& body : scene.bodies) bodies_.emplace_back(body);
  }

  void update() {
    for (PrimitiveBoxes& body : bodies_) body.update();
  }
  bool is_self() const { return self_; }
  int body_count() const { return static_cast<int>(bodies_.size()); }
  const PrimitiveBoxes& body(int i) const { return bodies_[i]; }
  const PrimitiveBoxes& first() const { return bodies_.front(); }
  const PrimitiveBoxes& second() const { return bodies_.back(); }
  float half_margin() const { return half_margin_; }

  // Returns a box for libraries; these widened boxes of all candidates overlap or touch.
  Box widened(const PrimitiveBoxes& body, std::size_t i) const {
    return {body[i].low - half_, body[i].high + half_};
  }
  bool is_candidate(int a, int b) const {
    const Float4 half = particle_half_margins_.empty() ? half_ : lanes(particle_half_margins_[a]);
    return near(first()[a], second()[b], half) && !(self_ && first().share_point(a, b));
  }
  // Appends a candidate; for libraries that report a pair once, in either order.
  void append_unordered(int a, int b, std::vector<LeafPair>& pairs) const {
    if (!is_candidate(a, b)) return;
    pairs.push_back(self_ && a > b ? LeafPair{b, a} : LeafPair{a, b});
  }

 private:
  bool self_;
  float half_margin_;
  Float4 half_;
  std::vector<float> particle_half_margins_;
  std::vector<PrimitiveBoxes> bodies_;
};

}  // namespace weft::bench
