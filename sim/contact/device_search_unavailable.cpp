// Replaces device_search.cpp in builds without gpu/.
#include <stdexcept>

#include "sim/contact/device_search.h"

namespace weft::sim {

DeviceSearch make_device_search(const Scene&, ComputeBackend) {
  throw std::runtime_error("this build has no gpu/ (configure with -DWEFT_GPU=ON)");
}

bool may_have_graphics_processor() { return false; }

}  // namespace weft::sim
