// Chooses the processor that runs the contact search of a scene, and states the reason.
#pragma once

#include <memory>
#include <string>

#include "sim/contact/pair_search.h"

namespace weft::sim {

struct ComputeChoice {
  ComputeBackend backend = ComputeBackend::cpu;  // never `automatic`
  std::string device;                            // name of the device in OpenGL; empty on the CPU
  std::string reason;

  // Returns the processor and the reason as text, for example "CPU: there is no graphics
  // processor".
  std::string text() const;
};

struct ChosenSearch {
  std::unique_ptr<PairSearch> search;
  ComputeChoice choice;
};

// Chooses the processor by compute.backend of the case. With `auto`, a graphics processor runs the
// search if the machine has one that works and is faster than the CPU. Both processors are timed on
// this scene. Throws CaseError if the case asks for a device that is missing or too small for the
// scene.
ChosenSearch choose_search(const Scene& scene);

}  // namespace weft::sim
