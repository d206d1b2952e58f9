// The springs of ties (sim/scene/ties.h) and seams (sim/scene/seams.h) between particles of a
// scene.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "sim/forces/moving_points.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// A spring between two points. The vector between them, d, is the sum of coefficient[i] x_i over
// dynamic particles, plus the anchor's part if one of the points is not simulated. The energy is
//   W = k/2 (|d| - L)^2.
struct SpringEnds {
  int count = 0;
  std::array<int, 4> particle{};
  std::array<double, 4> coefficient{};
  int anchor = -1;  // number in MovingPoints; -1: none
  double anchor_coefficient = 0;
  int anchor_body = -1;  // index into Scene::bodies
  int tie = -1;          // number; -1: of a seam
  double stiffness = 0;  // k, N/m
  double length = 0;     // L, m, at the time set
  // The length of a seam that closes falls from `first_length` (m) to zero in `closing_time` (s).
  double first_length = 0, closing_time = 0;
  double length_rate = 0;  // m/s, at the time set
};

// Springs of the given ties or seams with at least one simulated end.
class TieSprings {
 public:
  // `scene` must outlive the springs if an anchor moves.
  TieSprings(const Scene& scene, std::span<const Tie> ties);
  TieSprings(const Scene& scene, std::span<const Seam> seams);

  const std::vector<SpringEnds>& springs() const { return springs_; }
  const MovingPoints& anchors() const { return anchors_; }
  // True if an anchor moves or a length changes.
  bool vary() const { return anchors_.move() || close_; }
  // Gives anchors their places and springs their lengths. Called before the first use if they vary.
  void set_time(const Instant& now);
  // The vector between a spring's points, m.
  Vec3 between(const SpringEnds& spring, std::span<const Vec3> position) const;
  // The sum of the springs' forces, N. Precondition: set_time() if they vary.
  double load(std::span<const Vec3> position) const;

 private:
  void add_point(const Scene& scene, int case_body, double sign, std::span<const int> nodes,
                 const Vec3& weights, const Vec3& place, SpringEnds& spring);

  std::vector<SpringEnds> springs_;
  MovingPoints anchors_;
  bool close_ = false;
};

}  // namespace weft::sim
