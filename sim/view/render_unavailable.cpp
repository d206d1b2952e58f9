// Replacement for render_trajectory.cpp if Weft is built without gpu/.
#include <stdexcept>

#include "sim/view/render_trajectory.h"

namespace weft::sim {

RenderReport render_trajectory(const std::string&, const std::string&, const RenderOptions&) {
  throw std::runtime_error("this build has no gpu/ (configure with -DWEFT_GPU=ON)");
}

}  // namespace weft::sim
