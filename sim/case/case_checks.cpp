#include "sim/case/case_checks.h"

#include <algorithm>
#include <limits>
#include <map>

#include "sim/case/case_error.h"
#include "sim/case/case_output_checks.h"
#include "sim/case/case_schema.h"
#include "sim/case/case_shape_checks.h"
#include "sim/case/case_text.h"
#include "sim/case/channels.h"
#include "sim/case/cloth_checks.h"
#include "sim/case/contact_pair_checks.h"
#include "sim/case/fabric_checks.h"
#include "sim/case/memory_estimate.h"
#include "sim/case/particles_checks.h"
#include "sim/case/static_checks.h"
#include "sim/case/support_checks.h"
#include "sim/case/time_methods.h"

namespace weft::sim {

namespace {

// Largest tolerances per contact.range. The barrier is steep: positions that are wrong by a
// noticeable part of a gap mean forces that are wrong by a large factor.
constexpr double position_tolerance_per_range = 0.005;
constexpr double velocity_tolerance_per_range = 0.5;  // 1/s
// Highest BDF order that needs neither damping nor a tight tolerance. Orders 3 to 5 need both.
constexpr int highest_unconditional_order = 2;
constexpr double high_order_tolerance = 1e-6;  // m; largest position_tolerance of higher orders
// Factor by which a value may exceed its limit due to rounding: 0.005 * 7e-3 and 3.5e-5 differ in
// the last bit.
constexpr double rounding = 1 + 1e-9;
// Smallest time_scale of a gust per minimum_step. Steps in a gust are at most 0.0193 of its
// time_scale (sim/scene/gust.h). Where several share an interval they may be half as long, but no
// shorter than minimum_step.
constexpr double gust_per_minimum_step = 104;

class CaseChecker {
 public:
  CaseChecker(const Case& target, const Locations& locations)
      : case_(target), locations_(locations) {}

  void check() const {
    steps();
    orders();
    tolerances();
    names();
    check_particles(case_, locations_);
    materials();
    check_contact_pairs(case_, locations_);
    check_fabrics(case_, locations_);
    check_static(case_, locations_);
    check_loads_and_supports(case_, locations_);
    check_cloth(case_, locations_);
    supports();
    channels();
    check_output(case_, locations_);
    for (std::size_t i = 0; i < case_.body.size(); ++i) {
      const std::string path = join_path("body", i);
      check_shape(case_.body[i].shape, join_path(path, "shape"), case_.path, locations_);
      if (case_.body[i].start) {
        check_start(*case_.body[i].start, case_.body[i].shape, join_path(path, "start"), case_.path,
                    locations_);
      }
      for (std::size_t j = 0; j < case_.body[i].pin.size(); ++j) {
        const PinCase& pin = case_.body[i].pin[j];
        const std::string pin_path = join_path(join_path(path, "pin"), j);
        check_selection(pin.vertices, "pin", case_.body[i].shape, pin_path, locations_);
        clamp(pin, case_.body[i], pin_path);
        pin_times(pin, pin_path);
        if (pin.motion) motion(*pin.motion, join_path(pin_path, "motion"));
      }
    }
    for (std::size_t i = 0; i < case_.obstacle.size(); ++i) {
      const ObstacleCase& obstacle = case_.obstacle[i];
      const std::string path = join_path("obstacle", i);
      check_shape(obstacle.shape, join_path(path, "shape"), case_.path, locations_);
      if (obstacle.motion) motion(*obstacle.motion, join_path(path, "motion"));
    }
    for (std::size_t i = 0; i < case_.tie.size(); ++i) tie(case_.tie[i], join_path("tie", i));
    memory();
  }

 private:
  [[noreturn]] void fail(const std::string& path, const std::string& message,
                         const std::string& hint) const {
    throw CaseError(locations_.value(path), message, hint);
  }

