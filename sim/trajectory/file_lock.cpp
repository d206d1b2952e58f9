#include "sim/trajectory/file_lock.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace weft::sim {
namespace {

struct flock writer_lock() {
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  lock.l_start = off_t{1} << 62;
  lock.l_len = 1;
  return lock;
}

bool is_denial(int error) { return error == EAGAIN || error == EACCES; }

}  // namespace

bool lock_open_file(int descriptor) {
  struct flock lock = writer_lock();
  return fcntl(descriptor, F_OFD_SETLK, &lock) == 0 || !is_denial(errno);
}

bool names_open_file(const std::string& path, int descriptor) {
  struct stat named {
  }, open{};
  return stat(path.c_str(), &named) == 0 && fstat(descriptor, &open) == 0 &&
         named.st_dev == open.st_dev && named.st_ino == open.st_ino;
}

bool is_locked(const std::string& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (descriptor < 0) return false;
  struct flock lock = writer_lock();
  const bool held = fcntl(descriptor, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
  close(descriptor);
  return held;
}

LockedFile::LockedFile(const std::string& path)
    : descriptor_(open(path.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK | O_NOCTTY)) {
  if (descriptor_ >= 0) {
    state_ = lock_open_file(descriptor_) ? State::locked : State::held_by_another;
    return;
  }
  if (errno == ENOENT) return;
  // The file cannot be opened for writing, but its lock can still be queried.
  state_ = is_locked(path) ? State::held_by_another : State::without_lock;
  descriptor_ = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
}

LockedFile::~LockedFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

bool LockedFile::is_at(const std::string& path) const {
  return descriptor_ >= 0 && names_open_file(path, descriptor_);
}

}  // namespace weft::sim
