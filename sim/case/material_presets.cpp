#include "sim/case/material_presets.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>

#include "sim/case/case_error.h"
#include "sim/case/case_schema.h"
#include "sim/case/case_text.h"
#include "sim/case/case_tree.h"

namespace weft::sim {

namespace {

using Json = nlohmann::ordered_json;

// A preset as material_presets.inc gives it.
struct PresetText {
  const char *name, *description, *source;
  const char* keys;  // TOML text of MaterialPreset::keys
};

#include "sim/case/material_presets.inc"

// All values from presets have a source file whose name starts with this text.
constexpr std::string_view preset_place = "preset \"";

toml::array* array_at(toml::table& keys, const char* table, const char* key) {
  return keys[table][key].as_array();
}

// Changes published numbers that a case would refuse. Negative coefficients become zero. Couplings
// above the square root of warp times weft become that root.
class Changer {
 public:
  explicit Changer(MaterialPreset& preset) : preset_(preset) {}

  void change() {
    for (const char* key : {"warp", "coupling", "weft", "shear"}) {
      toml::array* numbers = array_at(preset_.keys, table, key);
      for (std::size_t i = 0; numbers != nullptr && i < numbers->size(); ++i)
        replace(key, *numbers, i, std::max(0.0, *(*numbers)[i].value<double>()));
    }
    toml::array* couplings = array_at(preset_.keys, table, "coupling");
    for (std::size_t i = 0; couplings != nullptr && i < couplings->size(); ++i) {
      const double limit = std::sqrt(number("warp", i) * number("weft", i));
      replace("coupling", *couplings, i, std::min(limit, number("coupling", i)));
    }
  }

 private:
  static constexpr const char* table = "measured_membrane";

  double number(const char* key, std::size_t i) {
    return *(*array_at(preset_.keys, table, key))[i].value<double>();
  }
  void replace(const char* key, toml::array& numbers, std::size_t i, double value) {
    const double published = *numbers[i].value<double>();
    if (value == published) return;
    preset_.changes.push_back({join_path(join_path(table, std::string(key)), i), published, value});
    *numbers[i].as_floating_point() = value;
  }

  MaterialPreset& preset_;
};

MaterialPreset made(const PresetText& text) {
  MaterialPreset preset{text.name, text.description, text.source, {}, {}};
  const std::string place = std::string(preset_place) + preset.name + '"';
  preset.keys = toml::parse(std::string_view(text.keys), std::string_view(place));
  Changer(preset).change();
  return preset;
}

bool is_of_preset(const toml::node& node) {
  const auto& path = node.source().path;
  return path && path->starts_with(preset_place);
}

// Moves the entries of `more` that `table` lacks into `table`, because copies would lose their
// source file.
void fill(toml::table& table, toml::table& more) {
  for (auto&& [key, node] : more) {
    toml::node* own = table.get(key.str());
    if (own == nullptr) {
      table.insert_or_assign(key, std::move(node));
    } else if (own->is_table() && node.is_table()) {
      fill(*own->as_table(), *node.as_table());
    }
  }
}

// True if the case itself gives a key that excludes this field, or that this field excludes.
bool is_excluded(const Field& field, const Table& schema, const toml::table& table) {
  return std::ranges::any_of(schema.fields, [&](const Field& other) {
    const toml::node* given = table.get(other.key);
    if (given == nullptr || is_of_preset(*given)) return false;
    return std::ranges::count(field.excluded_by, other.key) > 0 ||
           std::ranges::count(other.excluded_by, field.key) > 0;
  });
}

// True if the field applies with the switches that the table gives, or else with their defaults.
bool is_switched_on(const Field& field, const Table& schema, const toml::table& table) {
  if (field.switch_key.empty()) return true;
  const Field& by = *schema.find(field.switch_key);
  const auto& choice = std::get<Choice>(by.member);
  const std::string chosen = table[by.key].value_or(choice.names[choice.get()]);
  return is_switched_on(by, schema, table) && std::ranges::count(field.switch_values, chosen) > 0;
}

// Throws CaseError if the case itself gives a model to which no number of the preset applies: the
// material would silently be another one than the preset names.
void refuse_other_model(const Field& field, const toml::table& table) {
  const toml::node* model = table.get("model");
  if (field.switch_key != "model" || model == nullptr || is_of_preset(*model)) return;
  throw CaseError(location_of(model->source()),
                  "the preset has " + in_quotes(field.key) + ", which model = " +
                      in_quotes(model->value_or(std::string())) + " does not know",
                  "expected the model of the preset, or no preset");
}

void remove_overridden(toml::table& table, const Table& schema) {
  std::vector<std::string> overridden;
  for (auto&& [key, node] : table) {
    const Field* field = schema.find(std::string(key.str()));
    if (field == nullptr) continue;
    const bool is_off = is_of_preset(node) && !is_switched_on(*field, schema, table);
    if (is_off) refuse_other_model(*field, table);
    if (is_off || (is_of_preset(node) && is_excluded(*field, schema, table))) {
      overridden.push_back(field->key);
    } else if (const auto* member = std::get_if<TableMember>(&field->member);
               member != nullptr && node.is_table()) {
      remove_overridden(*node.as_table(), member->open());
    }
  }
  for (const std::string& key : overridden) table.erase(key);
}

// For every material that names a preset, calls visit(material).
template <class Visit>
void for_each_preset(toml::table& root, const Visit& visit) {
  toml::table* materials = root["material"].as_table();
  if (materials == nullptr) return;
  for (auto&& [name, node] : *materials) {
    toml::table* material = node.as_table();
    if (material != nullptr && material->contains("preset")) visit(*material);
  }
}

Json json_of(const toml::node& node) {
  if (const auto* table = node.as_table()) {
    Json result = Json::object();
    for (auto&& [key, each] : *table) result[std::string(key.str())] = json_of(each);
    return result;
  }
  if (const auto* array = node.as_array()) {
    Json result = Json::array();
    for (const toml::node& each : *array) result.push_back(json_of(each));
    return result;
  }
  if (const auto text = node.value<std::string>()) return *text;
  if (node.is_integer()) return *node.value<std::int64_t>();
  if (node.is_boolean()) return *node.value<bool>();
  return *node.value<double>();
}

// Writes a line "KEY = VALUE" for every value of a table and of the tables inside it. KEY is the
// path of the value.
void write_values(const toml::table& table, const std::string& path, std::ostream& out) {
  for (auto&& [key, node] : table) {
    const std::string name = join_path(path, std::string(key.str()));
    if (node.is_table()) {
      write_values(*node.as_table(), name, out);
    } else {
      out << "  " << name << " = " << json_of(node).dump() << '\n';
    }
  }
}

}  // namespace

const std::vector<MaterialPreset>& material_presets() {
  static const std::vector<MaterialPreset> presets = [] {
    std::vector<MaterialPreset> all;
    for (const PresetText& text : preset_texts) all.push_back(made(text));
    return all;
  }();
  return presets;
}

std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  for (const PresetText& text : preset_texts) names.emplace_back(text.name);
  return names;
}

