// Strings of a case or sweep file with the place of each of their bytes, for messages.
#pragma once

#include <string>

#include "sim/case/case.h"

namespace weft::sim {

// Returns the text of a TOML string with the places of its bytes. `file_text` is the text of the
// file `location.file`, and `location` the place of the string's opening quote in it. Escapes and
// strings of several lines are followed. If the place has no line, as that of an override, or if no
// such string is there, LocatedText::places is empty. O(file_text).
LocatedText located_text(const std::string& text, const SourceLocation& location,
                         const std::string& file_text);

}  // namespace weft::sim
