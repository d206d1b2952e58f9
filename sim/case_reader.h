// From TOML text to a checked Case.
#pragma once

#include <string>
#include <vector>

#include "sim/case.h"
#include "sim/case_error.h"

namespace weft::sim {

// Reads and checks a case file. `overrides` are "key.path=TOML value" (as `--set`): tables by key,
// array entries by index or by name ("body.sheet.thickness=2e-3", "contact.friction=0.3"); strings
// may go unquoted. Throws CaseError on anything unknown, missing, of the wrong type or impossible,
// with the place and the nearest valid name. Sizes of images that are only known once a file shape
// is opened are checked by the scene.
Case read_case(const std::string& path, const std::vector<std::string>& overrides = {});
Case parse_case(const std::string& text, const std::string& path,
                const std::vector<std::string>& overrides = {});

// JSON Schema (draft 2020-12) of a case file, and the reference page in Markdown.
std::string case_json_schema();
std::string case_reference_markdown();

}  // namespace weft::sim
