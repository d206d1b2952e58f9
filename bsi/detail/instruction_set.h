// The vector instructions of the inner loops, chosen at run time. Results are the same to the last
// bit for every set.
//
// A kernel file (bsi/kernels/*_kernels.cpp, listed by weft_kernels() in bsi/CMakeLists.txt) is
// compiled once per set, each time into a namespace of its own (WEFT_KERNELS). It ends in a table
// of its functions, a constant of that namespace, which callers select by instruction_set(). It
// must not include headers with inline functions that other files use (no <vector>, no <algorithm>,
// no Eigen). The linker would keep one copy of these, possibly one that the processor cannot run.
#pragma once

#include <span>
#include <string_view>

namespace weft::bsi {

enum class InstructionSet {
  portable,  // plain code for the oldest processor that the compiler targets
  avx2,      // fused multiply-add is required but unused: it rounds differently
  avx512,
};

std::string_view name(InstructionSet set);

// Returns the sets that both this processor and this build support, the widest last. O(1).
std::span<const InstructionSet> available_instruction_sets();

// Returns the set in use: the last use_instruction_set(), else the one that the environment
// variable WEFT_INSTRUCTION_SET names, else the widest available one.
InstructionSet instruction_set();

// Selects a set, for tests and benchmarks. Precondition: it is available, and no kernels run.
void use_instruction_set(InstructionSet set);

}  // namespace weft::bsi
