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
  supports.radii.resize(number + 1, 0);
  Adder adder(number, position, supports);
  for (const std::string& axis : pin.axes) {
    const Vec3 direction = Vec3::Unit(axis[0] - 'x');
    for (const int i : held) adder.add(i, -1, direction);
  }
  if (pin.motion) {
    std::vector<Vec3> start;
    for (const int i : held) start.push_back(position[i]);
    supports.motions[number] = RigidMotion(*pin.motion, mean_of_image_points(body, position, held));
    supports.moves[number] = 1;
    supports.radii[number] = supports.motions[number].radius_of(start);
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

namespace {

// Sets the supported components of `values`, positions or velocities by particle, to those of
// wanted(pin, start) for the support's places.
template <class Wanted>
void match(const SlidingSupports& supports, const Wanted& wanted, std::span<Vec3> values) {
  // Setting one component disturbs another one only if their directions are oblique or the support
  // has a base. Such components converge like a geometric series.
  constexpr int most_rounds = 100;
  constexpr double rounding = 1e-14;
  for (int round = 0; round < most_rounds; ++round) {
    double largest_change = 0, largest = 0;
    for (const SlidingSupport& each : supports.all) {
      Vec3 left = wanted(each.pin, each.start) - values[each.particle];
      if (each.base >= 0) left -= wanted(each.pin, each.start_base) - values[each.base];
      const double change = each.direction.dot(left);
      values[each.particle] += change * each.direction;
      largest_change = std::max(largest_change, std::abs(change));
      largest = std::max(largest, values[each.particle].norm());
    }
    if (largest_change <= rounding * largest) return;
  }
}

}  // namespace

void match_positions(const SlidingSupports& supports, double time, std::span<Vec3> position) {
  const auto wanted = [&](int pin, const Vec3& start) {
    Vec3 place = start, rate = Vec3::Zero();
    if (supports.moves[pin] != 0) supports.motions[pin].pose(time).place(start, place, rate);
    return place;
  };
  match(supports, wanted, position);
}

void match_velocities(const SlidingSupports& supports, double time, std::span<Vec3> velocity) {
  const auto wanted = [&](int pin, const Vec3& start) {
    Vec3 place = Vec3::Zero(), rate = Vec3::Zero();
    if (supports.moves[pin] != 0) supports.motions[pin].pose(time).place(start, place, rate);
    return rate;
  };
  match(supports, wanted, velocity);
}

}  // namespace weft::sim
