// Functions of Limits, Field and Table (case_schema.h), and descriptions of fields in words.
#include <algorithm>
#include <cmath>

#include "sim/case/case_schema.h"
#include "sim/case/case_text.h"

namespace weft::sim {

bool Limits::allow(double value) const {
  if (!std::isfinite(value)) return false;
  const bool above = minimum_excluded ? value > minimum : value >= minimum;
  const bool below = maximum_excluded ? value < maximum : value <= maximum;
  return above && below;
}

std::string Limits::text() const {
  std::string text;
  if (std::isfinite(minimum)) {
    text += (minimum_excluded ? " > " : " >= ") + number_text(minimum);
  }
  if (std::isfinite(maximum)) {
    text += text.empty() ? "" : " and";
    text += (maximum_excluded ? " < " : " <= ") + number_text(maximum);
  }
  return text;
}

Field& Field::with_default(std::string text) {
  default_text = std::move(text);
  return *this;
}

Field& Field::needed() {
  required = true;
  return *this;
}

Field& Field::named_with_letters() {
  identifier = true;
  return *this;
}

Field& Field::entries(std::size_t minimum, std::size_t maximum) {
  minimum_entries = minimum;
  maximum_entries = maximum;
  return *this;
}

Field& Field::out_of(std::vector<std::string> allowed) {
  names = std::move(allowed);
  return *this;
}

Field& Field::only_for(std::string choice_key, std::vector<std::string> values) {
  switch_key = std::move(choice_key);
  switch_values = std::move(values);
  return *this;
}

Field& Field::not_with(std::string key_that_excludes) {
  excluded_by.push_back(std::move(key_that_excludes));
  return *this;
}

Field& Field::may_be_gust() {
  takes_gust = true;
  return *this;
}

const Field* Table::find(const std::string& key) const {
  const auto found = std::find_if(fields.begin(), fields.end(),
                                  [&](const Field& candidate) { return candidate.key == key; });
  return found == fields.end() ? nullptr : &*found;
}

std::vector<std::string> Table::keys() const {
  std::vector<std::string> result;
  for (const Field& each : fields) result.push_back(each.key);
  return result;
}

bool applies(const Field& field, const Table& table) {
  if (field.switch_key.empty()) return true;
  const Field& by = *table.find(field.switch_key);
  const auto& choice = std::get<Choice>(by.member);
  const std::string& chosen = choice.names[choice.get()];
  return applies(by, table) && std::find(field.switch_values.begin(), field.switch_values.end(),
                                         chosen) != field.switch_values.end();
}

const Field& ruled_out_by(const Field& field, const Table& table) {
  const Field& by = *table.find(field.switch_key);
  return applies(by, table) ? field : ruled_out_by(by, table);
}

namespace {

// Returns the allowed number of entries in words: "2 numbers", "1 to 2 whole numbers", "names".
std::string count_text(const Field& field, const std::string& noun) {
  const std::size_t least = field.minimum_entries;
  const std::size_t most = field.maximum_entries;
  if (most == 0) return noun + "s";
  const std::string count =
      least == most ? std::to_string(most) : std::to_string(least) + " to " + std::to_string(most);
  return count + ' ' + noun + 's';
}

// Visitor that returns the allowed values of a field in words.
struct ExpectedText {
  const Field& field;

  std::string limits() const {
    return field.limits.text() + (field.unit.empty() ? "" : " (" + field.unit + ")");
  }
  std::string operator()(const bool*) const { return "true or false"; }
  std::string operator()(const int*) const { return "a whole number" + limits(); }
  std::string operator()(const std::optional<int>*) const {
    return "a whole number" + limits() + " or \"auto\"";
  }
  std::string operator()(const double*) const { return "a number" + limits(); }
  std::string operator()(const std::optional<double>*) const { return "a number" + limits(); }
  std::string operator()(const std::string*) const {
    if (!field.names.empty()) return "one of " + quoted_list(field.names);
    return field.identifier ? "a name of letters, digits, _ and -" : "a string";
  }
  std::string operator()(const Vec3*) const { return "an array of 3 numbers" + limits(); }
  std::string operator()(const std::optional<Vec3>*) const {
    return "an array of 3 numbers" + limits();
  }
  std::string operator()(const std::vector<int>*) const {
    return "an array of " + count_text(field, "whole number") + limits();
  }
  std::string operator()(const std::vector<double>*) const {
    return "an array of " + count_text(field, "number") + limits();
  }
  std::string operator()(const std::vector<Vec3>*) const {
    return "an array of arrays of 3 numbers" + limits();
  }
  std::string operator()(const std::vector<std::string>*) const {
    return "an array of " + count_text(field, "name") +
           (field.names.empty() ? "" : " out of " + quoted_list(field.names));
  }
  std::string operator()(const std::vector<TomlValue>*) const { return "an array of values"; }
  std::string operator()(const std::vector<KeyedValue>*) const {
    return "a table of case keys in quotes";
  }
  std::string operator()(const Varying<double>*) const {
    return (*this)(static_cast<const double*>(nullptr)) + " or a curve";
  }
  std::string operator()(const Varying<Vec3>*) const {
    return (*this)(static_cast<const Vec3*>(nullptr)) +
           (field.takes_gust ? ", a curve or a gust" : " or a curve");
  }
  std::string operator()(const Choice& choice) const {
    return "one of " + quoted_list(choice.names);
  }
  std::string operator()(const TableMember&) const { return "a table"; }
  std::string operator()(const TableList& list) const {
    return list.named ? "tables by name" : "an array of tables";
  }
  std::string operator()(const std::vector<OutputExpression>*) const {
    return "expressions by name";
  }
};

}  // namespace

std::string expected_text(const Field& field) {
  return std::visit(ExpectedText{field}, field.member);
}

std::string heading(const std::string& path) {
  if (path.empty()) return "the case";
  std::string keys;
  bool inside_index = false;
  for (const char c : path) {
    if (c == '[') inside_index = true;
    if (!inside_index) keys += c;
    if (c == ']') inside_index = false;
  }
  return path.back() == ']' ? "[[" + keys + "]]" : '[' + keys + ']';
}

std::string join_path(const std::string& path, const std::string& key) {
  return path.empty() ? key : path + '.' + key;
}

std::string join_path(const std::string& path, std::size_t index) {
  return path + '[' + std::to_string(index) + ']';
}

}  // namespace weft::sim