  void steps() const {
    const TimeCase& time = case_.time;
    const double frame = 1 / time.frames_per_second;
    if (time.minimum_step >= frame) {
      fail(first_given("time.minimum_step", "time.frames_per_second"),
           "the minimum_step is " + number_text(time.minimum_step) + " s",
           "expected less than the time between frames, " + rounded_text(frame) + " s");
    }
    if (traits_of(time.method).steps == TimeMethodTraits::Steps::fixed && !time.step) {
      fail("time.method", "this method needs a step", "expected time.step");
    }
    if (time.step && *time.step <= time.minimum_step) {
      fail("time.step", "the step is " + number_text(*time.step) + " s",
           "expected more than the minimum_step, " + number_text(time.minimum_step) + " s");
    }
    if (time.step && *time.step > time.duration * rounding) {
      fail(first_given("time.step", "time.duration"),
           "the step is " + number_text(*time.step) + " s, longer than the run",
           "expected at most the duration, " + number_text(time.duration) + " s");
    }
    if (time.step && time.maximum_step) {
      fail("time.maximum_step", "a maximum_step beside a fixed step",
           "expected one of maximum_step and step");
    }
    if (time.maximum_step && *time.maximum_step <= time.minimum_step) {
      fail("time.maximum_step", "the maximum_step is " + number_text(*time.maximum_step) + " s",
           "expected more than the minimum_step, " + number_text(time.minimum_step) + " s");
    }
    gust();
  }

  // Refuses gusts whose fastest wave steps of time.minimum_step do not resolve.
  void gust() const {
    const auto* gust = std::get_if<GustCase>(&case_.world.wind.form);
    const double least = gust_per_minimum_step * case_.time.minimum_step;
    if (gust == nullptr || gust->time_scale * rounding >= least) return;
    fail("world.wind.time_scale",
         "the time_scale of the gusts is " + number_text(gust->time_scale) + " s",
         "expected at least " + number_text(gust_per_minimum_step) + " times the minimum_step, " +
             rounded_text(least) + " s");
  }

  // Returns `first` if the case gives a value at that path, else `second`.
  std::string first_given(const std::string& first, const std::string& second) const {
    return locations_.given(first) ? first : second;
  }

  void orders() const {
    if (case_.time.maximum_order <= highest_unconditional_order) return;
    const std::string order = "order " + std::to_string(case_.time.maximum_order);
    if (case_.time.position_tolerance > high_order_tolerance * rounding) {
      fail("time.maximum_order", order + " is wrong at loose tolerances",
           "expected a position_tolerance <= " + number_text(high_order_tolerance) +
               " with it, or maximum_order = 2");
    }
    for (const MaterialCase& material : case_.material) {
      if (smallest(material.mass_damping) > 0 || smallest(material.membrane_damping_time()) > 0)
        continue;
      fail("time.maximum_order", order + " is wrong without damping",
           "expected mass_damping, stiffness_damping or loss_factor > 0 in " +
               heading(join_path("material", material.name)) + ", or maximum_order = 2");
    }
  }

  void tolerances() const {
    if (!case_.contact.enabled || traits_of(case_.time.method).is_explicit) return;
    const double range = case_.contact.range;
    const double position_limit = position_tolerance_limit(case_);
    // If time.accuracy will set the tolerance, the present one does not matter.
    if (!case_.awaits_accuracy() && case_.time.position_tolerance > position_limit * rounding) {
      fail(first_given("time.position_tolerance", "contact.range"),
           "a position_tolerance of " + number_text(case_.time.position_tolerance) +
               " m is too loose for a contact.range of " + number_text(range) + " m",
           "expected a position_tolerance <= 0.005 of contact.range, " +
               rounded_text(position_limit) + " m");
    }
    const double velocity_limit = velocity_tolerance_per_range * range;
    if (case_.time.velocity_tolerance &&
        *case_.time.velocity_tolerance > velocity_limit * rounding) {
      fail("time.velocity_tolerance",
           "a velocity_tolerance of " + number_text(*case_.time.velocity_tolerance) +
               " m/s is too loose for a contact.range of " + number_text(range) + " m",
           "expected a velocity_tolerance <= 0.5 /s of contact.range, " +
               rounded_text(velocity_limit) + " m/s");
    }
  }

