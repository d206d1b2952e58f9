#include "sim/integrator/step_failures.h"

#include <algorithm>
#include <vector>

#include "sim/case/case_text.h"
#include "sim/case/time_methods.h"
#include "sim/integrator/short_steps.h"

namespace weft::sim {

namespace {

struct Reason {
  Failure::Kind kind;
  std::string what;
};

// Returns the reason why a time step fails. `shortest` is the text for the shortest step allowed.
Reason reason_of_steps(StepTrouble trouble, const std::string& shortest) {
  switch (trouble) {
    case StepTrouble::surfaces:
      return {Failure::Kind::surfaces, "no step down to " + shortest + " keeps the surfaces apart"};
    case StepTrouble::overstretched:
      return {Failure::Kind::strain_limit,
              "no step down to " + shortest + " keeps the membranes within their limit"};
    case StepTrouble::error_too_large:
      return {Failure::Kind::error_tolerance,
              "no step down to " + shortest + " meets the error tolerance"};
    case StepTrouble::unstable:
      return {Failure::Kind::unstable, "no step down to " + shortest + " is stable"};
    case StepTrouble::not_finite:
      return {Failure::Kind::not_finite,
              "the forces cannot be evaluated with any step down to " + shortest};
    default:
      return {Failure::Kind::newton,
              "the Newton iteration does not converge with any step down to " + shortest};
  }
}

// Returns the reason why a search for an equilibrium fails. The caller appends the time of the last
// load that has an equilibrium.
Reason reason_of_loads(StepTrouble trouble) {
  switch (trouble) {
    case StepTrouble::surfaces:
      return {Failure::Kind::surfaces, "the surfaces cannot be kept apart beyond the load"};
    case StepTrouble::overstretched:
      return {Failure::Kind::strain_limit,
              "the membranes cannot be kept within their limit beyond the load"};
    case StepTrouble::not_finite:
      return {Failure::Kind::not_finite, "the forces cannot be evaluated beyond the load"};
    default:
      return {Failure::Kind::newton, "no equilibrium is found beyond the load"};
  }
}

std::string words_of_place(Failure::Kind kind, const Scene& scene) {
  if (traits_of(scene.source.time.method).finds_equilibria())
    return ": the forces are farthest from balance at ";
  return kind == Failure::Kind::unstable ? ": the motion is fastest at "
                                         : ": the error is largest at ";
}

}  // namespace

StepTrouble trouble_of(const ContactFault& fault) {
  switch (fault.kind) {
    case ContactFault::Kind::not_finite:
      return StepTrouble::not_finite;
    case ContactFault::Kind::overstretched:
      return StepTrouble::overstretched;
    default:
      return StepTrouble::surfaces;
  }
}

std::optional<ContactFault> pressed_surfaces(Dynamics& dynamics, double time,
                                             std::span<const double> y) {
  const double pressed_part = time > 0 ? 0.01 : 0.5;  // of the range
  if (dynamics.contact() == nullptr) return std::nullopt;
  std::vector<double> rate(y.size());
  if (const auto fault = dynamics.rate(time, y, rate)) return std::nullopt;
  const std::span<const ContactPair> pairs = dynamics.contact()->pairs();
  if (pairs.empty()) return std::nullopt;
  const ContactPair& nearest = *std::ranges::min_element(pairs, {}, &ContactPair::gap);
  if (nearest.gap > pressed_part * dynamics.scene().source.contact.range) return std::nullopt;
  return ContactFault{ContactFault::Kind::pressed, nearest.nodes, nearest.gap};
}

StepTrouble trouble_with(const std::optional<ContactFault>& pressed, StepTrouble trouble) {
  const bool is_symptom =
      trouble == StepTrouble::not_converged || trouble == StepTrouble::error_too_large;
  return pressed && is_symptom ? StepTrouble::surfaces : trouble;
}

Failure placed_failure(Failure::Kind kind, const std::string& what, const FailurePlace& place,
                       const Scene& scene) {
  std::string where;
  if (place.fault) {
    where = ": " + place.fault->describe(scene);
  } else if (place.particle >= 0) {
    where = words_of_place(kind, scene) + scene.describe_particle(place.particle);
  }
  return {kind, place.time, place.fault ? place.fault->particle(scene) : place.particle,
          what + " at t = " + rounded_text(place.time) + " s" + where};
}

Failure shortest_step_failure(StepTrouble trouble, const FailurePlace& place, const Scene& scene) {
  const TimeCase& time = scene.source.time;
  // Few stable steps would not help.
  const bool may_be_short = place.may_be_short && trouble != StepTrouble::unstable;
  const std::string shortest =
      may_be_short
          ? number_text(ShortSteps::shortest_ever(time)) + " s (a thousandth of time.minimum_step)"
          : number_text(time.minimum_step) + " s (time.minimum_step)";
  const Reason reason = traits_of(time.method).finds_equilibria()
                            ? reason_of_loads(trouble)
                            : reason_of_steps(trouble, shortest);
  return placed_failure(reason.kind, reason.what, place, scene);
}

}  // namespace weft::sim
