#include "sim/integrator/integrator.h"

#include <array>

#include "sim/case/case_text.h"
#include "sim/case/time_methods.h"
#include "sim/integrator/integrator_makers.h"

namespace weft::sim {

namespace {

struct MethodMaker {
  TimeMethod method;
  std::unique_ptr<Integrator> (*make)(const Scene&, Dynamics&);
};

// The makers of the integrators, in the order of TimeMethod. A new method needs a name in
// TimeMethod, a line in sim/case/time_methods.cpp, a line here, a declaration in
// integrator_makers.h and a file of its own. is_in_order_of_methods() must name the last method of
// TimeMethod.
constexpr std::array makers{
    MethodMaker{TimeMethod::cvode, make_cvode_integrator},
    MethodMaker{TimeMethod::arkode, make_arkode_integrator},
    MethodMaker{TimeMethod::euler, make_euler_integrator},
    MethodMaker{TimeMethod::static_loads, make_static_integrator},
    MethodMaker{TimeMethod::implicit_midpoint, make_midpoint_integrator},
    MethodMaker{TimeMethod::verlet, make_verlet_integrator},
    MethodMaker{TimeMethod::impulses, make_impulse_integrator},
};
static_assert(is_in_order_of_methods(makers));

}  // namespace

std::unique_ptr<Integrator> make_integrator(const Scene& scene, Dynamics& dynamics) {
  return makers[static_cast<std::size_t>(scene.source.time.method)].make(scene, dynamics);
}

Failure frame_failure(const Scene& scene, const ContactFault& fault, double time) {
  return {Failure::Kind::surfaces, time, fault.particle(scene),
          "no frame at t = " + rounded_text(time) +
              " s keeps the surfaces apart: " + fault.describe(scene)};
}

}  // namespace weft::sim
