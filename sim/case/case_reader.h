// Reads TOML text into a checked Case.
#pragma once

#include <string>
#include <vector>

#include "sim/case/case.h"
#include "sim/case/case_error.h"

namespace weft::sim {

// Reads and checks a case: read_case() a file of at most 8 MiB, parse_case() a text whose file
// would be `path`.
//
// `overrides` are "KEY=VALUE" as for `--set`, applied in order. KEY is a path with dots. VALUE is a
// TOML value, whose strings may be unquoted. An entry of a list is given by its name or, if no
// entry has that name, by its index from 0: "body.sheet.thickness=2e-3", "contact.friction=0.3",
// "body.0.position.2=1". An override may add a key that the text does not have, but no entry of a
// list. Overrides of "include" come first, so all others also reach included files
// (case_include.h).
//
// Throws CaseError for a key or value that is unknown, missing, of the wrong type or impossible. It
// gives the nearest name or the expected values. The place of the error is
//   the key      that is unknown or does not belong there,
//   the value    of a wrong type, number or name; in an array, the entry,
//   the header   of the table that lacks a key (line 1 for the case itself),
//   "--set KEY=VALUE", line 0, if an override caused the fault.
// A scene whose estimated memory (memory_estimate.h) exceeds compute.memory_limit is refused at the
// resolution of its largest shape. Sizes of shapes from files are unknown here; the scene checks
// these shapes when it opens the files.
Case read_case(const std::string& path, const std::vector<std::string>& overrides = {});
Case parse_case(const std::string& text, const std::string& path,
                const std::vector<std::string>& overrides = {});

// Return the JSON Schema (draft 2020-12) of a case file, and the reference page in Markdown.
std::string case_json_schema();
std::string case_reference_markdown();

}  // namespace weft::sim
