// Loops over threads whose results do not depend on how many there are.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace weft::sim {

// Work is cut into chunks of a fixed size, whatever the number of threads: sums are formed chunk by
// chunk and then added in order, so that one thread and many give the same bits.
inline constexpr int chunk_size = 2048;

// Calls body(first, last) for every chunk of [0, count).
template <class Body>
void parallel_chunks(int count, int threads, const Body& body) {
  const int chunks = (count + chunk_size - 1) / chunk_size;
  if (threads <= 1 || chunks <= 1) {
    for (int c = 0; c < chunks; ++c) body(c * chunk_size, std::min(count, (c + 1) * chunk_size));
    return;
  }
#pragma omp parallel for num_threads(threads) schedule(static)
  for (int c = 0; c < chunks; ++c) body(c * chunk_size, std::min(count, (c + 1) * chunk_size));
}

// Sum of partial(first, last) over the chunks of [0, count).
template <class Partial>
double parallel_sum(int count, int threads, const Partial& partial) {
  const int chunks = (count + chunk_size - 1) / chunk_size;
  double sum = 0;
  if (threads <= 1 || chunks <= 1) {
    for (int c = 0; c < chunks; ++c) {
      sum += partial(c * chunk_size, std::min(count, (c + 1) * chunk_size));
    }
    return sum;
  }
  std::vector<double> part(static_cast<std::size_t>(chunks));
#pragma omp parallel for num_threads(threads) schedule(static)
  for (int c = 0; c < chunks; ++c) {
    part[c] = partial(c * chunk_size, std::min(count, (c + 1) * chunk_size));
  }
  for (double p : part) sum += p;
  return sum;
}

}  // namespace weft::sim
