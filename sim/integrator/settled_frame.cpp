#include "sim/integrator/settled_frame.h"

#include "sim/integrator/integrator.h"

namespace weft::sim {

std::optional<Failure> settle_frame(Dynamics& dynamics, double time, double part,
                                    const StepEnds& step, std::span<double> y,
                                    std::vector<Vec3>& position, std::vector<Vec3>& velocity) {
  const auto straighten = [&] {
    for (std::size_t i = 0; i < y.size(); ++i)
      y[i] = (1 - part) * step.start[i] + part * step.end[i];
  };
  if (dynamics.check_limits(time, y)) straighten();
  if (dynamics.contact() == nullptr) return std::nullopt;
  dynamics.expand(time, y, position, velocity);
  const auto check = [&](bool gap) {
    return dynamics.check_straight_path(step.start_time, step.start_positions, time, position, gap);
  };
  if (!check(true)) return std::nullopt;
  straighten();
  dynamics.expand(time, y, position, velocity);
  const auto fault = check(false);
  return fault ? std::optional(frame_failure(dynamics.scene(), *fault, time)) : std::nullopt;
}

}  // namespace weft::sim