bool changes_presets(const std::string& key) {
  return key == "material" || (key.starts_with("material.") &&
                               (std::ranges::count(key, '.') == 1 || key.ends_with(".preset")));
}

void add_presets(toml::table& root) {
  for_each_preset(root, [](toml::table& material) {
    const toml::node& node = *material.get("preset");
    const auto name = node.value<std::string>();
    if (!name) return;  // the reader refuses it
    const auto text =
        std::ranges::find(preset_texts, *name, [](const PresetText& each) { return each.name; });
    if (text == std::end(preset_texts))
      throw CaseError(location_of(node.source()), "unknown preset " + in_quotes(*name),
                      name_hint(*name, preset_names()));
    MaterialPreset preset = made(*text);
    fill(material, preset.keys);
  });
}

void remove_overridden_presets(toml::table& root) {
  MaterialCase prototype;
  const Table schema = describe(prototype);
  for_each_preset(root, [&](toml::table& material) { remove_overridden(material, schema); });
}

std::string material_presets_text() {
  std::ostringstream out;
  for (const MaterialPreset& preset : material_presets()) {
    out << preset.name << ": " << preset.description << '\n';
    write_values(preset.keys, "", out);
    for (const PresetChange& change : preset.changes) {
      out << "  published: " << change.key << " = " << number_text(change.published)
          << ", taken as " << number_text(change.value) << '\n';
    }
    out << "  source: " << preset.source << "\n\n";
  }
  out << "use: [material.NAME] preset = \"" << material_presets().front().name
      << "\"; keys beside it go before those of the preset\n";
  return out.str();
}

std::string material_presets_json() {
  Json all = Json::array();
  for (const MaterialPreset& preset : material_presets()) {
    Json changes = Json::array();
    for (const PresetChange& change : preset.changes)
      changes.push_back(
          {{"key", change.key}, {"published", change.published}, {"value", change.value}});
    all.push_back({{"name", preset.name},
                   {"description", preset.description},
                   {"source", preset.source},
                   {"keys", json_of(preset.keys)},
                   {"changes", std::move(changes)}});
  }
  return Json{{"presets", std::move(all)}}.dump(2) + '\n';
}

}  // namespace weft::sim
