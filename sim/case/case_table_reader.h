// Reads tables of the TOML tree into the structs of case.h.
#pragma once

#include <toml++/toml.h>

#include <string>

#include "sim/case/case_locations.h"
#include "sim/case/case_schema.h"

namespace weft::sim {

// Reads a table of the tree, and all tables inside it, into the struct that `target` describes, and
// adds the places of its keys and values. `path` is that of the table in the case (case_schema.h).
// Throws CaseError, as read_case() (case_reader.h) says, on unknown, missing and misplaced keys and
// on bad values.
void read_table(const toml::table& source, const Table& target, const std::string& path,
                Locations& locations);

// Reads the value of the key at `path` in the same way.
void read_field(const Field& field, const toml::node& node, const std::string& path,
                Locations& locations);

}  // namespace weft::sim
