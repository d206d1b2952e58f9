// Takes the place of gpu.cpp where Weft is built without gpu/.
#include <stdexcept>

#include "bench/experiments.h"

namespace weft::bench {

int run_gpu(const GpuOptions&) {
  throw std::runtime_error("this build has no gpu/ (configure with -DWEFT_GPU=ON)");
}

}  // namespace weft::bench
