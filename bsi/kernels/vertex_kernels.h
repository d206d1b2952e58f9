// Kernels that load the vertices of pyramids, one table per instruction set. An internal header of
// bsi/; it must stay free of inline functions (see bsi/detail/instruction_set.h).
#pragma once

#include <cstdint>

namespace weft::bsi {

struct VertexKernels {
  // Rounds `count` positions (x, y, z each) to float32 and stores them by component. Position i is
  // that of particle[i], or of particle i if `particle` is null. Returns false if a coordinate is
  // NaN or its magnitude reaches `limit`.
  bool (*load)(const double* positions, const std::int32_t* particle, int count, float limit,
               float* const component[3]);
};

// Returns the table for instruction_set().
const VertexKernels& vertex_kernels();

}  // namespace weft::bsi
