// The TOML tree of a case: its parsed text, to which overrides can be applied.
#pragma once

#include <toml++/toml.h>

#include <string>
#include <vector>

#include "sim/case/case.h"

namespace weft::sim {

// The text of a file. If it cannot be read, `fault` is the reason, and `hint` may hold advice that
// continues the error message.
struct FileText {
  std::string text, fault, hint;
};

// Reads a file of at most 8 MiB. A failure sets FileText::fault.
FileText read_text(const std::string& path);

// Parses the text of the file `path` as TOML. Throws CaseError at a syntax error, or at a key with
// more than a thousand parts.
toml::table parse_toml(const std::string& text, const std::string& path);

// Returns the place of a node or key. If it comes from an override or a preset, its file is
// `--set KEY=VALUE` or `preset "NAME"`, and its line is 0. If the text was parsed with the path
// path_for_place(), its place is that one.
SourceLocation location_of(const toml::source_region& source);
// Returns a path for toml::parse() that gives all nodes of the text one place, in another file.
std::string path_for_place(const SourceLocation& place);

// Returns the position of the first key with more than a thousand parts (a.a.a...) in TOML text, or
// npos if there is no such key. Text in a string or a comment may count as a key, too. toml++ makes
// a table per part and overflows the stack at some ten thousand parts.
std::size_t find_deep_key(const std::string& text);

// Returns the first key of a table, in the order of the text, that is not in `allowed`. Returns
// null if there is none.
const toml::key* first_key_beside(const std::vector<std::string>& allowed,
                                  const toml::table& table);

// Returns a value as TOML on one line.
std::string toml_text(const toml::node& node);

// Returns the TOML type of a value, in words for messages: "a string", "a table", "a boolean".
std::string kind_of(const toml::node& node);

}  // namespace weft::sim
