#include "sim/forces/tie_springs.h"

#include <algorithm>
#include <cmath>

#include "sim/scene/easing.h"

namespace weft::sim {

TieSprings::TieSprings(const Scene& scene, std::span<const Tie> ties) {
  for (const Tie& tie : ties) {
    for (const TieSpring& from : tie.springs) {
      SpringEnds spring;
      spring.stiffness = from.share * tie.source->stiffness;
      spring.length = from.length;
      spring.tie = tie.number;
      const SceneBody& body = scene.bodies[scene.case_order[tie.body]];
      const Vec3 place = scene.initial_position[body.first_particle + from.vertex];
      add_point(scene, tie.body, 1, {&from.vertex, 1}, Vec3::UnitX(), place, spring);
      add_point(scene, tie.to, -1, from.nodes, from.weights, from.place, spring);
      if (spring.count > 0) springs_.push_back(spring);
    }
  }
}

TieSprings::TieSprings(const Scene& scene, std::span<const Seam> seams) {
  for (const Seam& seam : seams) {
    const SceneBody& body = scene.bodies[scene.case_order[seam.body]];
    const SceneBody& other = scene.bodies[scene.case_order[seam.to]];
    for (const Stitch& from : seam.stitches) {
      SpringEnds spring;
      spring.stiffness = seam.stiffness * from.length;
      spring.closing_time = seam.source->closing_time;
      spring.first_length = spring.closing_time > 0 ? from.gap : 0;
      spring.length = spring.first_length;
      close_ |= spring.first_length > 0;
      const auto place = [&](const SceneBody& of, int vertex) {
        return scene.initial_position[of.first_particle + vertex];
      };
      const Vec3 weights(from.weight, 1 - from.weight, 0);
      const Vec3 point =
          weights[0] * place(other, from.nodes[0]) + weights[1] * place(other, from.nodes[1]);
      add_point(scene, seam.body, 1, {&from.vertex, 1}, Vec3::UnitX(), place(body, from.vertex),
                spring);
      add_point(scene, seam.to, -1, from.nodes, weights, point, spring);
      if (spring.count > 0) springs_.push_back(spring);
    }
  }
}

void TieSprings::set_time(const Instant& now) {
  if (anchors_.move()) anchors_.set_time(now);
  if (!close_) return;
  for (SpringEnds& spring : springs_) {
    if (spring.first_length == 0) continue;
    const double part = std::min(now.time / spring.closing_time, 1.0);
    spring.length = spring.first_length * (1 - eased(part));
    spring.length_rate = -spring.first_length * eased_slope(part) / spring.closing_time;
  }
}

// Adds `sign` times a point of a body to the vector between the ends of a spring. If the body is
// not dynamic, the point becomes the anchor of the spring.
void TieSprings::add_point(const Scene& scene, int case_body, double sign,
                           std::span<const int> nodes, const Vec3& weights, const Vec3& place,
                           SpringEnds& spring) {
  const SceneBody& body = scene.bodies[scene.case_order[case_body]];
  if (!body.dynamic) {
    // `place` is the point at t = 0. A body that is not an obstacle may have moved before it fell
    // asleep or was held, so its point is computed from the positions in the scene.
    Vec3 now = place;
    if (!body.is_obstacle) {
      now.setZero();
      for (std::size_t i = 0; i < nodes.size(); ++i)
        now +=
            weights[static_cast<int>(i)] * scene.initial_position[body.first_particle + nodes[i]];
    }
    spring.anchor = anchors_.add_on_body(scene, body, now);
    spring.anchor_coefficient = sign;
    spring.anchor_body = scene.case_order[case_body];
    return;
  }
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (weights[static_cast<int>(i)] == 0) continue;
    spring.particle[spring.count] = body.first_particle + nodes[i];
    spring.coefficient[spring.count++] = sign * weights[static_cast<int>(i)];
  }
}

Vec3 TieSprings::between(const SpringEnds& spring, std::span<const Vec3> position) const {
  Vec3 sum = Vec3::Zero();
  if (spring.anchor >= 0) sum = spring.anchor_coefficient * anchors_.position(spring.anchor);
  for (int i = 0; i < spring.count; ++i)
    sum += spring.coefficient[i] * position[spring.particle[i]];
  return sum;
}

double TieSprings::load(std::span<const Vec3> position) const {
  double sum = 0;
  for (const SpringEnds& spring : springs_)
    sum += spring.stiffness * std::abs(between(spring, position).norm() - spring.length);
  return sum;
}

}  // namespace weft::sim
