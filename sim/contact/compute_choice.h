// The choice of the processor that runs the contact search of a scene, and its reason.
#pragma once

#include <memory>
#include <string>

#include "sim/contact/pair_search.h"

namespace weft::sim {

struct ComputeChoice {
  ComputeBackend backend = ComputeBackend::cpu;  // never `automatic`
  std::string device;                            // OpenGL's name of it; empty on the CPU
  std::string reason;

  // Returns, for example, "CPU: there is no graphics processor", for `weft check`, logs and
  // trajectories.
  std::string text() const;
};

struct ChosenSearch {
  std::unique_ptr<PairSearch> search;
  ComputeChoice choice;
};

// Chooses by compute.backend of the case. `auto` takes a graphics processor if there is one and it
// is faster on the bodies of this scene, which is measured (a fraction of a second). Otherwise it
// takes the CPU. Throws CaseError if the case names a device that is missing.
ChosenSearch choose_search(const Scene& scene);

}  // namespace weft::sim
