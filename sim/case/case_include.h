// Merges the files of [[include]]: materials and obstacles that stand outside the case file.
#pragma once

#include <toml++/toml.h>

#include <string>

namespace weft::sim {

// Merges the files that a case includes, and those that these include in turn, into the tree of the
// case file `path`, and removes its [[include]] tables. A file that is reached twice is merged
// once.
//
// An included file holds [material.NAME], [[obstacle]] and [[include]]. Its obstacles follow those
// of the file that includes it, before those of files that it includes itself. Its values keep
// their own file, line and column. The paths of its shape files, which are relative to it, become
// relative to the case file.
//
// Throws CaseError for a file that cannot be read, other tables, a material that two files have,
// files that include each other in a circle, and chains of more than 32 files.
void merge_includes(toml::table& root, const std::string& path);

}  // namespace weft::sim
