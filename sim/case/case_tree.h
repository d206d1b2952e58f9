// The TOML tree of a case: text parsed, overrides applied, places known; nothing checked yet.
#pragma once

#include <toml++/toml.h>

#include <string>
#include <vector>

#include "sim/case/case.h"

namespace weft::sim {

// Throws CaseError with the place of a syntax error, or of a key with more parts than toml++ can
// take.
toml::table parse_toml(const std::string& text, const std::string& path);

// Applies one `KEY=VALUE` (see read_case). Throws CaseError, placed at "--set KEY=VALUE" with line
// 0, on a key that no case has, an entry that this case does not have, or a path through a value.
// Every value it sets knows the override as its source.
void apply_override(toml::table& root, const std::string& text);

// Line 0 for what came from an override, whose file is then `--set KEY=VALUE`.
SourceLocation location_of(const toml::source_region& source);

// Finds a key of more than a thousand parts (a.a.a...) in TOML text, as its first byte; npos:
// nowhere. toml++ makes a table for each part and overruns the stack on some ten thousand.
std::size_t find_deep_key(const std::string& text);

// "a string", "a table", ...: what a value is, for messages.
std::string kind_of(const toml::node& node);

}  // namespace weft::sim
