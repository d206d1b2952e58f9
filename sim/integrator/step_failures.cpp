#include "sim/integrator/step_failures.h"

#include "sim/case/case_text.h"

namespace weft::sim {

namespace {

struct Words {
  Failure::Kind kind;
  const char *before, *after;  // the length of the shortest step
};

Words words_of(StepTrouble trouble) {
  switch (trouble) {
    case StepTrouble::surfaces:
      return {Failure::Kind::surfaces, "no step down to ", " keeps the surfaces apart"};
    case StepTrouble::error_too_large:
      return {Failure::Kind::error_tolerance, "no step down to ", " meets the error tolerance"};
    case StepTrouble::unstable:
      return {Failure::Kind::unstable, "no step down to ", " is stable"};
    case StepTrouble::not_finite:
      return {Failure::Kind::not_finite, "the forces cannot be evaluated with any step down to ",
              ""};
    default:
      return {Failure::Kind::newton,
              "the Newton iteration does not converge with any step down to ", ""};
  }
}

}  // namespace

Failure placed_failure(Failure::Kind kind, const std::string& what, const FailurePlace& place,
                       const Scene& scene) {
  const bool is_unstable = kind == Failure::Kind::unstable;
  std::string where;
  if (place.fault) {
    where = ": " + place.fault->describe(scene);
  } else if (place.particle >= 0) {
    where = is_unstable ? ": the motion is fastest at " : ": the error is largest at ";
    where += scene.describe_particle(place.particle);
  }
  return {kind, place.time, place.fault ? place.fault->particle(scene) : place.particle,
          what + " at t = " + rounded_text(place.time) + " s" + where};
}

Failure shortest_step_failure(StepTrouble trouble, const FailurePlace& place, const Scene& scene) {
  const Words words = words_of(trouble);
  return placed_failure(words.kind,
                        words.before + number_text(scene.source.time.minimum_step) +
                            " s (time.minimum_step)" + words.after,
                        place, scene);
}

}  // namespace weft::sim
