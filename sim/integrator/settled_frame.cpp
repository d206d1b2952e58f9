#include "sim/integrator/settled_frame.h"

#include "sim/integrator/integrator.h"

namespace weft::sim {

std::optional<Failure> settle_frame(Dynamics& dynamics, double time, double part,
                                    const StepEnds& step, std::span<double> y,
                                    std::vector<Vec3>& position, std::vector<Vec3>& velocity) {
  Contact* contact = dynamics.contact();
  if (contact == nullptr) return std::nullopt;
  dynamics.expand(time, y, position, velocity);
  if (!contact->check_path(step.start_positions, position)) return std::nullopt;
  for (std::size_t i = 0; i < y.size(); ++i) y[i] = (1 - part) * step.start[i] + part * step.end[i];
  dynamics.expand(time, y, position, velocity);
  const auto fault = contact->check_crossing(step.start_positions, position);
  return fault ? std::optional(frame_failure(dynamics.scene(), *fault, time)) : std::nullopt;
}

}  // namespace weft::sim
