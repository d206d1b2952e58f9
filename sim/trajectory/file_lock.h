// The lock that the writer of a trajectory holds as long as it lives. Private to sim/.
//
// It is an "open file description" lock (fcntl, Linux) on one byte far beyond the end of the file.
// The kernel drops it when the writer dies by any signal, so it is never stale. HDF5 locks by
// flock(), which does not see it, so anyone may read the file. On network file systems that make
// flock() a lock of all bytes (NFS), readers set HDF5_USE_FILE_LOCKING=FALSE. On file systems
// without locks, none is taken.
#pragma once

#include <string>

namespace weft::sim {

// An open file with its lock; closed with the object.
class LockedFile {
 public:
  enum class State { locked, held_by_another, absent, without_lock };

  // Opens the file at `path` if there is one, and takes its lock if that is free.
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

// True if someone holds the lock of the file at `path`. Does not take it.
bool is_locked(const std::string& path);

// Takes the lock of an open file for as long as its description is open. Returns false if another
// description holds it; true also if the file system has no locks.
bool lock_open_file(int descriptor);

// True if the path names the open file.
bool names_open_file(const std::string& path, int descriptor);

}  // namespace weft::sim
