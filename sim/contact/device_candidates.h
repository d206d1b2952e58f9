// The candidates of contact in the layout of gpu::ComputeNarrowPhase.
#pragma once

#include <span>
#include <vector>

#include "bsi/detail/surface_terms.h"
#include "gpu/compute_narrow_phase.h"
#include "sim/contact/contact_search.h"
#include "sim/contact/pair_friction.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// Rows and candidates of all lists, in the order in which SurfaceContact measures them. They hold
// for as long as the lists keep their pairs.
struct DeviceCandidates {
  std::vector<gpu::ContactRow> rows;
  std::vector<gpu::ContactCandidate> candidates;
};

// `surfaces` has the terms of each body's surface, and `rest` the positions at rest of all surface
// points, m. O(candidates).
DeviceCandidates device_candidates(const Scene& scene, std::span<const CandidateList> lists,
                                   std::span<const bsi::SurfaceTerms> surfaces,
                                   std::span<const Vec3> rest);

// Returns the groups of device_candidates() with the present drift of the lists. `spins` has the
// angular velocities (rad/s) of all bodies.
std::vector<gpu::ContactGroup> device_groups(const Scene& scene,
                                             std::span<const CandidateList> lists,
                                             const PairFriction& friction,
                                             std::span<const Vec3> spins);

}  // namespace weft::sim
