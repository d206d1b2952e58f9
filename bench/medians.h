// Medians and times for the benchmarks.
#pragma once

#include <algorithm>
#include <ctime>
#include <vector>

namespace weft::bench {

// Seconds on a clock of clock_gettime().
inline double seconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

template <class Work>
double time_of(clockid_t clock, const Work& work) {
  const double start = seconds(clock);
  work();
  return seconds(clock) - start;
}

// CPU time of the whole process, s.
template <class Work>
double cpu_time_of(const Work& work) {
  return time_of(CLOCK_PROCESS_CPUTIME_ID, work);
}

// CPU time of the calling thread, s. It leaves out other threads, which may still be spinning after
// their work.
template <class Work>
double thread_time_of(const Work& work) {
  return time_of(CLOCK_THREAD_CPUTIME_ID, work);
}

// Wall time, s.
template <class Work>
double wall_time_of(const Work& work) {
  return time_of(CLOCK_MONOTONIC, work);
}

inline double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

}  // namespace weft::bench
