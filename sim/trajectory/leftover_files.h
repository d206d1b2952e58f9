// Temporary files of writers, and those that killed writers have left. Private to sim/.
#pragma once

#include <string>
#include <string_view>

namespace weft::sim {

// Returns the path under which this process writes the file `path` before it has all of it.
std::string temporary_path(const std::string& path);

// Returns the name of the file that a writer would have made of the temporary file `name`:
// FILE.PROCESS.tmp, with the number of a process that does not live on this machine. Returns an
// empty text for other names.
std::string file_of_leftover(std::string_view name);

// Removes the temporary files of the trajectory at `path` and of its sidecar whose writers are
// dead. Their names are those of the files with the number of the process and .tmp. A file stays if
// a process of this number lives here, if a writer anywhere holds its lock, or if it cannot be
// removed.
void remove_leftovers(const std::string& path);

}  // namespace weft::sim
