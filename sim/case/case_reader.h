// Reads TOML text into a checked Case.
#pragma once

#include <string>
#include <vector>

#include "sim/case/case.h"
#include "sim/case/case_error.h"

namespace weft::sim {

// Reads and checks a case file of at most 8 MiB.
//
// `overrides` are "KEY=VALUE" as for `--set`, applied in order: KEY is a path with dots, VALUE a
// TOML value, whose strings may go unquoted. Entries of lists are named by their name or, if no
// entry has it, by their index from 0: "body.sheet.thickness=2e-3", "contact.friction=0.3",
// "body.0.position.2=1". An override may add a key that the text does not have, but no entry of a
// list. Overrides of "include" come before the others, which reach into included files
// (case_include.h).
//
// Throws CaseError, with the nearest name or the expected values, on anything unknown, missing, of
// the wrong type or impossible. The place of the error is
//   the key      that is unknown or does not belong there,
//   the value    of a wrong type, number or name; in an array, the entry,
//   the header   of the table that lacks a key (line 1 for the case itself),
//   "--set KEY=VALUE", line 0, if an override brought in the fault.
// A scene whose estimated memory (memory_estimate.h) exceeds compute.memory_limit is refused at the
// resolution of its largest shape. The scene checks shapes from files, whose sizes are known only
// once the files are opened.
Case read_case(const std::string& path, const std::vector<std::string>& overrides = {});
Case parse_case(const std::string& text, const std::string& path,
                const std::vector<std::string>& overrides = {});

// JSON Schema (draft 2020-12) of a case file, and the reference page in Markdown.
std::string case_json_schema();
std::string case_reference_markdown();

}  // namespace weft::sim
