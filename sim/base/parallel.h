// Parallel loops whose results do not depend on the number of threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "sim/base/vectors.h"

namespace weft::sim {

// Number of loop iterations per chunk, independent of the number of threads. A sum adds the sums of
// the chunks in order, so any number of threads gives the same bits.
inline constexpr int chunk_size = 2048;

// Calls body(first, last) for every chunk [first, last) of [0, count), on up to `threads` threads.
// The same loop serves one thread and many. In a separate loop for one thread, the compiler might
// fuse multiplications and additions differently, which would change the last bit.
template <class Body>
void parallel_chunks(int count, int threads, const Body& body) {
  const int chunks = (count + chunk_size - 1) / chunk_size;
#pragma omp parallel for num_threads(threads) schedule(static) if (threads > 1 && chunks > 1)
  for (int c = 0; c < chunks; ++c) body(c * chunk_size, std::min(count, (c + 1) * chunk_size));
}

// Returns the sum of partial(first, last) over the chunks of [0, count).
template <class Partial>
double parallel_sum(int count, int threads, const Partial& partial) {
  std::vector<double> part((count + chunk_size - 1) / chunk_size);
  parallel_chunks(count, threads,
                  [&](int first, int last) { part[first / chunk_size] = partial(first, last); });
  double sum = 0;
  for (double p : part) sum += p;
  return sum;
}

// Returns the dot product of two arrays of equal size.
inline double dot(std::span<const Vec3> a, std::span<const Vec3> b, int threads) {
  return parallel_sum(static_cast<int>(a.size()), threads, [&](int first, int last) {
    double sum = 0;
    for (int i = first; i < last; ++i) sum += a[i].dot(b[i]);
    return sum;
  });
}

}  // namespace weft::sim
