// Which vector instructions the inner loops use: chosen when the program runs, with the same
// results to the last bit whichever it is.
//
// A kernel file (bsi/*_kernels.cpp, listed by weft_kernels() in bsi/CMakeLists.txt) is compiled
// once for every set, each time into a namespace of its own (WEFT_KERNELS), and ends in a table of
// its functions, one constant of that namespace. Its caller picks the table by instruction_set().
// Such a file includes no header with inline functions that other files use too (no <vector>, no
// <algorithm>, no Eigen): the linker would keep one copy of them, and it might be one the processor
// cannot run.
#pragma once

#include <span>
#include <string_view>

namespace weft::bsi {

enum class InstructionSet {
  portable,  // what the compiler makes of plain code for the oldest processor it targets
  avx2,      // with fused multiply-add, which is not used: it would round differently
  avx512,
};

std::string_view name(InstructionSet set);

// The sets that this processor has and this build contains, the widest last. O(1).
std::span<const InstructionSet> available_instruction_sets();

// The set in use: the widest available one, or the one that the environment variable
// WEFT_INSTRUCTION_SET names, unless use_instruction_set() was called.
InstructionSet instruction_set();

// For tests and benchmarks. Precondition: available. Not to be called while kernels run.
void use_instruction_set(InstructionSet set);

}  // namespace weft::bsi
