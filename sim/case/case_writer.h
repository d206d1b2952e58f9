// Writes a Case back as TOML.
#pragma once

#include <string>

#include "sim/case/case.h"
#include "sim/case/case_schema.h"

namespace weft::sim {

// Returns the case as TOML, with the defaults of all keys that apply. The keys are in the order of
// the schema, except that tables come after the values beside them. Defaults without a value become
// comments, and so does source.accuracy_choice. If accuracy_choice is empty, parse_case() turns the
// text back into an equal case with the identical text, provided that the files named by the text
// exist.
std::string case_text(const Case& source);

// Returns the part of case_text() on which the motion depends: without the tables [compute] and
// [outputs], the duration, and the words of source.accuracy_choice.
std::string motion_text(const Case& source);

// Returns a text of case_text() or motion_text() of an older Weft in the form of this one: without
// the "patch = 0" of loads on areas, which they have no longer. Other texts stay as they are.
std::string without_obsolete_keys(const std::string& text);

// Returns the value of a field as TOML. Returns an empty text for a table, an empty list or an
// absent value; but an absent whole number is "auto".
std::string value_text(const Field& field);

// Returns a TOML basic string, quoted and escaped, on one line.
std::string toml_string(const std::string& text);

// Returns a TOML float that reads back as the same bits: 1.0, 1e-05.
std::string toml_number(double value);

}  // namespace weft::sim
