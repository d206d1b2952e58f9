#include "sim/sweep/summary_lock.h"

#include <fcntl.h>
#include <unistd.h>

#include <chrono>
#include <string>
#include <thread>

#include "sim/trajectory/file_lock.h"

namespace weft::sim {

SummaryLock::SummaryLock(const std::filesystem::path& directory) {
  const std::string path = (directory / "plan.json").string();
  while (true) {
    descriptor_ = open(path.c_str(), O_RDWR | O_CLOEXEC);
    if (descriptor_ < 0) return;
    // Another plan may have replaced the file meanwhile.
    if (lock_open_file(descriptor_) && names_open_file(path, descriptor_)) return;
    close(descriptor_);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

SummaryLock::~SummaryLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

}  // namespace weft::sim
