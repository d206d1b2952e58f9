// The hash that identifies a run: the same inputs have the same hash, on any machine.
#pragma once

#include <map>
#include <string>
#include <string_view>

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

 private:
  const std::string& digest_of_file(const std::string& path);

  std::map<std::string, std::string> digests_;  // by path
};

// Returns the resolved case as text that gives the same case from any folder: paths of files are
// absolute. Precondition: the case comes from the reader, and its accuracy is not settled.
std::string portable_case_text(const Case& source);

}  // namespace weft::sim
