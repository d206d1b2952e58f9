// Reads TOML text into a checked Case.
#pragma once

#include <string>
#include <vector>

#include "sim/case/case.h"
#include "sim/case/case_error.h"

namespace weft::sim {

// Reads and checks a case file of at most 8 MiB. `overrides` are "key.path=TOML value" (as
// `--set`), applied in order: tables by key, array entries by name or, where no entry has that
// name, by index from 0
// ("body.sheet.thickness=2e-3", "contact.friction=0.3", "body.0.position.2=1"); strings may go
// unquoted. An override may make a key that the text leaves out, never a list's entry.
//
// Throws CaseError, with the nearest name or what was expected, on anything unknown, missing, of
// the wrong type or impossible. Its place is
//   the key      of what is unknown or does not belong there,
//   the value    of a wrong type, number or name, and the entry where it is in an array,
//   the header   of the table that lacks a key (line 1 for the case itself),
//   "--set KEY=VALUE", line 0, for what an override brought in.
// A scene that needs more memory than compute.memory_limit by its estimate (memory_estimate.h) is
// refused at the resolution of its largest shape.
// Sizes of images that are only known once a file shape is opened are checked by the scene.
Case read_case(const std::string& path, const std::vector<std::string>& overrides = {});
Case parse_case(const std::string& text, const std::string& path,
                const std::vector<std::string>& overrides = {});

// JSON Schema (draft 2020-12) of a case file, and the reference page in Markdown.
std::string case_json_schema();
std::string case_reference_markdown();

}  // namespace weft::sim
