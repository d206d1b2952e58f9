#include "sim/case/case_override.h"

#include <algorithm>
#include <charconv>
#include <string_view>

#include "sim/case/case_error.h"
#include "sim/case/case_schema.h"
#include "sim/case/case_text.h"
#include "sim/case/case_tree.h"
#include "sim/case/case_writer.h"

namespace weft::sim {

namespace {

class Override {
 public:
  Override(toml::table& root, const CaseOverride& source) : table_(&root), source_(source) {
    const std::string& path = source.key;
    for (std::size_t begin = 0; begin <= path.size();) {
      const std::size_t end = std::min(path.find('.', begin), path.size());
      keys_.push_back(path.substr(begin, end - begin));
      begin = end + 1;
    }
    if (find_deep_key(source.value) != std::string::npos) {
      fail("a key of too many parts in the value", "expected at most a few");
    }
    schema_ = describe(prototype_);
  }

  // Returns true if the key takes whole numbers only.
  bool apply() {
    while (!done_) step();
    return is_whole_;
  }

 private:
  [[noreturn]] void fail(const std::string& message, const std::string& hint) const {
    throw CaseError(source_.key_place, message, hint);
  }
  const std::string& key() const { return keys_[position_]; }
  bool at_last_key() const { return position_ + 1 == keys_.size(); }

  // Parses a TOML document. The place of the override's value becomes that of its values.
  toml::table parsed(const std::string& text) const {
    return toml::parse(std::string_view(text), path_for_place(source_.value_place));
  }
  // Parses the override's value into a document with the key "value". Text that is not a TOML value
  // becomes a string. With `wants_string`, a TOML value of another type becomes a string, too,
  // unless the override is strict.
  toml::table value(bool wants_string) const {
    try {
      toml::table document = parsed("value = " + source_.value);
      const bool usable = document.size() == 1 &&
                          (!wants_string || source_.strict || document["value"].is_string());
      if (usable) return document;
    } catch (const toml::parse_error&) {
      // The text becomes a string below. The reader checks later whether the key allows a string.
    }
    try {
      return parsed("value = " + toml_string(source_.value));
    } catch (const toml::parse_error&) {
      fail("the value of " + in_quotes(key()) + " is not UTF-8", "expected text in UTF-8");
    }
  }

  void set(toml::table& table, const std::string& name, toml::table document) const {
    toml::source_region region = document.source();
    region.path = std::make_shared<const std::string>(path_for_place(source_.key_place));
    table.insert_or_assign(toml::key(name, std::move(region)), std::move(*document.get("value")));
  }

  // Returns the table under the current key. Creates an absent table. Throws CaseError if the key
  // has a value of another type.
  toml::table& child_table() {
    if (table_->get(key()) == nullptr) set(*table_, key(), parsed("value = {}"));
    toml::table* child = table_->get(key())->as_table();
    if (child == nullptr) {
      fail(in_quotes(key()) + " is " + kind_of(*table_->get(key())) + " in the case",
           "expected a table");
    }
    return *child;
  }
  // Returns the array under the current key. Throws CaseError if the key is absent or has a value
  // of another type.
  toml::array& child_array() const {
    toml::node* child = table_->get(key());
    if (child == nullptr) {
      fail("the case has no " + in_quotes(join_path(path_, key())),
           "expected it in the case file, or all of it in one override");
    }
    if (!child->is_array()) {
      fail(in_quotes(key()) + " is " + kind_of(*child) + " in the case", "expected an array");
    }
    return *child->as_array();
  }

