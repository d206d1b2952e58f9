#include <cstdio>
#include <cstdlib>

#include "sim/case/case_reader.h"
#include "tests/fuzz/fuzz_readers.h"
#include "tests/fuzz/input_files.h"

namespace weft::sim {

namespace {

[[noreturn]] void fail_case(const std::string& what, const std::string& text) {
  std::fprintf(stderr, "%s:\n%s\n", what.c_str(), text.c_str());
  std::abort();
}

// Checks the promise that a resolved text is a case, and the same case.
void require_resolved(const Case& source) {
  std::string again;
  try {
    again = parse_case(source.resolved_text, source.path).resolved_text;
  } catch (const CaseError& error) {
    fail_case("a resolved text is refused", error.what() + ('\n' + source.resolved_text));
  }
  if (again != source.resolved_text)
    fail_case("a resolved text becomes another", source.resolved_text + "----\n" + again);
}

}  // namespace

void fuzz_case(std::string_view input) {
  const InputSections sections = split_sections(input);
  const InputFolder& folder = empty_input_folder();
  std::vector<std::string> overrides;
  for (const auto& [name, text] : sections.named) {
    if (name == "overrides") {
      overrides = lines_of(text);
    } else {
      folder.write(name, text);
    }
  }
  try {
    require_resolved(parse_case(sections.main, folder.path("case.toml"), overrides));
  } catch (const CaseError&) {
  }
}

}  // namespace weft::sim
