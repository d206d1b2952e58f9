// The springs of ties (sim/scene/ties.h) and seams (sim/scene/seams.h) with the particles on which
// they act.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "sim/forces/moving_points.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// A spring between two points. The vector between them is
//   d = sum_i coefficient[i] x_i + anchor_coefficient * anchor.
// The x_i are positions of dynamic particles. The anchor is a point that is not simulated. The
// energy is
//   W = k/2 (|d| - L)^2.
struct SpringEnds {
  int count = 0;
  std::array<int, 4> particle{};
  std::array<double, 4> coefficient{};
  int anchor = -1;  // index in MovingPoints; -1: no anchor
  double anchor_coefficient = 0;
  int anchor_body = -1;  // index into Scene::bodies; -1: no anchor
  int tie = -1;          // Tie::number; -1: the spring belongs to a seam
  double stiffness = 0;  // stiffness k, N/m
  double length = 0;     // rest length L at the time of set_time(), m
  // The length of a seam that closes falls from `first_length` (m) to zero in `closing_time` (s).
  double first_length = 0, closing_time = 0;
  double length_rate = 0;  // m/s, at the time of set_time()
};

// The springs of ties or seams. Springs that act on no dynamic particle are left out.
class TieSprings {
 public:
  // `scene` must outlive this object if an anchor moves.
  TieSprings(const Scene& scene, std::span<const Tie> ties);
  TieSprings(const Scene& scene, std::span<const Seam> seams);

  const std::vector<SpringEnds>& springs() const { return springs_; }
  const MovingPoints& anchors() const { return anchors_; }
  // True if an anchor moves or a length changes.
  bool vary() const { return anchors_.move() || close_; }
  // Sets the positions of anchors and the lengths of springs at `now`. If vary(), it must be called
  // before between(), load() and any use of the lengths.
  void set_time(const Instant& now);
  // Returns the vector d of a spring, m.
  Vec3 between(const SpringEnds& spring, std::span<const Vec3> position) const;
  // Returns the sum over springs of k ||d| - L|, N. If vary(), set_time() must have been called
  // before.
  double load(std::span<const Vec3> position) const;

 private:
  void add_point(const Scene& scene, int case_body, double sign, std::span<const int> nodes,
                 const Vec3& weights, const Vec3& place, SpringEnds& spring);

  std::vector<SpringEnds> springs_;
  MovingPoints anchors_;
  bool close_ = false;
};

}  // namespace weft::sim
