// Files that a case reads, which no command may overwrite.
#pragma once

#include <functional>
#include <string>

#include "sim/case/case.h"

namespace weft::sim {

// Calls use(path) for the path of each file that the case reads, but for included ones, which are
// merged into the case.
void for_each_input_file(Case& source, const std::function<void(std::string&)>& use);

// Throws CaseError if `path` is the case, or a file that it reads: an included file, a shape,
// places of particles or the run in whose state it starts. `writer` is the option or the command
// that would overwrite it.
void refuse_input_file(const std::string& path, const Case& source, const std::string& writer);

}  // namespace weft::sim
