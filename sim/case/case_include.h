// Merges files that a case names by [[include]]: materials and obstacles outside the case file.
#pragma once

#include <toml++/toml.h>

#include <string>
#include <vector>

namespace weft::sim {

// Merges all files that the case file `path` includes, directly or through other files, into its
// tree `root`, and returns their paths. Removes the [[include]] tables from `root`. A file that is
// included twice is merged once.
//
// An included file may hold [material.NAME], [[obstacle]] and [[include]]. Its obstacles come after
// those of the file that includes it, and before those of files that it is the first to include.
// Its values keep their own file, line and column. Relative paths of shape files are relative to
// the included file, and become relative to the case file.
//
// Throws CaseError for a file that cannot be read or parsed, for a key that an included file may
// not hold, and for a material that two files define. Also throws it for files that include each
// other in a circle, and for chains of more than 32 files, including the case file.
std::vector<std::string> merge_includes(toml::table& root, const std::string& path);

}  // namespace weft::sim
