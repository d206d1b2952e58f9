// Strings of a case or sweep file with the place of each of their bytes, for messages.
#pragma once

#include <string>
#include <vector>

#include "sim/case/case.h"

namespace weft::sim {

// The text of a string, and its places in a file.
struct LocatedText {
  struct Place {
    int line = 0, column = 0;
  };
  std::string text;
  SourceLocation location;  // place of the string: of its opening quote, or of an override
  // Places of all bytes of the text, and of its end. Empty if only `location` is known.
  std::vector<Place> places = {};

  // Returns the place of a byte, or `location` if the places of bytes are unknown. Precondition:
  // byte <= text.size().
  SourceLocation at(std::size_t byte) const;
};

// Returns the text of a TOML string with the places of its bytes. `file_text` is the text of the
// file `location.file`, and `location` the place of the string's opening quote in it. Escapes and
// strings of several lines are followed. If the place has no line, as that of an override, or if no
// such string is there, LocatedText::places is empty. O(file_text).
LocatedText located_text(const std::string& text, const SourceLocation& location,
                         const std::string& file_text);

}  // namespace weft::sim
