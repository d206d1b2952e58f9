// The TOML tree of a case: parsed text with overrides and places, not checked yet.
#pragma once

#include <toml++/toml.h>

#include <string>
#include <vector>

#include "sim/case/case.h"

namespace weft::sim {

// The text of a file or, if it cannot be read as a case, the reason and a hint about what was
// expected.
struct FileText {
  std::string text, fault, hint;
};

// Reads a file of at most 8 MiB.
FileText read_text(const std::string& path);

// Parses TOML. Throws CaseError at the place of a syntax error, or of a key with more than a
// thousand parts.
toml::table parse_toml(const std::string& text, const std::string& path);

// Applies one `KEY=VALUE` (see read_case); the values it sets carry the override as their source.
// Throws CaseError, placed at "--set KEY=VALUE" with line 0, on an unknown key, an entry that this
// case does not have, or a path that continues beyond a value.
void apply_override(toml::table& root, const std::string& text);

// The place of a node. A node from an override has line 0 and the file `--set KEY=VALUE`.
SourceLocation location_of(const toml::source_region& source);

// Returns the first byte of a key with more than a thousand parts (a.a.a...) in TOML text, or npos
// if there is none. toml++ makes a table for each part and overruns the stack at some ten thousand.
std::size_t find_deep_key(const std::string& text);

// Returns the first key in the text of a table that is not in `allowed`, or null if there is none.
const toml::key* first_key_beside(const std::vector<std::string>& allowed,
                                  const toml::table& table);

// The kind of a value for messages: "a string", "a table", ...
std::string kind_of(const toml::node& node);

}  // namespace weft::sim
