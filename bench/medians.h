// Medians and times for the benchmarks.
#pragma once

#include <time.h>

#include <algorithm>
#include <vector>

namespace weft::bench {

// CPU time of this process, s.
inline double cpu_time() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Time since some moment, s.
inline double wall_time() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

template <class Work>
double cpu_time_of(const Work& work) {
  const double start = cpu_time();
  work();
  return cpu_time() - start;
}

template <class Work>
double wall_time_of(const Work& work) {
  const double start = wall_time();
  work();
  return wall_time() - start;
}

inline double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

}  // namespace weft::bench
