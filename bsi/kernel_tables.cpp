// The table of kernels that goes with the instruction set in use.
#include "bsi/box_build_kernels.h"
#include "bsi/instruction_set.h"

namespace weft::bsi {

// One per instruction set that this build contains.
namespace portable {
extern const BoxBuildKernels box_build_kernels;
}
#if defined(WEFT_X86_KERNELS)
namespace avx2 {
extern const BoxBuildKernels box_build_kernels;
}
namespace avx512 {
extern const BoxBuildKernels box_build_kernels;
}
#endif

const BoxBuildKernels& box_build_kernels() {
#if defined(WEFT_X86_KERNELS)
  if (instruction_set() == InstructionSet::avx512) return avx512::box_build_kernels;
  if (instruction_set() == InstructionSet::avx2) return avx2::box_build_kernels;
#endif
  return portable::box_build_kernels;
}

}  // namespace weft::bsi
