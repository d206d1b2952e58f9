// Loops of one thread or of a team of threads.
//
// One thread opens no parallel region. The OpenMP library of GCC 12 ends each region by a call of
// the kernel, even if the region has one thread. Such calls took a tenth of the time of small
// simulations.
#pragma once

#include <omp.h>

#include <atomic>
#include <cstdint>

namespace weft::bsi {

// The compiler makes one copy of such a function. In a second copy of a loop, it might fuse
// multiplications and additions differently. One thread and many would then differ in the last bit.
#if defined(__clang__)
#define WEFT_SINGLE_COPY [[gnu::noinline]]
#else
#define WEFT_SINGLE_COPY [[gnu::noinline, gnu::noclone]]
#endif

// Calls body(i) for i = first .. last - 1, in order.
template <class Body>
WEFT_SINGLE_COPY void run_range(int first, int last, const Body& body) {
  for (int i = first; i < last; ++i) body(i);
}

// Calls body(i) for all i of [0, count), on up to `threads` threads. Each of them runs a range of
// neighbouring i, in order.
template <class Body>
void parallel_for(int count, int threads, const Body& body) {
  if (threads <= 1 || count <= 1) return run_range(0, count, body);
#pragma omp parallel num_threads(threads)
  {
    const std::int64_t team = omp_get_num_threads(), own = omp_get_thread_num();
    run_range(static_cast<int>(count * own / team), static_cast<int>(count * (own + 1) / team),
              body);
  }
}

// Hands out the numbers of [0, count) one by one to the threads that ask for them.
class SharedCount {
 public:
  explicit SharedCount(int count) : count_(count) {}
  // Sets `number` to one that no other call has returned. Returns false if none is left.
  bool take(int& number) {
    number = next_.fetch_add(1, std::memory_order_relaxed);
    return number < count_;
  }

 private:
  std::atomic<int> next_ = 0;
  int count_;
};

// Calls work() once on each of `threads` threads.
template <class Work>
void run_team(int threads, const Work& work) {
  // Both calls share one function object: each lambda expression would have a copy of its own.
  const auto once = [&](int) { work(); };
  if (threads <= 1) return run_range(0, 1, once);
#pragma omp parallel num_threads(threads)
  run_range(0, 1, once);
}

}  // namespace weft::bsi
