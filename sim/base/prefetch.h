// Asks the processor for memory that is needed soon.
#pragma once

#include <cstddef>
#include <vector>

namespace weft::sim {

// Loads element `i` of a list into the caches without waiting for it, if there is such an element.
// Loops over long lists of large elements use this: the processor itself looks ahead along few
// streams of memory at a time.
template <class Element>
void prefetch(const std::vector<Element>& list, std::size_t i) {
  if (i >= list.size()) return;
  constexpr std::size_t line = 64;
  const char* const begin = reinterpret_cast<const char*>(&list[i]);
#pragma GCC unroll 32
  for (std::size_t at = 0; at < sizeof(Element); at += line) __builtin_prefetch(begin + at);
}

}  // namespace weft::sim
