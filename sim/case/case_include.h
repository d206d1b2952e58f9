// Merges files that a case names by [[include]]: materials and obstacles outside the case file.
#pragma once

#include <toml++/toml.h>

#include <string>

namespace weft::sim {

// Merges the files that a case includes, directly or through other files, into the tree of the case
// file `path`. Removes the case's [[include]] tables. A file that is reached twice is merged once.
//
// An included file may hold [material.NAME], [[obstacle]] and [[include]]. Its obstacles come after
// those of the file that includes it, and before those of files that it includes. Its values keep
// their own file, line and column. Paths of shape files in it are relative to it; they become
// relative to the case file.
//
// Throws CaseError for a file that cannot be read, for other tables, and for a material that two
// files define. Also throws it for files that include each other in a circle, and for chains of
// more than 32 files.
void merge_includes(toml::table& root, const std::string& path);

}  // namespace weft::sim
