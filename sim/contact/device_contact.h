// The narrow phase of contact on an OpenGL device.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "bsi/detail/surface_terms.h"
#include "sim/contact/contact_pair.h"
#include "sim/contact/contact_search.h"
#include "sim/contact/pair_friction.h"
#include "sim/scene/scene.h"

namespace weft::gpu {
class GlContext;
}

namespace weft::sim {

// With fewer candidates, the CPU is as fast (docs/decisions/0089-narrow-phase-on-the-device.md).
inline constexpr std::size_t least_candidates_for_device = 20'000;

class DeviceContact {
 public:
  virtual ~DeviceContact() = default;

  // Replaces the candidates by those of the lists. `surfaces` has the terms of each body's surface,
  // and `rest` the positions at rest of all surface points, m. O(candidates).
  virtual void set_candidates(std::span<const CandidateList> lists,
                              std::span<const bsi::SurfaceTerms> surfaces,
                              std::span<const Vec3> rest) = 0;

  // Positions (m) and velocities (m/s) of all surface points, and angular velocities (rad/s) of all
  // bodies.
  struct Motion {
    std::span<const Vec3> position, velocity, spin;
  };
  struct Found {
    std::vector<ContactPair> pairs;
    std::vector<Sliding> sliding;
    std::vector<MollifierForce> mollified;
  };
  // A candidate in reach without a gap.
  struct Touching {
    std::array<int, 4> nodes{};
    bool edges = false;
    double thickness = 0;  // m
  };
  // Replaces `found` by what SurfaceContact::evaluate() finds on the CPU: the same pairs in the
  // same order, whose numbers may differ by rounding. Returns the first candidate that touches, if
  // any; `found` is then unspecified. Throws std::runtime_error if the device fails. Precondition:
  // the lists have the pairs of set_candidates().
  virtual std::optional<Touching> evaluate(std::span<const CandidateList> lists,
                                           const PairFriction& friction, const Motion& motion,
                                           Found& found) = 0;
};

std::unique_ptr<DeviceContact> make_device_contact(const Scene& scene,
                                                   std::shared_ptr<gpu::GlContext> context);

}  // namespace weft::sim
