// The pair search on a device of OpenGL.
#pragma once

#include <memory>
#include <string>

#include "sim/contact/pair_search.h"

namespace weft::sim {

struct DeviceSearch {
  std::unique_ptr<PairSearch> search;
  std::string device;  // as OpenGL names it
};

// `backend`: gpu or osmesa (EGL software where OSMesa is missing). Throws std::runtime_error with
// the reason when there is no such device, or it cannot hold the bodies of the scene; the functions
// of the search throw it too, when the device fails.
DeviceSearch make_device_search(const Scene& scene, ComputeBackend backend);

// True if the machine has a device that may be a graphics processor. Loads no library.
bool may_have_graphics_processor();

}  // namespace weft::sim
