// Writes a Case back as TOML.
#pragma once

#include <string>

#include "sim/case/case.h"
#include "sim/case/case_schema.h"

namespace weft::sim {

// Returns the case as TOML with every default, in the order of case_schema.cpp. Computed defaults
// become comments. If the text is parsed again beside the files that it names, it gives an equal
// case and, bit for bit, the same text.
std::string case_text(const Case& source);

// Returns the value of a field as TOML; empty for a table, an empty list or an absent value.
std::string value_text(const Field& field);

// Returns a TOML basic string, quoted and escaped, on one line.
std::string toml_string(const std::string& text);

// Returns a TOML float that reads back as the same bits: 1.0, 1e-05.
std::string toml_number(double value);

}  // namespace weft::sim
