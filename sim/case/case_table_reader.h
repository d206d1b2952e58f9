// Reads tables of a TOML tree into the structs of case.h.
#pragma once

#include <toml++/toml.h>

#include <string>

#include "sim/case/case_locations.h"
#include "sim/case/case_schema.h"

namespace weft::sim {

// Reads the table `source`, and all tables inside it, into the struct that `target` describes. Adds
// the places of their keys and values to `locations`. `path` is the path of the table in the case
// (case_schema.h). Throws CaseError for unknown, missing and misplaced keys and for bad values, as
// described in case_reader.h.
void read_table(const toml::table& source, const Table& target, const std::string& path,
                Locations& locations);

// Reads the value `node` into the member of `field`, as read_table() does. `path` is the path of
// the field's key.
void read_field(const Field& field, const toml::node& node, const std::string& path,
                Locations& locations);

}  // namespace weft::sim
