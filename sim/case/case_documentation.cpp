// Writes the JSON schema and the reference page of case files from the schema (case_schema.h).
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/case/case_reader.h"
#include "sim/case/case_schema.h"
#include "sim/case/case_text.h"
#include "sim/case/case_writer.h"

namespace weft::sim {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* identifier_pattern = "^[A-Za-z0-9_-]+$";

Json table_schema(const Table& table);

// Returns the JSON schema of a number within the field's limits.
Json number_schema(const Field& field, const char* type) {
  Json schema{{"type", type}};
  const Limits& limits = field.limits;
  if (std::isfinite(limits.minimum)) {
    schema[limits.minimum_excluded ? "exclusiveMinimum" : "minimum"] = limits.minimum;
  }
  if (std::isfinite(limits.maximum)) {
    schema[limits.maximum_excluded ? "exclusiveMaximum" : "maximum"] = limits.maximum;
  }
  return schema;
}

Json array_schema(Json items, std::size_t least, std::size_t most) {
  Json schema{{"type", "array"}, {"items", std::move(items)}, {"minItems", least}};
  if (most > 0) schema["maxItems"] = most;
  return schema;
}

// Visitor that returns the JSON schema of a field. The schema of a number, a boolean, a Vec3 or a
// choice has the default, if that is a constant.
struct FieldSchema {
  const Field& field;

  Json operator()(const bool* value) const { return {{"type", "boolean"}, {"default", *value}}; }
  Json operator()(const int* value) const {
    Json schema = number_schema(field, "integer");
    if (!field.required) schema["default"] = *value;
    return schema;
  }
  Json operator()(const std::optional<int>* value) const {
    Json schema = number_schema(field, "integer");
    schema["type"] = {"integer", "string"};
    schema["pattern"] = "^auto$";
    if (*value) {
      schema["default"] = **value;
    } else {
      schema["default"] = "auto";
    }
    return schema;
  }
  Json operator()(const double* value) const {
    Json schema = number_schema(field, "number");
    if (!field.required) schema["default"] = *value;
    return schema;
  }
  Json operator()(const std::optional<double>*) const { return number_schema(field, "number"); }
  Json operator()(const std::string*) const {
    Json schema{{"type", "string"}};
    if (field.identifier) schema["pattern"] = identifier_pattern;
    if (!field.names.empty()) schema["enum"] = field.names;
    return schema;
  }
  Json operator()(const Vec3* value) const {
    Json schema = array_schema(number_schema(field, "number"), 3, 3);
    schema["default"] = {(*value)[0], (*value)[1], (*value)[2]};
    return schema;
  }
  Json operator()(const std::optional<Vec3>*) const {
    return array_schema(number_schema(field, "number"), 3, 3);
  }
  Json operator()(const std::vector<int>*) const {
    return entries(number_schema(field, "integer"));
  }
  Json operator()(const std::vector<double>*) const {
    return entries(number_schema(field, "number"));
  }
  Json operator()(const std::vector<Vec3>*) const {
    return entries(array_schema(number_schema(field, "number"), 3, 3));
  }
  Json operator()(const std::vector<std::string>*) const {
    if (field.names.empty()) return entries({{"type", "string"}, {"pattern", identifier_pattern}});
    return entries({{"enum", field.names}});
  }
  Json operator()(const std::vector<TomlValue>*) const { return entries(Json::object()); }
  Json operator()(const std::vector<KeyedValue>*) const { return {{"type", "object"}}; }
  // Returns the schema of a value that may vary in time: a constant, a curve or, if the field takes
  // one, a gust. Its default is a constant.
  template <class Value>
  Json operator()(const Varying<Value>* value) const {
    const Value constant = value->constant();
    Json schema = (*this)(&constant);
    const Json by_default = schema["default"];
    schema.erase("default");
    Json forms = Json::array({std::move(schema)});
    CurveCase<Value> curve;
    forms.push_back(table_schema(describe_curve(curve, field)));
    GustCase gust;
    if (field.takes_gust) forms.push_back(table_schema(describe_gust(gust)));
    return {{"anyOf", std::move(forms)}, {"default", by_default}};
  }
  Json operator()(const Choice& choice) const {
    Json schema{{"enum", choice.names}};
    if (!field.required) schema["default"] = choice.names[choice.get()];
    return schema;
  }
  Json operator()(const TableMember& member) const { return table_schema(member.open()); }
  Json operator()(const TableList& list) const {
    Json entry = table_schema(list.append());
    if (!list.named) return array_schema(std::move(entry), 1, 0);
    if (list.named_by_case_keys)
      return {{"type", "object"}, {"additionalProperties", std::move(entry)}};
    return {{"type", "object"},
            {"additionalProperties", std::move(entry)},
            {"propertyNames", {{"pattern", identifier_pattern}}}};
  }
  Json operator()(const std::vector<OutputExpression>*) const {
    return {{"type", "object"},
            {"additionalProperties", {{"type", "string"}}},
            {"propertyNames", {{"pattern", identifier_pattern}}}};
  }

