// Words for messages and numbers for files.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace weft::sim {

// The candidate with the fewest edits (insert, delete, replace, swap of neighbours; case ignored)
// from `name`, the earliest of equals; none when the nearest needs more than a third of the longer
// word (one edit is always allowed). Cost: length^2 per candidate of about that length.
std::optional<std::string> nearest_name(const std::string& name,
                                        const std::vector<std::string>& candidates);

// `did you mean "friction"?`, or all candidates where none is near: `expected one of "a", "b"`.
std::string name_hint(const std::string& name, const std::vector<std::string>& candidates);

// Text that may go to a terminal: control characters and bytes that are not UTF-8 become escapes
// (\n, \x1b), so that no text from a file moves the cursor or sets a title. `keep_lines` leaves the
// ends of lines.
std::string printable(const std::string& text, bool keep_lines = false);

// For messages: printable, and of more than 160 bytes only the first, with their number.
std::string in_quotes(const std::string& text);
// `"a", "b", "c"`.
std::string quoted_list(const std::vector<std::string>& names);

// The shortest decimal that reads back as the same bits.
std::string number_text(double value);
// Six significant digits, for what is measured.
std::string rounded_text(double value);

// True if the name is one or more of A-Z a-z 0-9 _ -: it is then fit for files, HDF5 groups and
// overrides.
bool is_identifier(const std::string& name);

}  // namespace weft::sim