  // Refuses a name that two bodies, obstacles or groups of particles share, because the trajectory
  // stores obstacles as bodies, and messages name all three alike.
  void names() const {
    std::map<std::string, std::string> owners;  // name -> path
    const auto claim = [&](const std::string& name, const std::string& path) {
      const auto [owner, is_new] = owners.emplace(name, path);
      if (is_new) return;
      const SourceLocation first = locations_.value(join_path(owner->second, "name"));
      const bool elsewhere = first.file != locations_.value(join_path(path, "name")).file;
      fail(join_path(path, "name"), "a second " + in_quotes(name),
           "expected a name that no other body, obstacle or particles have; the first is in " +
               heading(owner->second) + (elsewhere ? ", " + place_text(first) : ""));
    };
    for (std::size_t i = 0; i < case_.body.size(); ++i) {
      claim(case_.body[i].name, join_path("body", i));
    }
    for (std::size_t i = 0; i < case_.obstacle.size(); ++i) {
      claim(case_.obstacle[i].name, join_path("obstacle", i));
    }
    for (std::size_t i = 0; i < case_.particles.size(); ++i) {
      claim(case_.particles[i].name, join_path("particles", i));
    }
  }

  // Refuses a case that needs too much memory. The error is placed at the largest shape.
  void memory() const {
    const SceneSize size = size_of_case(case_);
    const std::string reason = reason_of_memory(case_, size);
    if (reason.empty()) return;
    const std::size_t shape = largest_shape(case_, size);
    const std::size_t surfaces = size.body.size() + size.obstacle.size();
    if (shape >= surfaces)
      fail(join_path(join_path("particles", shape - surfaces), "positions"), reason, memory_hint);
    const std::string owner = shape < size.body.size()
                                  ? join_path("body", shape)
                                  : join_path("obstacle", shape - size.body.size());
    fail(join_path(owner, "shape.resolution"), reason, memory_hint);
  }

  void materials() const {
    std::vector<std::string> known;
    for (const MaterialCase& material : case_.material) known.push_back(material.name);
    for (std::size_t i = 0; i < case_.body.size(); ++i) {
      material(case_.body[i].material, join_path("body", i), known);
    }
    for (std::size_t i = 0; i < case_.obstacle.size(); ++i) {
      const std::string& name = case_.obstacle[i].material;
      if (!name.empty()) material(name, join_path("obstacle", i), known);
    }
    shells();
  }
  void material(const std::string& name, const std::string& owner,
                const std::vector<std::string>& known) const {
    if (std::ranges::find(known, name) != known.end()) return;
    fail(join_path(owner, "material"), "unknown material " + in_quotes(name),
         name_hint(name, known));
  }
  void shells() const {
    for (const MaterialCase& material : case_.material) {
      if (!material.is_shell() || material.poisson_ratio <= 0.5) continue;
      fail(join_path(join_path("material", material.name), "poisson_ratio"),
           "poisson_ratio is " + number_text(material.poisson_ratio),
           "expected at most 0.5 with model = \"shell\": a solid whose ratio is larger would gain "
           "energy under pressure");
    }
    for (std::size_t i = 0; i < case_.body.size(); ++i) {
      const BodyCase& body = case_.body[i];
      const auto material = std::ranges::find(case_.material, body.material, &MaterialCase::name);
      if (!body.control_net || material->is_shell()) continue;
      fail(join_path(join_path("body", i), "control_net"),
           "a control_net of body " + in_quotes(body.name) + ", which is no shell",
           "expected model = \"shell\" in " + heading(join_path("material", body.material)));
    }
  }

