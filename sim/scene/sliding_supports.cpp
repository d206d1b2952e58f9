#include "sim/scene/sliding_supports.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "sim/case/case_error.h"
#include "sim/scene/scene.h"
#include "sim/scene/shell_body.h"

namespace weft::sim {

namespace {

// Largest distance from the plane of symmetry that counts as rounding, as a fraction of the
// diagonal of the body's bounding box.
constexpr double largest_stray = 1e-6;

void require_plane(const SceneBody& body, const PinCase& pin, std::span<const int> held,
                   std::span<const Vec3> position) {
  const Vec3 normal = pin.symmetry->stableNormalized();
  Eigen::AlignedBox3d box;
  for (const Vec3& each : position) box.extend(each);
  for (const int i : held) {
    const double stray = std::abs(normal.dot(position[i] - position[held.front()]));
    if (stray <= largest_stray * box.diagonal().norm()) continue;
    const bsi::TexelAddress at = body.atlas.particle_address(i);
    throw CaseError(pin.location,
                    "the plane of symmetry does not hold row " + std::to_string(at.row) +
                        ", column " + std::to_string(at.col) + " of \"" + body.name + '"',
                    "expected vertices of one plane with the normal symmetry_normal");
  }
}

class Adder {
 public:
  Adder(int pin, std::span<const Vec3> position, SlidingSupports& supports)
      : pin_(pin), position_(position), supports_(supports) {}

  void add(int particle, int base, const Vec3& direction) {
    const Vec3 start_base = base < 0 ? Vec3(Vec3::Zero()) : position_[base];
    supports_.all.push_back({particle, base, direction, position_[particle], start_base, pin_});
  }

 private:
  int pin_;
  std::span<const Vec3> position_;
  SlidingSupports& supports_;
};

}  // namespace

void add_sliding_supports(const SceneBody& body, const PinCase& pin, int number,
                          std::span<const int> held, std::span<const Vec3> position,
                          SlidingSupports& supports) {
  supports.motions.resize(number + 1);
  supports.moves.resize(number + 1, 0);
  Adder adder(number, position, supports);
  for (const std::string& axis : pin.axes) {
    const Vec3 direction = Vec3::Unit(axis[0] - 'x');
    for (const int i : held) adder.add(i, -1, direction);
  }
  if (pin.motion) {
    std::vector<Vec3> start;
    for (const int i : held) start.push_back(position[i]);
    Vec3 mean = Vec3::Zero();
    for (const Vec3& each : start) mean += each / static_cast<double>(start.size());
    supports.motions[number] = RigidMotion(*pin.motion, mean);
    supports.moves[number] = 1;
  }
  if (!pin.symmetry) return;
  require_plane(body, pin, held, position);
  const Vec3 normal = pin.symmetry->stableNormalized();
  const Vec3 first = normal.unitOrthogonal(), second = normal.cross(first);
  for (const int i : held) adder.add(i, -1, normal);
  for (const auto& [particle, border] : rows_beside_borders(body, held)) {
    adder.add(particle, border, first);
    adder.add(particle, border, second);
  }
}

std::vector<MotionEvent> events_of(const SlidingSupports& supports) {
  std::vector<MotionEvent> events;
  for (const RigidMotion& motion : supports.motions) {
    for (auto event = motion.next_event(-1); event; event = motion.next_event(event->time))
      events.push_back(*event);
  }
  return events;
}

void match_velocities(const SlidingSupports& supports, double time, std::span<Vec3> velocity) {
  // Setting one component disturbs another one only if their directions are oblique or the support
  // has a base. Such components converge like a geometric series.
  constexpr int most_rounds = 100;
  constexpr double rounding = 1e-14;
  for (int round = 0; round < most_rounds; ++round) {
    double largest_change = 0, largest_speed = 0;
    for (const SlidingSupport& each : supports.all) {
      Vec3 place = Vec3::Zero(), rate = Vec3::Zero(), base_rate = Vec3::Zero();
      if (supports.moves[each.pin] != 0) {
        const RigidPose pose = supports.motions[each.pin].pose(time);
        pose.place(each.start, place, rate);
        if (each.base >= 0) pose.place(each.start_base, place, base_rate);
      }
      if (each.base >= 0) base_rate -= velocity[each.base];
      const double change = each.direction.dot(rate - base_rate - velocity[each.particle]);
      velocity[each.particle] += change * each.direction;
      largest_change = std::max(largest_change, std::abs(change));
      largest_speed = std::max(largest_speed, velocity[each.particle].norm());
    }
    if (largest_change <= rounding * largest_speed) return;
  }
}

}  // namespace weft::sim
