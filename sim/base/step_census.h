// The lengths of the steps of a run, and what limited them.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

namespace weft::sim {

// The cause of the length of an accepted step. If trials of the step failed, this is the cause of
// the last failure. Otherwise, the largest part of the estimated error limited the step. Parts are
// those of positions and velocities, of particles in contact and of free ones. A step that neither
// failed nor has an error estimate has the length that the case, a frame or a motion gives.
enum class StepLimit : std::uint8_t {
  given,
  convergence,
  surfaces,
  free_position_error,
  free_velocity_error,
  contact_position_error,
  contact_velocity_error,
};
inline constexpr std::array step_limit_names{
    "given",
    "convergence",
    "surfaces",
    "free_position_error",
    "free_velocity_error",
    "contact_position_error",
    "contact_velocity_error",
};

// The sums of squares of the parts of a weighted error.
struct ErrorParts {
  // First index: 0 for free particles, 1 for those in contact. Second index: 0 for positions, 1 for
  // velocities.
  std::array<std::array<double, 2>, 2> sum{};

  StepLimit largest() const {
    StepLimit result = StepLimit::free_position_error;
    double most = sum[0][0];
    const auto take = [&](double candidate, StepLimit limit) {
      if (candidate > most) {
        most = candidate;
        result = limit;
      }
    };
    take(sum[0][1], StepLimit::free_velocity_error);
    take(sum[1][0], StepLimit::contact_position_error);
    take(sum[1][1], StepLimit::contact_velocity_error);
    return result;
  }
};

// Counts of accepted steps, by length and by limit.
struct StepCensus {
  // Upper ends of the classes of length (s): 1, 2 and 5 times the powers of ten. The first class
  // begins at 0. The last class has no upper end.
  static constexpr std::array ends{1e-7, 2e-7, 5e-7, 1e-6, 2e-6, 5e-6, 1e-5, 2e-5, 5e-5, 1e-4, 2e-4,
                                   5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2, 5e-2, 1e-1, 2e-1, 5e-1, 1.0};

  std::array<std::int64_t, ends.size() + 1> by_length{};
  std::array<std::int64_t, step_limit_names.size()> by_limit{};

  // Lengths are differences of times, whose rounding must not part steps of the same length.
  static constexpr double rounding = 1e-6;

  void add(double length, StepLimit limit) {
    const auto end = std::upper_bound(ends.begin(), ends.end(), length * (1 + rounding));
    ++by_length[static_cast<std::size_t>(end - ends.begin())];
    ++by_limit[static_cast<std::size_t>(limit)];
  }
  StepCensus& operator+=(const StepCensus& more) {
    for (std::size_t i = 0; i < by_length.size(); ++i) by_length[i] += more.by_length[i];
    for (std::size_t i = 0; i < by_limit.size(); ++i) by_limit[i] += more.by_limit[i];
    return *this;
  }
};

}  // namespace weft::sim
