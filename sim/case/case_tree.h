// The TOML tree of a case: the parsed text with overrides and places, before it is checked.
#pragma once

#include <toml++/toml.h>

#include <string>
#include <vector>

#include "sim/case/case.h"

namespace weft::sim {

// The text of a file. If it cannot be read as a case, `fault` is the reason and `hint` says what
// was expected.
struct FileText {
  std::string text, fault, hint;
};

// Reads a file of at most 8 MiB. A failure sets FileText::fault.
FileText read_text(const std::string& path);

// Parses TOML. Throws CaseError at the place of a syntax error, or of a key with more than a
// thousand parts.
toml::table parse_toml(const std::string& text, const std::string& path);

// Applies one `KEY=VALUE` (see read_case()). The values that it sets carry the override as their
// source. Throws CaseError for an unknown key, for an entry that the case does not have, and for a
// path that continues beyond a value. The error's place is "--set KEY=VALUE", line 0.
void apply_override(toml::table& root, const std::string& text);

// Returns the place of a node. A node from an override has the file `--set KEY=VALUE` and line 0.
SourceLocation location_of(const toml::source_region& source);

// Returns the position of the first key with more than a thousand parts (a.a.a...) in TOML text, or
// npos if there is none. toml++ makes a table per part and overflows the stack at some ten
// thousand.
std::size_t find_deep_key(const std::string& text);

// Returns the first key of a table, in the order of the text, that is not in `allowed`; null if
// there is none.
const toml::key* first_key_beside(const std::vector<std::string>& allowed,
                                  const toml::table& table);

// Returns the kind of a value for messages: "a string", "a table", ...
std::string kind_of(const toml::node& node);

}  // namespace weft::sim
