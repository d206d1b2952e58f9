// Texts for messages, and numbers as text.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace weft::sim {

// Returns the candidate that is the fewest edits (insert, delete, replace, swap of neighbours; case
// ignored) from `name`, the first one if several are equally near. Returns nothing if that takes
// more edits than a third of the longer word; one edit is always allowed. Cost: length^2 per
// candidate of similar length.
std::optional<std::string> nearest_name(const std::string& name,
                                        const std::vector<std::string>& candidates);

// `did you mean "friction"?`, or, if no candidate is near, all of them: `expected one of "a", "b"`.
std::string name_hint(const std::string& name, const std::vector<std::string>& candidates);

// Makes text safe for a terminal. Control characters and bytes that are not UTF-8 become escapes
// (\n, \x1b): no text from a file moves the cursor or sets a title. With `keep_lines`, line ends
// stay.
std::string printable(const std::string& text, bool keep_lines = false);

// Quotes printable text for messages. Of a text of more than 160 bytes it quotes the first 80 and
// adds the length.
std::string in_quotes(const std::string& text);
// `"a", "b", "c"`.
std::string quoted_list(const std::vector<std::string>& names);

// The shortest decimal that reads back as the same bits.
std::string number_text(double value);
// Six significant digits, for measured values.
std::string rounded_text(double value);

// "1 body", "2 bodies".
std::string counted(std::int64_t count, const std::string& one, const std::string& many);

// True if the name is one or more of A-Z a-z 0-9 _ -. Such a name is fit for files, HDF5 groups and
// overrides.
bool is_identifier(const std::string& name);

}  // namespace weft::sim
