#include "sim/case/case_tree.h"

#include <string_view>

#include "sim/case/case_error.h"

namespace weft::sim {

namespace {

constexpr std::string_view override_prefix = "--set ";

}  // namespace

SourceLocation location_of(const toml::source_region& source) {
  SourceLocation where;
  if (source.path) where.file = *source.path;
  if (where.file.starts_with(override_prefix)) return where;
  where.line = static_cast<int>(source.begin.line);
  where.column = static_cast<int>(source.begin.column);
  return where;
}

std::string kind_of(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "an array";
    case toml::node_type::string:
      return "a string";
    case toml::node_type::integer:
      return "a whole number";
    case toml::node_type::floating_point:
      return "a number with a point or exponent";
    case toml::node_type::boolean:
      return "a boolean";
    default:
      return "a date or time";
  }
}

toml::table parse_toml(const std::string& text, const std::string& path) {
  try {
    return toml::parse(std::string_view(text), std::string_view(path));
  } catch (const toml::parse_error& error) {
    // "Error while parsing key-value pair: expected value, saw '\n'": the second half is a hint.
    const std::string description(error.description());
    const std::size_t hint = description.find(": expected");
    const SourceLocation where{path, static_cast<int>(error.source().begin.line),
                               static_cast<int>(error.source().begin.column)};
    if (hint == std::string::npos) {
      throw CaseError(where, "not TOML: " + description, "expected TOML as in https://toml.io");
    }
    throw CaseError(where, "not TOML: " + description.substr(0, hint),
                    description.substr(hint + 2));
  }
}

}  // namespace weft::sim