  // Refuses a body that nothing can hold, if the method seeks equilibria under gravity: the body
  // would fall forever.
  void supports() const {
    if (!traits_of(case_.time.method).finds_equilibria() || case_.world.gravity.is_zero()) return;
    const auto is_pinned = [](const BodyCase& body) { return !body.pin.empty(); };
    const bool can_rest = case_.contact.enabled &&
                          (!case_.obstacle.empty() || std::ranges::any_of(case_.body, is_pinned));
    if (can_rest) return;
    const std::vector<std::string> held = held_by_ties();
    for (std::size_t i = 0; i < case_.body.size(); ++i) {
      if (is_pinned(case_.body[i]) || std::ranges::find(held, case_.body[i].name) != held.end())
        continue;
      fail(join_path(join_path("body", i), "name"),
           "nothing holds body " + in_quotes(case_.body[i].name) +
               ": under gravity it has no equilibrium (time.method = \"static\")",
           "expected a pin, a tie, a seam, or an obstacle or a pinned body that it can rest on, "
           "with contact");
    }
  }

  // Returns the names of bodies without pins that ties or seams connect to a pinned body or an
  // obstacle, directly or through other bodies.
  std::vector<std::string> held_by_ties() const {
    std::vector<std::string> held;
    const auto is_held = [&](const std::string& name) {
      const auto body = std::ranges::find(case_.body, name, &BodyCase::name);
      return body == case_.body.end() || !body->pin.empty() ||
             std::ranges::find(held, name) != held.end();
    };
    bool found = true;
    while (found) {
      found = false;
      const auto add = [&](const auto& joint) {
        if (is_held(joint.body) == is_held(joint.to)) return;
        held.push_back(is_held(joint.body) ? joint.to : joint.body);
        found = true;
      };
      for (const TieCase& each : case_.tie) add(each);
      for (const SeamCase& each : case_.seam) add(each);
    }
    return held;
  }

  void clamp(const PinCase& pin, const BodyCase& body, const std::string& path) const {
    const auto material = std::ranges::find(case_.material, body.material, &MaterialCase::name);
    if (!pin.clamp || material->is_shell() || material->resists_bending()) return;
    fail(join_path(path, "clamp"),
         "a clamp of body " + in_quotes(body.name) + ", whose material does not resist bending",
         "expected bending_stiffness > 0 or orthotropic_bending in " +
             heading(join_path("material", body.material)));
  }

  void tie(const TieCase& target, const std::string& path) const {
    std::vector<std::string> bodies, others;
    for (const BodyCase& body : case_.body) bodies.push_back(body.name);
    const auto body = std::ranges::find(case_.body, target.body, &BodyCase::name);
    if (body == case_.body.end()) {
      fail(join_path(path, "body"), "no body " + in_quotes(target.body),
           name_hint(target.body, bodies));
    }
    for (const std::string& name : bodies) {
      if (name != target.body) others.push_back(name);
    }
    for (const ObstacleCase& obstacle : case_.obstacle) others.push_back(obstacle.name);
    if (std::ranges::find(others, target.to) == others.end()) {
      fail(join_path(path, "to"),
           target.to == target.body ? "a tie of body " + in_quotes(target.to) + " to itself"
                                    : "no body or obstacle " + in_quotes(target.to),
           others.empty() ? "expected another body or an obstacle, and the case has none"
                          : name_hint(target.to, others));
    }
    check_selection(target.vertices, "tie", body->shape, path, locations_);
    if (target.break_force && traits_of(case_.time.method).finds_equilibria()) {
      fail(join_path(path, "break_force"),
           "\"break_force\" does not go with time.method = \"static\"",
           "expected a method that follows the motion in time, or a tie that holds");
    }
  }

