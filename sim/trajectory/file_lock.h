// The lock on a trajectory that its writer holds as long as it lives. Private to sim/.
//
// It is an "open file description" lock (fcntl, Linux) on one byte far beyond the end of the file:
// the kernel drops it when the writer dies by whatever signal, so none is ever stale; and HDF5,
// whose locks are those of flock(), does not meet it, so that anyone may read the file. Network
// file systems that make flock() a lock of all bytes (NFS) are the exception: readers there set
// HDF5_USE_FILE_LOCKING=FALSE. Where a file system has no locks, none is taken.
#pragma once

#include <string>

namespace weft::sim {

// An open file, closed with the object.
class LockedFile {
 public:
  enum class State { locked, held_by_another, absent, without_lock };

  // Opens the file at `path`, if there is one, and takes its lock, if that is free.
  explicit LockedFile(const std::string& path);
  ~LockedFile();
  LockedFile(const LockedFile&) = delete;
  LockedFile& operator=(const LockedFile&) = delete;

  State state() const { return state_; }
  // True if the path still names this file.
  bool is_at(const std::string& path) const;

 private:
  int descriptor_ = -1;
  State state_ = State::absent;
};

// True if the lock of the file at `path` is held. Does not take it.
bool is_locked(const std::string& path);

// Takes the lock of an open file for as long as its description is open. False where another
// description has it; true also where the file system has no locks.
bool lock_open_file(int descriptor);

// True if a path names the open file.
bool names_open_file(const std::string& path, int descriptor);

}  // namespace weft::sim
