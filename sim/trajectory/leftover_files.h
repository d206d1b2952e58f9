// Temporary files that killed writers of a trajectory have left. Private to sim/.
#pragma once

#include <string>

namespace weft::sim {

// Removes the temporary files of the trajectory at `path` and of its sidecar whose writers are
// dead. Their names are those of the files with the number of the process and .tmp. A file stays if
// a process of this number lives here, if a writer anywhere holds its lock, or if it cannot be
// removed.
void remove_leftovers(const std::string& path);

}  // namespace weft::sim
