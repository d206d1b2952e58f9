#include "sim/case/case_writer.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <sstream>

#include "sim/case/case_schema.h"
#include "sim/case/case_text.h"

namespace weft::sim {

namespace {

template <class Entries, class Text>
std::string toml_array(const Entries& entries, Text text) {
  std::string list;
  for (const auto& entry : entries) list += (list.empty() ? "" : ", ") + text(entry);
  return '[' + list + ']';
}

std::string vector_text(const Vec3& vector) {
  return toml_array(std::array{vector[0], vector[1], vector[2]}, toml_number);
}

// Returns the table as TOML on one line.
std::string inline_table(const Table& table) {
  std::string text;
  for (const Field& field : table.fields)
    text += (text.empty() ? "" : ", ") + field.key + " = " + value_text(field);
  return "{ " + text + " }";
}

// Visitor that returns the TOML text of a member (see value_text()).
struct ValueText {
  const Field& field;

  std::string operator()(const bool* value) const { return *value ? "true" : "false"; }
  std::string operator()(const int* value) const { return std::to_string(*value); }
  std::string operator()(const std::optional<int>* value) const {
    return *value ? std::to_string(**value) : toml_string("auto");
  }
  std::string operator()(const double* value) const { return toml_number(*value); }
  std::string operator()(const std::optional<double>* value) const {
    return *value ? toml_number(**value) : "";
  }
  // A string with a list of allowed names, and a name, may be absent; it is then empty.
  std::string operator()(const std::string* value) const {
    const bool may_be_absent = !field.names.empty() || field.identifier;
    return value->empty() && may_be_absent ? "" : toml_string(*value);
  }
  std::string operator()(const Vec3* value) const { return vector_text(*value); }
  std::string operator()(const std::optional<Vec3>* value) const {
    return *value ? (*this)(&**value) : "";
  }
  std::string operator()(const std::vector<int>* value) const {
    return value->empty() ? ""
                          : toml_array(*value, [](int entry) { return std::to_string(entry); });
  }
  std::string operator()(const std::vector<double>* value) const {
    return value->empty() ? "" : toml_array(*value, toml_number);
  }
  std::string operator()(const std::vector<std::string>* value) const {
    return value->empty() ? "" : toml_array(*value, toml_string);
  }
  std::string operator()(const std::vector<Vec3>* value) const {
    return value->empty() ? "" : toml_array(*value, vector_text);
  }
  std::string operator()(const std::vector<TomlValue>* value) const {
    return value->empty() ? ""
                          : toml_array(*value, [](const TomlValue& each) { return each.text; });
  }
  std::string operator()(const std::vector<KeyedValue>* value) const {
    std::string text;
    for (const KeyedValue& each : *value) {
      text += (text.empty() ? "{ " : ", ") + toml_string(each.key) + " = " + each.value.text;
    }
    return text.empty() ? "" : text + " }";
  }
  template <class Value>
  std::string operator()(const Varying<Value>* value) const {
    Varying<Value> copy = *value;  // describe_curve() needs a curve that it could change
    if (auto* curve = std::get_if<CurveCase<Value>>(&copy.form))
      return inline_table(describe_curve(*curve, field));
    if (auto* gust = std::get_if<GustCase>(&copy.form)) return inline_table(describe_gust(*gust));
    return (*this)(static_cast<const Value*>(std::get_if<Value>(&copy.form)));
  }
  std::string operator()(const Choice& choice) const {
    return toml_string(choice.names[choice.get()]);
  }
  std::string operator()(const TableMember&) const { return ""; }
  std::string operator()(const TableList&) const { return ""; }
  std::string operator()(const std::vector<OutputExpression>*) const { return ""; }
};

bool is_table(const Field& field) {
  return std::holds_alternative<TableMember>(field.member) ||
         std::holds_alternative<TableList>(field.member) ||
         std::holds_alternative<std::vector<OutputExpression>*>(field.member);
}

// True if the field says more than nothing: false says nothing.
bool has_value(const Field& field) {
  if (const auto* list = std::get_if<TableList>(&field.member)) return list->size() > 0;
  if (const auto* member = std::get_if<TableMember>(&field.member)) return member->present();
  if (const auto* value = std::get_if<bool*>(&field.member)) return **value;
  return !value_text(field).empty();
}

// True if a field that excludes this one (Field::excluded_by) has a value. A false field is also
// left out if it excludes a field that has a value: the reader accepts only one of the two.
bool is_excluded(const Field& field, const Table& table) {
  if (std::ranges::any_of(field.excluded_by,
                          [&](const std::string& key) { return has_value(*table.find(key)); }))
    return true;
  return !has_value(field) && std::holds_alternative<bool*>(field.member) &&
         std::ranges::any_of(table.fields, [&](const Field& other) {
           return std::ranges::count(other.excluded_by, field.key) > 0 && has_value(other);
         });
}

void write_table(const Table& table, const std::string& header, std::string& text);

struct TableWriter {
  std::string key;  // path of the member, with dots but without indices
  std::string& text;

