// Functions that return the tables of kernels for the instruction set in use.
#include "bsi/detail/instruction_set.h"
#include "bsi/kernels/block_judge_kernels.h"
#include "bsi/kernels/box_build_kernels.h"
#include "bsi/kernels/box_descent_kernels.h"
#include "bsi/kernels/feature_kernels.h"
#include "bsi/kernels/narrow_phase_kernels.h"
#include "bsi/kernels/point_descent_kernels.h"
#include "bsi/kernels/vertex_kernels.h"

// Declares the tables of one instruction set.
#define WEFT_DECLARE_KERNELS(set)                         \
  namespace weft::bsi::set {                              \
  extern const BlockJudgeKernels block_judge_kernels;     \
  extern const BoxBuildKernels box_build_kernels;         \
  extern const DescentKernels descent_kernels;            \
  extern const FeatureKernels feature_kernels;            \
  extern const NarrowPhaseKernels narrow_phase_kernels;   \
  extern const PointDescentKernels point_descent_kernels; \
  extern const VertexKernels vertex_kernels;              \
  }
WEFT_DECLARE_KERNELS(portable)
#if defined(WEFT_X86_KERNELS)
WEFT_DECLARE_KERNELS(avx2)
WEFT_DECLARE_KERNELS(avx512)
#define WEFT_CHOOSE(table)                                     \
  (instruction_set() == InstructionSet::avx512 ? avx512::table \
   : instruction_set() == InstructionSet::avx2 ? avx2::table   \
                                               : portable::table)
#else
#define WEFT_CHOOSE(table) portable::table
#endif

namespace weft::bsi {

const BlockJudgeKernels& block_judge_kernels() { return WEFT_CHOOSE(block_judge_kernels); }
const BoxBuildKernels& box_build_kernels() { return WEFT_CHOOSE(box_build_kernels); }
const DescentKernels& descent_kernels() { return WEFT_CHOOSE(descent_kernels); }
const FeatureKernels& feature_kernels() { return WEFT_CHOOSE(feature_kernels); }
const NarrowPhaseKernels& narrow_phase_kernels() { return WEFT_CHOOSE(narrow_phase_kernels); }
const PointDescentKernels& point_descent_kernels() { return WEFT_CHOOSE(point_descent_kernels); }
const VertexKernels& vertex_kernels() { return WEFT_CHOOSE(vertex_kernels); }

}  // namespace weft::bsi
