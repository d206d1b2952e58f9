// The lock that the writer of a trajectory holds while it lives. Private to sim/.
//
// The lock is an "open file description" lock (fcntl, Linux) on one byte far beyond the end of the
// file. The kernel releases it when the writer dies, so it is never stale. It does not keep readers
// out, because HDF5 locks by flock(), which ignores fcntl locks. On network file systems where
// flock() locks all bytes (NFS), readers must set HDF5_USE_FILE_LOCKING=FALSE. On file systems
// without locks, no lock is taken.
#pragma once

#include <string>

namespace weft::sim {

// An open file with its lock. The destructor closes the file and releases the lock.
class LockedFile {
 public:
  enum class State { locked, held_by_another, absent, without_lock };

  // Opens the file at `path` and takes its lock. state() is `locked` on success, also if the file
  // system has no locks, and `held_by_another` if another file description holds the lock, also in
  // this process. It is `absent` if there is no file, and `without_lock` if a file that is not
  // locked cannot be opened for writing.
  explicit LockedFile(const std::string& path);
  ~LockedFile();
  LockedFile(const LockedFile&) = delete;
  LockedFile& operator=(const LockedFile&) = delete;

  State state() const { return state_; }
  // True if `path` names this file.
  bool is_at(const std::string& path) const;

 private:
  int descriptor_ = -1;
  State state_ = State::absent;
};

// True if a process holds the lock of the file at `path`. False if the file cannot be opened for
// reading. Does not take the lock.
bool is_locked(const std::string& path);

// Takes the lock of an open file. The lock is held until the file description is closed. Returns
// false if another file description holds the lock. Returns true if the file system has no locks.
bool lock_open_file(int descriptor);

// True if `path` names the file that is open as `descriptor`.
bool names_open_file(const std::string& path, int descriptor);

}  // namespace weft::sim
