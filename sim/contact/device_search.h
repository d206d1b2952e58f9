// The pair search on an OpenGL device.
#pragma once

#include <memory>
#include <string>

#include "sim/contact/pair_search.h"

namespace weft::sim {

struct DeviceSearch {
  std::unique_ptr<PairSearch> search;
  std::string device;  // name of the device in OpenGL
};

// Makes a search on an OpenGL device. `backend` is gpu or osmesa (EGL software if OSMesa is
// missing). Throws std::runtime_error with the reason if there is no such device, or if it cannot
// hold the bodies of the scene. The functions of the search throw std::runtime_error if the device
// fails.
DeviceSearch make_device_search(const Scene& scene, ComputeBackend backend);

// Returns true if the machine may have a graphics processor that this build can use. Loads no
// library.
bool may_have_graphics_processor();

}  // namespace weft::sim
