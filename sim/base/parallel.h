// Parallel loops whose results do not depend on the number of threads.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "bsi/detail/team.h"
#include "sim/base/vectors.h"

namespace weft::sim {

// The division of [0, count) into chunks of equal length, give or take one. It depends on `count`
// alone. A sum adds the sums of the chunks in order, so any number of threads gives the same bits.
// Chunks come in multiples of 24, which 2, 3, 4, 6, 8 and 12 threads can share evenly. Only short
// loops have fewer.
class Chunks {
 public:
  explicit Chunks(int count) : count_(count) {
    constexpr int multiple = 24, longest = 512, shortest = 8;
    const int pieces = (count + multiple * longest - 1) / (multiple * longest);
    size_ = std::min((count + shortest - 1) / shortest, multiple * pieces);
  }

  int size() const { return size_; }
  int first(int chunk) const {
    return static_cast<int>(static_cast<std::int64_t>(count_) * chunk / size_);
  }
  int last(int chunk) const { return first(chunk + 1); }

 private:
  int count_, size_;
};

// Calls body(chunk, first, last) for every chunk [first, last) of [0, count), on up to `threads`
// threads.
template <class Body>
void parallel_numbered_chunks(const Chunks& chunks, int threads, const Body& body) {
  bsi::parallel_for(chunks.size(), threads,
                    [&](int c) { body(c, chunks.first(c), chunks.last(c)); });
}

// Calls body(first, last) for every chunk [first, last) of [0, count), on up to `threads` threads.
template <class Body>
void parallel_chunks(int count, int threads, const Body& body) {
  parallel_numbered_chunks(Chunks(count), threads,
                           [&](int, int first, int last) { body(first, last); });
}

// Calls body(first, last, part) for every chunk of [0, count), and returns the parts in the order
// of the chunks. They are the first elements of `parts`, which grows if needed. A part is as the
// last loop left it: loops that fill lists use their memory again.
template <class Part, class Body>
std::span<Part> parallel_parts(std::vector<Part>& parts, int count, int threads, const Body& body) {
  const Chunks chunks(count);
  if (std::ssize(parts) < chunks.size()) parts.resize(chunks.size());
  parallel_numbered_chunks(
      chunks, threads, [&](int chunk, int first, int last) { body(first, last, parts[chunk]); });
  return std::span(parts).first(chunks.size());
}

// Calls body() for parts that are made anew, and returns them.
template <class Part, class Body>
std::vector<Part> parallel_parts(int count, int threads, const Body& body) {
  std::vector<Part> parts;
  static_cast<void>(parallel_parts(parts, count, threads, body));
  return parts;
}

// Returns the sum of partial(first, last) over the chunks of [0, count).
template <class Partial>
double parallel_sum(int count, int threads, const Partial& partial) {
  const auto parts = parallel_parts<double>(
      count, threads, [&](int first, int last, double& part) { part = partial(first, last); });
  double sum = 0;
  for (double part : parts) sum += part;
  return sum;
}

inline void parallel_copy(std::span<const Vec3> from, std::span<Vec3> to, int threads) {
  parallel_chunks(static_cast<int>(from.size()), threads, [&](int first, int last) {
    std::copy(from.begin() + first, from.begin() + last, to.begin() + first);
  });
}

inline void parallel_set_zero(std::span<Vec3> vectors, int threads) {
  parallel_chunks(static_cast<int>(vectors.size()), threads, [&](int first, int last) {
    std::fill(vectors.begin() + first, vectors.begin() + last, Vec3::Zero());
  });
}

// Returns the dot product of two arrays of equal size.
inline double dot(std::span<const Vec3> a, std::span<const Vec3> b, int threads) {
  return parallel_sum(static_cast<int>(a.size()), threads, [&](int first, int last) {
    const double *const x = a[0].data(), *const y = b[0].data();
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (int i = 3 * first; i < 3 * last; ++i) sum += x[i] * y[i];
    return sum;
  });
}

}  // namespace weft::sim
