// The pair search on an OpenGL device.
#pragma once

#include <memory>
#include <string>

#include "sim/contact/pair_search.h"

namespace weft::sim {

struct DeviceSearch {
  std::unique_ptr<PairSearch> search;
  std::string device;  // its name in OpenGL
};

// Makes a search on the device of `backend`: gpu or osmesa (EGL software if OSMesa is missing).
// Throws std::runtime_error with the reason if there is no such device, or if it cannot hold the
// bodies of the scene. The functions of the search throw the same if the device fails.
DeviceSearch make_device_search(const Scene& scene, ComputeBackend backend);

// Returns true if the machine has a device that may be a graphics processor. Loads no library.
bool may_have_graphics_processor();

}  // namespace weft::sim
