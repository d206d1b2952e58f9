// The turn of a worker to write the summary of a sweep.
#pragma once

#include <filesystem>

namespace weft::sim {

// Workers that end at the same time read all results and write the summary one after the other, so
// that the summary that stays has all results. The constructor waits for its turn. The lock lies on
// plan.json and ends with the process. Without that file, or on a file system without locks, no
// lock is taken.
class SummaryLock {
 public:
  explicit SummaryLock(const std::filesystem::path& directory);
  ~SummaryLock();
  SummaryLock(const SummaryLock&) = delete;
  SummaryLock& operator=(const SummaryLock&) = delete;

 private:
  int descriptor_ = -1;
};

}  // namespace weft::sim
