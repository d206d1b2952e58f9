// Replacement for render_trajectory.cpp and start_picture.cpp if Weft is built without gpu/.
#include <stdexcept>

#include "sim/base/file_error.h"
#include "sim/view/render_trajectory.h"
#include "sim/view/start_picture.h"

namespace weft::sim {

RenderReport render_trajectory(const std::string&, const std::string&, const RenderOptions&) {
  throw std::runtime_error("this build has no gpu/ (configure with -DWEFT_GPU=ON)");
}

int draw_start(const Scene&, std::span<const Crossing>, const std::string&, bool) {
  throw FileError("this build has no gpu/ (configure with -DWEFT_GPU=ON)");
}

}  // namespace weft::sim
