// Overrides: values given to keys of a case from outside its file, by `--set` or by a sweep.
#pragma once

#include <toml++/toml.h>

#include <span>
#include <string>

#include "sim/case/case.h"

namespace weft::sim {

struct CaseOverride {
  std::string key;    // path with dots (see read_case())
  std::string value;  // TOML; if not `strict`, also a string without quotes
  // If true, the value must be TOML of the type that the key takes. If false, a key of a string
  // takes any text, as `--set` does.
  bool strict = true;
  SourceLocation key_place, value_place;  // places of errors
};

// Returns the override of an option "KEY=VALUE". Its places are `--set KEY=VALUE`, line 0. Throws
// CaseError for a text without "=".
CaseOverride override_of_option(const std::string& text);

// Applies an override to the tree of a case. Its places become those of the values that it sets.
// Throws CaseError for a key at which an override can set nothing, and for a value that is not
// UTF-8 or has a key of too many parts. Returns true if the key takes whole numbers only.
bool apply_override(toml::table& root, const CaseOverride& source);

// Reads and checks a case as parse_case() of case_reader.h does, with overrides that have places of
// their own.
Case parse_case(const std::string& text, const std::string& path,
                std::span<const CaseOverride> overrides);

// Reads a case with overrides, but does not check the rules between its keys: those may need other
// overrides as well. Throws CaseError for an unknown key, and for a value of the wrong type or
// beyond the limits of its key. Returns true if the key of the last override takes whole numbers
// only. Precondition: there is at least one override.
bool check_last_override(const std::string& text, const std::string& path,
                         std::span<const CaseOverride> overrides);

}  // namespace weft::sim
