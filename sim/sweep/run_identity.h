// The hash that identifies a run: the same inputs have the same hash, on any machine.
#pragma once

#include <sys/stat.h>

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "sim/case/case.h"

namespace weft::sim {

// Returns the SHA-256 of bytes, as 64 hexadecimal digits. Throws std::runtime_error if the library
// cannot compute it.
std::string sha256(std::string_view bytes);

// Computes hashes of runs. Files that several cases read are read once.
class RunHasher {
 public:
  // Returns the hash of the numerics number, the resolved case and the bytes of the files it reads.
  // The number of threads, the device of the contact search and [outputs], on which no trajectory
  // depends, are left out. A run that measures its error is another one. Throws FileError for a
  // file that cannot be read. Precondition: the case comes from the reader, and its accuracy is not
  // settled.
  std::string hash(const Case& source, bool estimates_error = false);
  // Returns the SHA-256 of the files of all hashes so far, by their paths (input_paths()); empty
  // for a checkpoint that was not there.
  const std::map<std::string, std::string>& digests() const { return digests_; }

 private:
  const std::string& digest_of_file(const std::string& path);

  std::map<std::string, std::string> digests_;  // by path
};

// Returns the absolute paths of the files whose bytes the hash of a case holds: those that it
// reads, and the checkpoint of the run from which it starts.
std::vector<std::string> input_paths(const Case& source);

// Compares files with those that a plan was made for. A file is read again only if its size, its
// times or its place on the disk have changed.
class InputCheck {
 public:
  enum class State { as_planned, changed, unreadable };
  struct Finding {
    State state = State::as_planned;
    std::string reason;  // of another state, with the path of the file
  };

  // `planned`: RunHasher::digests(). The object keeps a reference to it.
  explicit InputCheck(const std::map<std::string, std::string>& planned) : planned_(planned) {}

  // Returns the first file among `paths` that is not as planned; one that has changed rather than
  // one that cannot be read.
  Finding look_at(const std::vector<std::string>& paths);

 private:
  struct Known {
    struct stat status;
    std::string digest;
  };
  Finding look_at_file(const std::string& path);
  // Returns the digest of a file that is there. Throws FileError if it cannot be read.
  const std::string& digest_of(const std::string& path, const struct stat& status);

  const std::map<std::string, std::string>& planned_;
  std::map<std::string, Known> known_;  // by path
};

// Returns the resolved case as text that gives the same case from any folder: paths of files are
// absolute. Precondition: the case comes from the reader, and its accuracy is not settled.
std::string portable_case_text(const Case& source);

}  // namespace weft::sim
