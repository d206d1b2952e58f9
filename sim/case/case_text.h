// Texts for messages, and text forms of numbers.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace weft::sim {

// Returns the candidate with the fewest edits from `name`, the first one if several have equally
// few. Edits insert, delete or replace a character or swap two neighbours; case is ignored. Returns
// nothing if more edits are needed than a third of the longer word's length; one edit is always
// allowed. Cost: length^2 per candidate of similar length.
std::optional<std::string> nearest_name(const std::string& name,
                                        const std::vector<std::string>& candidates);

// Returns `did you mean "friction"?` or, if no candidate is near, all of them: `expected one of
// "a", "b"`.
std::string name_hint(const std::string& name, const std::vector<std::string>& candidates);

// Makes text safe for a terminal. Control characters and bytes that are not UTF-8 become escapes
// (\n, \x1b), so no text from a file can move the cursor or set a title. With `keep_lines`, line
// ends stay.
std::string printable(const std::string& text, bool keep_lines = false);

// Quotes text for messages, made printable. A text of more than 160 bytes is cut to its first 80
// bytes, followed by its length.
std::string in_quotes(const std::string& text);
// Returns `"a", "b", "c"`.
std::string quoted_list(const std::vector<std::string>& names);

// Returns the shortest decimal that reads back as the same bits.
std::string number_text(double value);
// Returns six significant digits, for measured values.
std::string rounded_text(double value);

// Returns "1 body", "2 bodies".
std::string counted(std::int64_t count, const std::string& one, const std::string& many);

// True if the name is not empty and consists of A-Z a-z 0-9 _ -. Such a name is suitable for files,
// HDF5 groups and overrides.
bool is_identifier(const std::string& name);

}  // namespace weft::sim