  // Sets the value if the current key is the last one. Otherwise descends into the table or list
  // under this key, or sets an entry of the array under it.
  void step() {
    const Field* field = schema_.find(key());
    if (field == nullptr) {
      fail("unknown key " + in_quotes(key()) + " in " + heading(path_),
           name_hint(key(), schema_.keys()));
    }
    if (at_last_key()) {
      const bool wants_string = std::holds_alternative<std::string*>(field->member) ||
                                std::holds_alternative<Choice>(field->member);
      is_whole_ = std::holds_alternative<int*>(field->member) ||
                  std::holds_alternative<std::optional<int>*>(field->member);
      set(*table_, key(), value(wants_string));
      done_ = true;
    } else if (const auto* member = std::get_if<TableMember>(&field->member)) {
      Table inner = member->open();
      table_ = &child_table();
      path_ = join_path(path_, key());
      schema_ = std::move(inner);
      ++position_;
    } else if (const auto* list = std::get_if<TableList>(&field->member)) {
      Table inner = list->append();
      if (list->named) {
        enter_named(child_table());
      } else {
        enter_entry(child_array());
      }
      schema_ = std::move(inner);
    } else if (std::holds_alternative<std::vector<OutputExpression>*>(field->member)) {
      set_output();
    } else if (is_varying(*field) && !is_index(keys_[position_ + 1])) {
      Table inner = varying_table(*field);
      table_ = &child_table();
      path_ = join_path(path_, key());
      schema_ = std::move(inner);
      ++position_;
    } else {
      set_entry(*field);
    }
  }

  // Sets an expression in a table of expressions. The next key, the last one, is its name.
  void set_output() {
    toml::table& outputs = child_table();
    ++position_;
    if (!at_last_key())
      fail(in_quotes(key()) + " has no keys of its own", "expected an expression");
    set(outputs, key(), value(true));
    done_ = true;
  }

  static bool is_index(const std::string& key) {
    return !key.empty() && std::ranges::all_of(key, [](char c) { return c >= '0' && c <= '9'; });
  }

  // Returns the schema of the table that may replace the constant of a varying field. It has the
  // keys of a curve and, if the field takes one, of a gust.
  Table varying_table(const Field& field) {
    if (std::holds_alternative<Varying<double>*>(field.member))
      return describe_curve(number_curve_, field);
    Table table = describe_curve(vector_curve_, field);
    const Table of_gust = describe_gust(gust_);
    if (field.takes_gust)
      table.fields.insert(table.fields.end(), of_gust.fields.begin(), of_gust.fields.end());
    return table;
  }

  // Descends from the tables [list.NAME] to one entry, or sets that entry as a whole.
  void enter_named(toml::table& list) {
    const std::string list_key = key();
    ++position_;
    std::vector<std::string> names;
    for (auto&& [name, node] : list) names.emplace_back(name.str());
    // A case without materials gets the material "default", which an override can change.
    if (names.empty()) names.emplace_back("default");
    if (std::find(names.begin(), names.end(), key()) == names.end()) {
      fail("the case has no " + in_quotes(list_key + '.' + key()), name_hint(key(), names));
    }
    if (at_last_key()) {
      set(list, key(), value(false));
      done_ = true;
      return;
    }
    table_ = &list;
    table_ = &child_table();
    path_ = join_path(join_path(path_, list_key), key());
    ++position_;
  }

  // Descends from a list of tables to one entry. The next key is the name of the entry or, if no
  // entry has this name, its index.
  void enter_entry(toml::array& list) {
    const std::string list_key = key();
    ++position_;
    std::vector<std::string> names;
    for (toml::node& node : list) {
      const toml::table* entry = node.as_table();
      const auto name = entry == nullptr ? std::nullopt : (*entry)["name"].value<std::string>();
      names.push_back(name.value_or(""));
    }
    const auto named = std::find(names.begin(), names.end(), key());
    const std::size_t index =
        named != names.end() ? static_cast<std::size_t>(named - names.begin()) : index_key(list);
    if (index >= list.size()) {
      std::erase(names, "");
      fail("the case has no " + in_quotes(list_key + '.' + key()),
           names.empty() ? index_hint(list) : name_hint(key(), names));
    }
    if (at_last_key()) fail("an entry cannot be replaced as a whole", "expected a key of it");
    table_ = list[index].as_table();
    if (table_ == nullptr)
      fail(in_quotes(list_key + '.' + key()) + " is not a table", "expected a table");
    path_ = join_path(join_path(path_, list_key), index);
    ++position_;
  }

