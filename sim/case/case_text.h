// Texts for messages, and text forms of numbers.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace weft::sim {

// Returns the candidate with the fewest edits from `name`, or the first of several such candidates.
// An edit inserts, deletes or replaces a character, or swaps two neighbours; case is ignored. The
// number of edits must not exceed a third of the longer word's length, though one edit is always
// allowed. Returns nothing if no candidate is that near, or for a name of more than 1000 bytes.
// Cost: length^2 per candidate of similar length.
std::optional<std::string> nearest_name(const std::string& name,
                                        const std::vector<std::string>& candidates);

// Returns `did you mean "friction"?`, with the nearest candidate. If no candidate is near, returns
// the list of all candidates: `expected one of "a", "b"`. Without candidates, says that there is
// none.
std::string name_hint(const std::string& name, const std::vector<std::string>& candidates);

// Returns text that is safe for a terminal. Control characters and bytes that are not UTF-8 become
// escapes (\n, \x1b), so no text from a file can move the cursor or set a title. With `keep_lines`,
// \n is not escaped.
std::string printable(const std::string& text, bool keep_lines = false);

// Returns a text of several lines, the later ones indented, as one line: `one | other`.
std::string in_one_line(std::string text);

// Returns the text in quotes, made printable. A text of more than 160 bytes is cut to at most 80
// bytes, and its length follows the quotes.
std::string in_quotes(const std::string& text);
// Returns `"a", "b", "c"`.
std::string quoted_list(const std::vector<std::string>& names);

// Returns the shortest decimal number that reads back as the same double.
std::string number_text(double value);
// Returns the value rounded to six significant digits.
std::string rounded_text(double value);

// Returns the count with the noun `one` or `many`: "1 body", "2 bodies".
std::string counted(std::int64_t count, const std::string& one, const std::string& many);

// True if the name is not empty and consists of A-Z a-z 0-9 _ -. These characters are safe in file
// names, in names of HDF5 groups and in overrides.
bool is_identifier(const std::string& name);

}  // namespace weft::sim