 private:
  Json entries(Json items) const {
    return array_schema(std::move(items), field.minimum_entries, field.maximum_entries);
  }
};

// Returns the rule for one value of a switch: the keys that this value requires and forbids.
Json switch_schema(const Table& table, const Field& switch_field, const std::string& value) {
  const auto& choice = std::get<Choice>(switch_field.member);
  Json condition{{"properties", {{switch_field.key, {{"const", value}}}}}};
  // If the value is the default, the condition also holds without the key.
  const bool is_default = !switch_field.required && choice.names[choice.get()] == value;
  if (!is_default) condition["required"] = {switch_field.key};
  Json needed = Json::array();
  Json forbidden = Json::object();
  for (const Field& field : table.fields) {
    // The loop follows the chain of switches from this field to the one that depends directly on
    // `switch_field`, or else to the end of the chain.
    const Field* by = &field;
    while (!by->switch_key.empty() && by->switch_key != switch_field.key)
      by = table.find(by->switch_key);
    if (by->switch_key.empty()) continue;
    const bool belongs = std::find(by->switch_values.begin(), by->switch_values.end(), value) !=
                         by->switch_values.end();
    if (!belongs) {
      forbidden[field.key] = false;
    } else if (field.required && by == &field) {
      needed.push_back(field.key);
    }
  }
  Json consequence{{"properties", std::move(forbidden)}};
  if (!needed.empty()) consequence["required"] = std::move(needed);
  return {{"if", std::move(condition)}, {"then", std::move(consequence)}};
}

// Adds the rules between the keys of a table: its switches, and keys that exclude other keys.
void add_key_rules(const Table& table, Json& schema) {
  for (const Field& field : table.fields) {
    if (const auto* choice = std::get_if<Choice>(&field.member)) {
      for (const std::string& value : choice->names) {
        schema["allOf"].push_back(switch_schema(table, field, value));
      }
    }
    for (const std::string& other : field.excluded_by)
      schema["dependentSchemas"][other]["properties"][field.key] = false;
  }
}

Json table_schema(const Table& table) {
  Json schema{{"type", "object"}, {"additionalProperties", false}};
  Json required = Json::array();
  for (const Field& field : table.fields) {
    Json entry = std::visit(FieldSchema{field}, field.member);
    entry["description"] = field.meaning;
    if (!field.unit.empty()) entry["unit"] = field.unit;
    schema["properties"][field.key] = std::move(entry);
    if (field.required && field.switch_key.empty()) required.push_back(field.key);
  }
  if (!required.empty()) schema["required"] = std::move(required);
  add_key_rules(table, schema);
  return schema;
}

std::string code(const std::string& text) { return '`' + text + '`'; }

std::string default_cell(const Field& field) {
  if (field.required) return "**required**";
  if (!field.default_text.empty()) return field.default_text;
  const std::string value = value_text(field);
  return value.empty() ? "none" : code(value);
}

std::string meaning_cell(const Field& field) {
  std::string text = field.meaning;
  std::string values;
  for (const std::string& value : field.switch_values) {
    values += (values.empty() ? "" : ", ") + code(toml_string(value));
  }
  if (!values.empty()) text += " Only with " + code(field.switch_key) + " = " + values + '.';
  for (const std::string& other : field.excluded_by) text += " Not with " + code(other) + '.';
  return text;
}

void write_page(const Table& table, const std::string& path, std::string& page);

// Visitor that writes the section about a table inside another table. Other members have no
// section.
struct Section {
  const Field& field;
  const std::string& path;
  std::string& page;