  // Sets an entry of the array under the current key. The next key is the index of the entry.
  void set_entry(const Field& field) {
    const bool is_array = std::holds_alternative<Vec3*>(field.member) ||
                          std::holds_alternative<Varying<Vec3>*>(field.member) ||
                          std::holds_alternative<std::vector<Vec3>*>(field.member) ||
                          std::holds_alternative<std::optional<Vec3>*>(field.member) ||
                          std::holds_alternative<std::vector<int>*>(field.member) ||
                          std::holds_alternative<std::vector<double>*>(field.member) ||
                          std::holds_alternative<std::vector<std::string>*>(field.member);
    if (!is_array) {
      fail(in_quotes(key()) + " has no keys of its own", "expected " + expected_text(field));
    }
    // An absent array starts as its default, if it has a default, so the other entries keep their
    // default values.
    const std::string by_default = value_text(field);
    if (table_->get(key()) == nullptr && !by_default.empty()) {
      set(*table_, key(), parsed("value = " + by_default));
    }
    toml::array* list = &child_array();
    ++position_;
    std::size_t index = entry_index(field, *list);
    // Entries of a list of vectors are arrays, and the next key may select a component.
    if (!at_last_key() && std::holds_alternative<std::vector<Vec3>*>(field.member) &&
        (*list)[index].is_array()) {
      list = (*list)[index].as_array();
      ++position_;
      index = entry_index(field, *list);
    }
    if (!at_last_key()) no_entry(field, *list);
    const bool wants_string = std::holds_alternative<std::vector<std::string>*>(field.member);
    is_whole_ = std::holds_alternative<std::vector<int>*>(field.member);
    toml::table document = value(wants_string);
    list->replace(list->cbegin() + static_cast<std::ptrdiff_t>(index),
                  std::move(*document.get("value")));
    done_ = true;
  }

  [[noreturn]] void no_entry(const Field& field, const toml::array& list) const {
    fail(in_quotes(field.key) + " has no entry " + in_quotes(key()), index_hint(list));
  }
  std::size_t entry_index(const Field& field, const toml::array& list) const {
    const std::size_t index = index_key(list);
    if (index >= list.size()) no_entry(field, list);
    return index;
  }

  static std::string index_hint(const toml::array& list) {
    if (list.empty()) return "";
    return "expected an index from 0 to " + std::to_string(list.size() - 1);
  }
  // Returns the current key as an index, or list.size() if it is not a valid index.
  std::size_t index_key(const toml::array& list) const {
    std::size_t index = 0;
    const char* end = key().data() + key().size();
    const auto [stop, error] = std::from_chars(key().data(), end, index);
    return error == std::errc() && stop == end ? std::min(index, list.size()) : list.size();
  }

  toml::table* table_;  // current table in the tree
  Table schema_;        // schema of *table_
  // Objects to whose members the fields of schema_ point.
  Case prototype_;
  CurveCase<double> number_curve_;
  CurveCase<Vec3> vector_curve_;
  GustCase gust_;
  const CaseOverride& source_;
  std::vector<std::string> keys_;
  std::size_t position_ = 0;
  std::string path_;  // path of the current table, for messages
  bool done_ = false;
  bool is_whole_ = false;
};

}  // namespace

CaseOverride override_of_option(const std::string& text) {
  const SourceLocation place{"--set " + text};
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) throw CaseError(place, "no \"=\"", "expected KEY=VALUE");
  return {text.substr(0, equals), text.substr(equals + 1), false, place, place};
}

bool apply_override(toml::table& root, const CaseOverride& source) {
  return Override(root, source).apply();
}

}  // namespace weft::sim