  void operator()(const TableMember& member) const {
    if (!member.present()) return;
    text += "\n[" + key + "]\n";
    write_table(member.open(), key, text);
  }
  void operator()(const TableList& list) const {
    for (std::size_t i = 0; i < list.size(); ++i) {
      const Table entry = list.at(i);
      const std::string name = list.named ? key + '.' + *entry.name : key;
      text += list.named ? "\n[" + name + "]\n" : "\n[[" + name + "]]\n";
      write_table(entry, name, text);
    }
  }
  void operator()(const std::vector<OutputExpression>* outputs) const {
    if (outputs->empty()) return;
    text += "\n[" + key + "]\n";
    for (const OutputExpression& output : *outputs)
      text += output.name + " = " + toml_string(output.text.text) + '\n';
  }
  template <class Value>
  void operator()(const Value*) const {}
  void operator()(const Choice&) const {}
};

// Writes a table: first its values, then the tables inside it. In TOML, a value after the header of
// an inner table would belong to that table.
void write_table(const Table& table, const std::string& header, std::string& text) {
  for (const Field& field : table.fields) {
    if (is_table(field) || !applies(field, table) || is_excluded(field, table)) continue;
    const std::string value = value_text(field);
    if (!value.empty()) {
      text += field.key + " = " + value + '\n';
    } else if (!field.default_text.empty()) {
      text += "# " + field.key + ": " + field.default_text + '\n';
    }
  }
  for (const Field& field : table.fields) {
    std::visit(TableWriter{join_path(header, field.key), text}, field.member);
  }
}

}  // namespace

std::string value_text(const Field& field) { return std::visit(ValueText{field}, field.member); }

std::string toml_number(double value) {
  std::string text = number_text(value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string toml_string(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      result += '\\';
      result += c;
    } else if (code < 0x20 || code == 0x7f) {
      std::array<char, 8> escape{};
      std::snprintf(escape.data(), escape.size(), "\\u%04X", static_cast<unsigned>(code));
      result += escape.data();
    } else {
      result += c;
    }
  }
  return result + '"';
}

std::string without_obsolete_keys(const std::string& text) {
  std::istringstream lines(text);
  std::string result, line;
  bool is_load = false, is_area = false;
  while (std::getline(lines, line)) {
    if (line.starts_with('[')) is_load = line == "[[load]]";
    if (line.starts_with("type = "))
      is_area = line == "type = \"area\"" || line == "type = \"pressure\"";
    if (is_load && is_area && line == "patch = 0") continue;
    result += line + '\n';
  }
  return result;
}

std::string motion_text(const Case& source) {
  Case motion = source;
  motion.compute = {};
  motion.outputs.clear();
  motion.time.duration = TimeCase{}.duration;
  if (!motion.accuracy_choice.empty()) motion.time.accuracy.reset();
  motion.accuracy_choice.clear();
  return case_text(motion);
}

std::string case_text(const Case& source) {
  Case copy = source;  // describe() needs a case that it could change
  std::string text;
  if (!source.accuracy_choice.empty()) {
    text = "# time.accuracy: " + source.accuracy_choice + '\n';
    copy.time.accuracy.reset();
  }
  write_table(describe(copy), "", text);
  return text;
}

}  // namespace weft::sim
