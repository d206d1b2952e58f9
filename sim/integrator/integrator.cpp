#include "sim/integrator/integrator.h"

#include <cassert>

#include "sim/case/case_text.h"
#include "sim/case/time_methods.h"
#include "sim/integrator/integrator_makers.h"

namespace weft::sim {

std::unique_ptr<Integrator> make_integrator(const Scene& scene, Dynamics& dynamics) {
  // To add a method, add its name to TimeMethod, its line to sim/case/time_methods.cpp and to this
  // table in the same order, and a file of its own.
  using Maker = std::unique_ptr<Integrator> (*)(const Scene&, Dynamics&);
  constexpr Maker makers[] = {make_cvode_integrator,    make_arkode_integrator,
                              make_euler_integrator,    make_static_integrator,
                              make_midpoint_integrator, make_verlet_integrator};
  assert(std::size(makers) == time_methods().size());
  return makers[static_cast<std::size_t>(scene.source.time.method)](scene, dynamics);
}

Failure frame_failure(const Scene& scene, const ContactFault& fault, double time) {
  return {Failure::Kind::surfaces, time, fault.particle(scene),
          "no frame at t = " + rounded_text(time) +
              " s keeps the surfaces apart: " + fault.describe(scene)};
}

}  // namespace weft::sim
