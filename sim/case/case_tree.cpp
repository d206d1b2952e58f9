#include "sim/case/case_tree.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string_view>

#include "sim/case/case_error.h"
#include "sim/case/case_writer.h"

namespace weft::sim {

namespace {

constexpr std::string_view override_prefix = "--set ";
constexpr std::string_view preset_prefix = "preset \"";
constexpr char place_mark = '\x1e';  // begins a path of path_for_place()
constexpr int most_key_parts = 1000;
// Largest size of a case file (bytes). A file of this size can hold a hundred thousand keyframes,
// and toml++ parses it in about two seconds.
constexpr std::size_t longest_case = std::size_t{8} << 20;

SourceLocation place_in(const std::string& text, std::size_t byte, const std::string& path) {
  const auto begin = text.begin();
  const auto end = begin + static_cast<std::ptrdiff_t>(byte);
  const std::size_t line = byte == 0 ? std::string::npos : text.rfind('\n', byte - 1);
  const std::size_t line_start = line == std::string::npos ? 0 : line + 1;
  return {path, static_cast<int>(std::count(begin, end, '\n')) + 1,
          static_cast<int>(byte - line_start) + 1};
}

// Returns the place of a path of path_for_place(), or nothing for the path of a file, which may
// begin with the mark as well.
std::optional<SourceLocation> place_in_path(const std::string& path) {
  if (!path.starts_with(place_mark)) return std::nullopt;
  SourceLocation place;
  const char* const end = path.data() + path.size();
  const auto line = std::from_chars(path.data() + 1, end, place.line);
  if (line.ec != std::errc() || line.ptr == end || *line.ptr != ':') return std::nullopt;
  const auto column = std::from_chars(line.ptr + 1, end, place.column);
  if (column.ec != std::errc() || column.ptr == end || *column.ptr != ':') return std::nullopt;
  place.file.assign(column.ptr + 1, end);
  return place;
}

}  // namespace

std::size_t find_deep_key(const std::string& text) {
  // These characters end a key. A piece of text with most_key_parts points and none of these
  // characters counts as a key that is too deep, even within a string or a comment.
  constexpr std::string_view separators = "\n=,[]{}#";
  std::size_t start = 0;
  int points = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (separators.find(text[i]) != std::string_view::npos) {
      start = i + 1;
      points = 0;
    } else if (text[i] == '.' && ++points >= most_key_parts) {
      return start;
    }
  }
  return std::string::npos;
}

FileText read_text(const std::string& path) {
  std::error_code ignored;  // an inaccessible path fails to open below
  const auto status = std::filesystem::status(path, ignored);
  if (std::filesystem::is_directory(status)) return {{}, "is a directory", {}};
  // Opening a pipe would wait for its writer, and a device may come to no end.
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    return {{}, "is not a regular file", {}};
  std::ifstream file(path, std::ios::binary);
  std::string text;
  std::array<char, 65536> part{};
  while (file && text.size() <= longest_case) {
    file.read(part.data(), part.size());
    text.append(part.data(), static_cast<std::size_t>(file.gcount()));
  }
  if (text.size() > longest_case) {
    return {{},
            "is longer than " + std::to_string(longest_case >> 20) + " MiB",
            "; large shapes belong into HDF5 files (type = \"file\")"};
  }
  if (!file.eof()) return {{}, std::string("cannot be read: ") + std::strerror(errno), {}};
  return {std::move(text), {}, {}};
}

const toml::key* first_key_beside(const std::vector<std::string>& allowed,
                                  const toml::table& table) {
  const toml::key* first = nullptr;
  for (auto&& [key, node] : table) {
    if (std::ranges::find(allowed, key.str()) != allowed.end()) continue;
    if (first == nullptr || key.source().begin < first->source().begin) first = &key;
  }
  return first;
}

std::string path_for_place(const SourceLocation& place) {
  if (place.line == 0) return place.file;
  return place_mark + std::to_string(place.line) + ':' + std::to_string(place.column) + ':' +
         place.file;
}

SourceLocation location_of(const toml::source_region& source) {
  SourceLocation where;
  if (source.path) where.file = *source.path;
  if (const auto place = place_in_path(where.file)) return *place;
  if (where.file.starts_with(override_prefix) || where.file.starts_with(preset_prefix))
    return where;
  where.line = static_cast<int>(source.begin.line);
  where.column = static_cast<int>(source.begin.column);
  return where;
}

std::string toml_text(const toml::node& node) {
  std::string text;
  if (const auto* array = node.as_array()) {
    for (const toml::node& entry : *array) text += (text.empty() ? "" : ", ") + toml_text(entry);
    return '[' + text + ']';
  }
  if (const auto* table = node.as_table()) {
    for (auto&& [key, value] : *table) {
      text += (text.empty() ? "" : ", ") + toml_string(std::string(key.str())) + " = " +
              toml_text(value);
    }
    return "{ " + text + " }";
  }
  if (const auto* string = node.as_string()) return toml_string(string->get());
  if (const auto* number = node.as_floating_point()) {
    const double value = number->get();
    return std::isfinite(value) ? toml_number(value)
           : std::isnan(value)  ? "nan"
           : value > 0          ? "inf"
                                : "-inf";
  }
  if (const auto* whole = node.as_integer()) return std::to_string(whole->get());
  if (const auto* truth = node.as_boolean()) return truth->get() ? "true" : "false";
  std::ostringstream stream;  // a date or time
  node.visit([&](const auto& each) {
    if constexpr (toml::is_value<decltype(each)>) stream << each.get();
  });
  return stream.str();
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
  if (const std::size_t deep = find_deep_key(text); deep != std::string::npos) {
    throw CaseError(place_in(text, deep, path),
                    "a key of more than " + std::to_string(most_key_parts) + " parts",
                    "expected at most a few");
  }
  try {
    return toml::parse(std::string_view(text), std::string_view(path));
  } catch (const toml::parse_error& error) {
    // The message is like "Error while parsing key-value pair: expected value, saw '\n'". The part
    // from "expected" on becomes the hint.
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
