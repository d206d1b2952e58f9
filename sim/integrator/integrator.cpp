#include "sim/integrator/integrator.h"

#include <cassert>

#include "sim/case/case_text.h"
#include "sim/integrator/cvode_integrator.h"
#include "sim/integrator/integrator_makers.h"

namespace weft::sim {

std::unique_ptr<Integrator> make_integrator(const Scene& scene, Dynamics& dynamics) {
  struct Method {
    TimeMethod method;
    std::unique_ptr<Integrator> (*make)(const Scene&, Dynamics&);
  };
  // Adding a method: its name in TimeMethod and case_schema.cpp, a line here, a file of its own.
  constexpr Method methods[] = {
      {TimeMethod::cvode,
       [](const Scene& s, Dynamics& d) -> std::unique_ptr<Integrator> {
         return std::make_unique<CvodeIntegrator>(s, d);
       }},
      {TimeMethod::arkode, make_arkode_integrator},
      {TimeMethod::euler, make_euler_integrator},
      {TimeMethod::static_loads, make_static_integrator},
      {TimeMethod::implicit_midpoint, make_midpoint_integrator},
      {TimeMethod::verlet, make_verlet_integrator},
  };
  for (const Method& entry : methods) {
    if (entry.method == scene.source.time.method) return entry.make(scene, dynamics);
  }
  assert(false && "a method without a maker");
  return nullptr;
}

std::string frame_failure(const Scene& scene, const ContactFault& fault, double time) {
  return "no frame at t = " + rounded_text(time) +
         " s keeps the surfaces apart: " + fault.describe(scene);
}

}  // namespace weft::sim
