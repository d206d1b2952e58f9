// Reads TOML text into a checked Case.
#pragma once

#include <string>
#include <vector>

#include "sim/case/case.h"
#include "sim/case/case_error.h"

namespace weft::sim {

// Read and check a case. read_case() reads a file of at most 8 MiB. parse_case() reads `text`;
// `path` is the path of the file in messages and the base of relative paths.
//
// `overrides` are texts "KEY=VALUE", like the arguments of `--set`. KEY is a path with dots. VALUE
// is a TOML value, whose strings may be unquoted. An entry of a list is given by its name or, if no
// entry has that name, by its index from 0: "body.sheet.thickness=2e-3", "contact.friction=0.3",
// "body.0.position.2=1". An override may add a key that the text does not have, but no entry of a
// list, except for the material "default" of a case without materials. Overrides are applied in
// order, except that those of "include" come first and those that choose presets next. The
// overrides after these therefore also reach values of included files and of presets.
//
// Throws CaseError for a key or value that is unknown, missing, of the wrong type or impossible.
// Its hint gives the nearest name or the expected values. The place of the error is
//   the key      if it is unknown or does not belong there,
//   the value    if its type, number or name is wrong; in an array, the entry,
//   the header   of the table that lacks a key (line 1 of the file for the case itself),
//   `--set KEY=VALUE` or `preset "NAME"`, line 0, if the fault is in an override or a preset.
// A case whose estimated memory (memory_estimate.h) exceeds compute.memory_limit is refused, at the
// resolution of its largest shape. The estimate leaves out shapes from files, whose sizes are
// unknown before the files are opened.
Case read_case(const std::string& path, const std::vector<std::string>& overrides = {});
Case parse_case(const std::string& text, const std::string& path,
                const std::vector<std::string>& overrides = {});

// Return the JSON Schema (draft 2020-12) of a case file, and the reference page in Markdown.
std::string case_json_schema();
std::string case_reference_markdown();

}  // namespace weft::sim