  void operator()(const TableMember& member) const {
    begin('[' + path + ']');
    write_page(member.open(), path, page);
  }
  void operator()(const TableList& list) const {
    const char* name = list.named_by_case_keys ? ".\"KEY\"" : ".NAME";
    const std::string inner = list.named ? path + name : path;
    begin(list.named ? '[' + inner + ']' : "[[" + inner + "]]");
    write_page(list.append(), inner, page);
  }
  void operator()(const std::vector<OutputExpression>*) const {
    begin('[' + path + ']');
    page +=
        "\n| key | value | default | meaning |\n| --- | --- | --- | --- |\n"
        "| any name | an expression in quotes | none | A number of the run. |\n";
  }
  template <class Value>
  void operator()(const Value*) const {}
  void operator()(const Choice&) const {}

 private:
  void begin(const std::string& title) const {
    page +=
        "\n## " + code(title) + "\n\n" + field.meaning + (field.required ? " Required.\n" : "\n");
  }
};

bool is_table(const Field& field) {
  return std::holds_alternative<TableMember>(field.member) ||
         std::holds_alternative<TableList>(field.member) ||
         std::holds_alternative<std::vector<OutputExpression>*>(field.member);
}

void write_page(const Table& table, const std::string& path, std::string& page) {
  page += "\n| key | value | default | meaning |\n| --- | --- | --- | --- |\n";
  for (const Field& field : table.fields) {
    page += "| " + code(field.key) + " | " + expected_text(field) + " | " +
            (is_table(field) && !field.required ? "none" : default_cell(field)) + " | " +
            meaning_cell(field) + " |\n";
  }
  for (const Field& field : table.fields) {
    const std::string inner = join_path(path, field.key);
    std::visit(Section{field, inner, page}, field.member);
  }
}

// Writes the section about keys that may vary in time.
void write_forms(std::string& page) {
  std::string keys;
  for (const std::string& key : keys_that_vary()) keys += (keys.empty() ? "" : ", ") + code(key);
  page += "\n## Keys that vary in time\n\nEach of " + keys +
          " takes, instead of a constant, a curve:\n";
  CurveCase<double> curve;
  Field of;
  write_page(describe_curve(curve, of), "", page);
  page +=
      "\nThe values of a curve have the unit and the limits of the key; of vectors, each is "
      "an array of 3 numbers.\n`world.wind` also takes a gust:\n";
  GustCase gust;
  write_page(describe_gust(gust), "", page);
}

}  // namespace

std::string json_schema(const Table& table, const std::string& title,
                        const std::string& description) {
  Json schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"},
              {"title", title},
              {"description", description}};
  schema.update(table_schema(table));
  return schema.dump(2) + '\n';
}

std::string reference_sections(const Table& table) {
  std::string page;
  write_page(table, "", page);
  return page;
}

std::string case_json_schema() {
  Case prototype;
  return json_schema(describe(prototype), "Weft case",
                     "A case file of Weft. Units are SI; angles say degrees in the key.");
}

std::string case_reference_markdown() {
  Case prototype;
  std::string page =
      "# Case file reference\n\n"
      "A case is a [TOML](https://toml.io) file. Units are SI; angles are in degrees and say so in "
      "their keys.\nNumbers are finite; a number may be written without a point, a whole number "
      "may not be written with one.\n";
  write_page(describe(prototype), "", page);
  write_forms(page);
  return page;
}

}  // namespace weft::sim
