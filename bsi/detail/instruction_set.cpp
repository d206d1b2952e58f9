#include "bsi/detail/instruction_set.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cstdio>
#include <cstdlib>

namespace weft::bsi {

namespace {

struct Available {
  std::array<InstructionSet, 3> sets{};
  std::size_t count = 0;
  void add(InstructionSet set) { sets[count++] = set; }
};

const Available& available() {
  static const Available result = [] {
    Available found;
    found.add(InstructionSet::portable);
#if defined(WEFT_X86_KERNELS)
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
      found.add(InstructionSet::avx2);
      if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
          __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl")) {
        found.add(InstructionSet::avx512);
      }
    }
#endif
    return found;
  }();
  return result;
}

// Returns the set that WEFT_INSTRUCTION_SET names, or else the widest available set. A name that is
// unknown or unavailable is reported on stderr.
InstructionSet choose() {
  const auto sets = available_instruction_sets();
  const char* asked = std::getenv("WEFT_INSTRUCTION_SET");
  if (asked == nullptr || *asked == '\0') return sets.back();
  const auto found = std::find_if(sets.begin(), sets.end(),
                                  [&](InstructionSet set) { return name(set) == asked; });
  if (found != sets.end()) return *found;
  std::fprintf(stderr, "weft: WEFT_INSTRUCTION_SET=%s is not one of", asked);
  for (InstructionSet set : sets) std::fprintf(stderr, " %s", name(set).data());
  std::fprintf(stderr, " on this machine; using %s\n", name(sets.back()).data());
  return sets.back();
}

std::atomic<InstructionSet>& in_use() {
  static std::atomic<InstructionSet> set = choose();
  return set;
}

}  // namespace

std::string_view name(InstructionSet set) {
  constexpr std::array<std::string_view, 3> names{"portable", "avx2", "avx512"};
  return names[static_cast<std::size_t>(set)];
}

std::span<const InstructionSet> available_instruction_sets() {
  return std::span(available().sets).first(available().count);
}

InstructionSet instruction_set() { return in_use().load(std::memory_order_relaxed); }

void use_instruction_set(InstructionSet set) {
  const auto sets = available_instruction_sets();
  assert(std::find(sets.begin(), sets.end(), set) != sets.end());
  static_cast<void>(sets);
  in_use().store(set, std::memory_order_relaxed);
}

}  // namespace weft::bsi