  void channels() const {
    const std::vector<std::string>& names = case_.output.channels;
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string place = join_path("output.channels", i);
      if (std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(i), names[i]) !=
          names.begin() + static_cast<std::ptrdiff_t>(i)) {
        fail(place, in_quotes(names[i]) + " is listed twice", "expected each channel once");
      }
      for (const Channel& channel : all_channels()) {
        if (names[i] != channel.name) continue;
        std::string hint;
        const std::string reason = reason_against(channel, case_, hint);
        if (!reason.empty()) fail(place, reason, hint);
      }
    }
  }

  void pin_times(const PinCase& pin, const std::string& path) const {
    for (const char* key : {"hold_time", "release_time"}) {
      const std::string place = join_path(path, key);
      if (!locations_.given(place) || !traits_of(case_.time.method).finds_equilibria()) continue;
      // The text of a resolved case gives the default, 0, which does not matter.
      if (pin.hold_time == 0 && !pin.release_time) continue;
      fail(place, in_quotes(key) + " does not go with time.method = \"static\"",
           "expected a method that follows the motion in time, or a pin that always holds");
    }
    if (pin.release_time && *pin.release_time <= pin.hold_time) {
      fail(join_path(path, "release_time"),
           "release_time is " + number_text(*pin.release_time) + " s",
           "expected later than hold_time, " + number_text(pin.hold_time) + " s");
    }
  }

  void motion(const MotionCase& target, const std::string& path) const {
    if (target.stop_time && *target.stop_time <= target.start_time) {
      fail(join_path(path, "stop_time"), "stop_time is " + number_text(*target.stop_time) + " s",
           "expected later than start_time, " + number_text(target.start_time) + " s");
    }
    for (std::size_t i = 1; i < target.keyframes.size(); ++i) {
      const double before = target.keyframes[i - 1].time;
      const double time = target.keyframes[i].time;
      if (time > before) continue;
      const std::string keyframe = join_path(join_path(path, "keyframes"), i);
      fail(join_path(keyframe, "time"), "a keyframe at " + number_text(time) + " s",
           "expected later than the keyframe before, " + number_text(before) + " s");
    }
  }

  const Case& case_;
  const Locations& locations_;
};

}  // namespace

double position_tolerance_limit(const Case& target) {
  return target.contact.enabled ? position_tolerance_per_range * target.contact.range
                                : std::numeric_limits<double>::infinity();
}

std::string long_step_notice(const TimeCase& time) {
  const double frame = 1 / time.frames_per_second;
  constexpr double typed = 1 + 1e-4;  // of steps such as 0.0166667
  if (!time.step || *time.step <= frame * typed) return {};
  return "time.step, " + number_text(*time.step) + " s, is longer than the time between frames, " +
         rounded_text(frame) + " s: frames within a step are interpolated";
}

std::string late_pins_notice(const Case& target) {
  const double end = target.time.duration;
  for (const BodyCase& body : target.body) {
    for (const PinCase& pin : body.pin) {
      const bool holds_late = pin.hold_time >= end;
      if (!holds_late && pin.release_time.value_or(0) < end) continue;
      return (holds_late ? "hold_time, " + number_text(pin.hold_time)
                         : "release_time, " + number_text(*pin.release_time)) +
             " s, of a pin of body " + in_quotes(body.name) + " is not within the run of " +
             number_text(end) + " s: the pin never " + (holds_late ? "holds" : "lets go");
    }
  }
  return {};
}

std::string idle_device_notice(const Case& target) {
  const ComputeBackend backend = target.compute.backend;
  const bool is_device = backend == ComputeBackend::gpu || backend == ComputeBackend::osmesa;
  const bool has_particles = !target.particles.empty();
  if (!is_device || (target.contact.enabled && !has_particles)) return {};
  return std::string("compute.backend, \"") + (backend == ComputeBackend::gpu ? "gpu" : "osmesa") +
         "\", has no effect: " +
         (target.contact.enabled ? "the CPU searches particles" : "contact is off");
}

void check_case(const Case& target, const Locations& locations) {
  CaseChecker(target, locations).check();
}

}  // namespace weft::sim
