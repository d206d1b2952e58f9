// Selects the vector instructions of the inner loops at run time. Every set gives the same bits.
//
// A kernel file (bsi/kernels/*_kernels.cpp, listed by weft_kernels() in bsi/CMakeLists.txt) is
// compiled once per set, each time into a namespace of its own (WEFT_KERNELS). It defines a table
// of its functions, a constant of that namespace. kernel_tables.cpp returns the table for
// instruction_set(). A kernel file must not include headers with inline functions that other files
// use (no <vector>, no <algorithm>, no Eigen). The linker would keep a single copy of such a
// function, possibly one with instructions that the processor lacks.
#pragma once

#include <span>
#include <string_view>

namespace weft::bsi {

enum class InstructionSet {
  portable,  // plain code for every processor of the architecture
  avx2,      // requires fused multiply-add but never uses it, because it rounds differently
  avx512,
};

std::string_view name(InstructionSet set);

// Returns the sets that this processor and this build both support, the widest last. O(1).
std::span<const InstructionSet> available_instruction_sets();

// Returns the set in use: that of the last use_instruction_set(). Before the first such call, it is
// the set that the environment variable WEFT_INSTRUCTION_SET names, or else the widest available
// set.
InstructionSet instruction_set();

// Selects the set to use, for tests and benchmarks. Preconditions: the set is available, and no
// kernel is running.
void use_instruction_set(InstructionSet set);

}  // namespace weft::bsi
