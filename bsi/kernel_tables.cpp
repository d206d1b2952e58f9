// The tables of kernels that go with the instruction set in use.
#include "bsi/box_build_kernels.h"
#include "bsi/feature_kernels.h"
#include "bsi/instruction_set.h"
#include "bsi/narrow_phase_kernels.h"

namespace weft::bsi {

// One of each per instruction set that this build contains.
namespace portable {
extern const BoxBuildKernels box_build_kernels;
extern const FeatureKernels feature_kernels;
extern const NarrowPhaseKernels narrow_phase_kernels;
}  // namespace portable
#if defined(WEFT_X86_KERNELS)
namespace avx2 {
extern const BoxBuildKernels box_build_kernels;
extern const FeatureKernels feature_kernels;
extern const NarrowPhaseKernels narrow_phase_kernels;
}  // namespace avx2
namespace avx512 {
extern const BoxBuildKernels box_build_kernels;
extern const FeatureKernels feature_kernels;
extern const NarrowPhaseKernels narrow_phase_kernels;
}  // namespace avx512
#endif

const BoxBuildKernels& box_build_kernels() {
#if defined(WEFT_X86_KERNELS)
  if (instruction_set() == InstructionSet::avx512) return avx512::box_build_kernels;
  if (instruction_set() == InstructionSet::avx2) return avx2::box_build_kernels;
#endif
  return portable::box_build_kernels;
}

const NarrowPhaseKernels& narrow_phase_kernels() {
#if defined(WEFT_X86_KERNELS)
  if (instruction_set() == InstructionSet::avx512) return avx512::narrow_phase_kernels;
  if (instruction_set() == InstructionSet::avx2) return avx2::narrow_phase_kernels;
#endif
  return portable::narrow_phase_kernels;
}

const FeatureKernels& feature_kernels() {
#if defined(WEFT_X86_KERNELS)
  if (instruction_set() == InstructionSet::avx512) return avx512::feature_kernels;
  if (instruction_set() == InstructionSet::avx2) return avx2::feature_kernels;
#endif
  return portable::feature_kernels;
}

}  // namespace weft::bsi
