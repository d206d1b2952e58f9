#include "sim/case/case_table_reader.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "sim/case/case_error.h"
#include "sim/case/case_text.h"
#include "sim/case/case_tree.h"

namespace weft::sim {

namespace {

// Returns the values that a field allows, in words. For a table, the text names its header.
std::string wanted(const Field& field, const std::string& path) {
  if (const auto* list = std::get_if<TableList>(&field.member)) {
    return "tables " + heading(list->named ? join_path(path, "NAME") : join_path(path, 0));
  }
  if (std::holds_alternative<TableMember>(field.member) ||
      std::holds_alternative<std::vector<OutputExpression>*>(field.member)) {
    return "a table, " + heading(path);
  }
  return expected_text(field);
}

// Returns the header of a table, or the name of a root.
std::string title_of(const Table& table, const std::string& path) {
  return path.empty() ? table.root_name : heading(path);
}

// Throws CaseError at the first key in the text that is not in `keys`. `title` names the table.
void refuse_unknown_keys(const toml::table& source, const std::vector<std::string>& keys,
                         const std::string& title) {
  const toml::key* first = first_key_beside(keys, source);
  if (first == nullptr) return;
  const std::string name(first->str());
  throw CaseError(location_of(first->source()), "unknown key " + in_quotes(name) + " in " + title,
                  name_hint(name, keys));
}

// Throws CaseError if the value looks like a curve or a gust but the field is a number or a vector
// that cannot vary.
void refuse_curve(const Field& field, const toml::node& node) {
  const bool is_number = std::holds_alternative<double*>(field.member) ||
                         std::holds_alternative<std::optional<double>*>(field.member) ||
                         std::holds_alternative<Vec3*>(field.member) ||
                         std::holds_alternative<std::optional<Vec3>*>(field.member) ||
                         std::holds_alternative<int*>(field.member);
  const auto* table = node.as_table();
  if (!is_number || table == nullptr) return;
  if (!table->contains("times") && !table->contains("values") && !table->contains("mean")) return;
  throw CaseError(
      location_of(node.source()), in_quotes(field.key) + " cannot vary in time",
      "expected " + expected_text(field) + "; these can vary: " + quoted_list(keys_that_vary()));
}

// Visitor that reads a TOML value into the member of a field.
class ValueReader {
 public:
  ValueReader(const Field& field, const toml::node& node, std::string path, Locations& locations)
      : field_(field), node_(node), path_(std::move(path)), locations_(locations) {}

  void operator()(bool* target) const {
    const auto* value = node_.as_boolean();
    if (value == nullptr) fail_kind();
    *target = value->get();
  }
  void operator()(int* target) const { *target = whole_number(node_, in_quotes(field_.key)); }
  void operator()(std::optional<int>* target) const {
    const auto* word = node_.as_string();
    target->reset();
    if (word == nullptr || word->get() != "auto")
      *target = whole_number(node_, in_quotes(field_.key));
  }
  void operator()(double* target) const { *target = number(node_, in_quotes(field_.key)); }
  void operator()(std::optional<double>* target) const {
    *target = number(node_, in_quotes(field_.key));
  }
  void operator()(std::string* target) const {
    *target = string(node_, in_quotes(field_.key));
    if (!field_.names.empty()) name_index(node_, in_quotes(field_.key), field_.names);
    if (field_.identifier && !is_identifier(*target)) fail_value(node_, in_quotes(*target));
  }
  void operator()(Vec3* target) const {
    const toml::array& source = array(3, 3);
    for (std::size_t i = 0; i < 3; ++i) (*target)[i] = number(source[i], entry(i));
  }
  void operator()(std::optional<Vec3>* target) const { (*this)(&target->emplace()); }
  void operator()(std::vector<int>* target) const {
    const toml::array& source = array(field_.minimum_entries, field_.maximum_entries);
    for (std::size_t i = 0; i < source.size(); ++i) {
      target->push_back(whole_number(source[i], entry(i)));
    }
  }
  void operator()(std::vector<double>* target) const {
    const toml::array& source = array(field_.minimum_entries, field_.maximum_entries);
    for (std::size_t i = 0; i < source.size(); ++i) {
      target->push_back(number(source[i], entry(i)));
    }
  }
  void operator()(std::vector<std::string>* target) const {
    const toml::array& source = array(field_.minimum_entries, field_.maximum_entries);
    for (std::size_t i = 0; i < source.size(); ++i) {
      target->push_back(field_.names.empty()
                            ? identifier(source[i], entry(i))
                            : field_.names[name_index(source[i], entry(i), field_.names)]);
    }
  }
  void operator()(std::vector<Vec3>* target) const {
    const toml::array& source = array(field_.minimum_entries, field_.maximum_entries);
    for (std::size_t i = 0; i < source.size(); ++i) {
      const auto* entries = source[i].as_array();
      if (entries == nullptr) fail_kind(source[i], entry(i));
      if (entries->size() != 3) {
        fail(source[i], entry(i) + " is an array of " + std::to_string(entries->size()));
      }
      Vec3& vector = target->emplace_back();
      for (std::size_t k = 0; k < 3; ++k) {
        vector[k] = number((*entries)[k], in_quotes(join_path(join_path(field_.key, i), k)));
      }
    }
  }
  void operator()(std::vector<TomlValue>* target) const {
    const toml::array& source = array(field_.minimum_entries, field_.maximum_entries);
    for (const toml::node& each : source) target->push_back(toml_value(each));
  }
  void operator()(std::vector<KeyedValue>* target) const {
    const auto* source = node_.as_table();
    if (source == nullptr) fail_kind();
    for (auto&& [key, node] : *source) {
      refuse_unquoted_key(key, node, "VALUE");
      target->push_back({std::string(key.str()), location_of(key.source()), toml_value(node)});
    }
    const auto place = [](const KeyedValue& each) {
      return std::pair(each.key_place.line, each.key_place.column);
    };
    std::ranges::sort(*target, {}, place);
  }
  template <class Value>
  void operator()(Varying<Value>* target) const {
    if (const auto* source = node_.as_table()) {
      read_varying(*source, *target);
    } else {
      Value constant;
      (*this)(&constant);
      target->form = constant;
    }
  }
  void operator()(const Choice& target) const {
    target.set(name_index(node_, in_quotes(field_.key), target.names));
  }
  void operator()(const TableMember& target) const {
    const auto* source = node_.as_table();
    if (source == nullptr) fail_kind();
    read_table(*source, target.open(), path_, locations_);
  }
  void operator()(const TableList& target) const {
    if (target.named) {
      named_tables(target);
    } else {
      array_of_tables(target);
    }
  }
  void operator()(std::vector<OutputExpression>* target) const {
    const auto* source = node_.as_table();
    if (source == nullptr) fail_kind();
    for (auto&& [key, node] : *source) {
      const std::string name(key.str());
      require_identifier(name, location_of(key.source()));
      const auto* text = node.as_string();
      if (text == nullptr) {
        throw CaseError(location_of(node.source()),
                        in_quotes(join_path(field_.key, name)) + " is " + kind_of(node),
                        "expected an expression in quotes, such as \"max(largest_stretch)\"");
      }
      target->push_back({name, {text->get(), location_of(node.source())}});
    }
    // toml++ sorts keys by name. Overrides, which have no line, come last.
    std::ranges::stable_sort(*target, {}, [](const OutputExpression& output) {
      const SourceLocation& at = output.text.location;
      return std::pair(at.line == 0 ? std::numeric_limits<int>::max() : at.line, at.column);
    });
  }

 private:
  [[noreturn]] void fail(const toml::node& at, const std::string& message) const {
    throw CaseError(location_of(at.source()), message, "expected " + wanted(field_, path_));
  }
  [[noreturn]] void fail_kind() const { fail_kind(node_, in_quotes(field_.key)); }
  [[noreturn]] void fail_kind(const toml::node& at, const std::string& what) const {
    fail(at, what + " is " + kind_of(at));
  }
  [[noreturn]] void fail_value(const toml::node& at, const std::string& value) const {
    fail(at, in_quotes(field_.key) + " is " + value);
  }

  static TomlValue toml_value(const toml::node& node) {
    return {toml_text(node), node.is_string(), location_of(node.source())};
  }

  // Throws CaseError if the table `node` comes from a case key whose dots are not in quotes, which
  // TOML takes for tables in each other. `value` stands for a value in the hint.
  static void refuse_unquoted_key(const toml::key& key, const toml::node& node,
                                  const std::string& value) {
    const toml::table* table = node.as_table();
    if (table == nullptr || table->is_inline() || table->empty()) return;
    const std::string whole =
        std::string(key.str()) + '.' + std::string(table->begin()->first.str());
    throw CaseError(location_of(key.source()), in_quotes(std::string(key.str())) + " is a table",
                    "expected a case key in quotes: " + in_quotes(whole) + " = " + value);
  }

  // Reads a table that replaces a constant: a curve or a gust, depending on its keys.
  template <class Value>
  void read_varying(const toml::table& source, Varying<Value>& target) const {
    CurveCase<Value> curve;
    GustCase gust;
    const Table of_curve = describe_curve(curve, field_), of_gust = describe_gust(gust);
    std::vector<std::string> allowed = of_curve.keys();
    const toml::key* of_both = nullptr;
    if (field_.takes_gust) {
      const std::vector<std::string> more = of_gust.keys();
      of_both = first_key_beside(more, source);
      if (first_key_beside(allowed, source) == nullptr) of_both = nullptr;
      allowed.insert(allowed.end(), more.begin(), more.end());
    }
    refuse_unknown_keys(source, allowed, heading(path_));
    if (of_both != nullptr) {
      throw CaseError(location_of(of_both->source()),
                      in_quotes(std::string(of_both->str())) + " does not belong to a gust",
                      "expected either times and values, or mean, intensity and time_scale");
    }
    const bool is_gust = first_key_beside(of_curve.keys(), source) != nullptr;
    read_table(source, is_gust ? of_gust : of_curve, path_, locations_);
    if (is_gust) {
      check_gust(gust);
      target.form = gust;
    } else {
      check_curve(curve.times, curve.values.size());
      target.form = std::move(curve);
    }
  }

  [[noreturn]] void fail_at(const std::string& path, const std::string& message,
                            const std::string& hint) const {
    throw CaseError(locations_.value(join_path(path_, path)), message, hint);
  }

  void check_curve(const std::vector<double>& times, std::size_t values) const {
    if (values != times.size()) {
      fail_at("values",
              in_quotes("values") + " has " +
                  counted(static_cast<std::int64_t>(values), "entry", "entries") + " beside " +
                  std::to_string(times.size()) + " in " + in_quotes("times"),
              "expected a value for each time");
    }
    for (std::size_t i = 1; i < times.size(); ++i) {
      if (times[i] > times[i - 1]) continue;
      const std::string place = join_path("times", i);
      fail_at(place, in_quotes(place) + " is " + number_text(times[i]),
              "expected later than the time before, " + number_text(times[i - 1]) + " s");
    }
  }

  void check_gust(const GustCase& gust) const {
    if (!gust.mean.isZero(0) || gust.intensity == 0) return;
    fail_at("mean", "the mean of a gust is zero",
            "expected a mean wind, of which intensity is a fraction");
  }

  std::string entry(std::size_t index) const { return in_quotes(join_path(field_.key, index)); }

  int whole_number(const toml::node& at, const std::string& what) const {
    const auto* value = at.as_integer();
    if (value == nullptr) fail_kind(at, what);
    const std::int64_t whole = value->get();
    const std::string message = what + " is " + std::to_string(whole);
    if (!field_.limits.allow(static_cast<double>(whole))) fail(at, message);
    constexpr int least = std::numeric_limits<int>::min(), most = std::numeric_limits<int>::max();
    if (whole < least || whole > most) {
      throw CaseError(
          location_of(at.source()), message,
          "expected a whole number from " + std::to_string(least) + " to " + std::to_string(most));
    }
    return static_cast<int>(whole);
  }

  // Returns the node as a number. The text may write it without a point.
  double number(const toml::node& at, const std::string& what) const {
    if (!at.is_number()) fail_kind(at, what);
    const auto* whole = at.as_integer();
    const double value =
        whole != nullptr ? static_cast<double>(whole->get()) : at.as_floating_point()->get();
    if (!field_.limits.allow(value)) fail(at, what + " is " + number_text(value));
    return value;
  }

  std::string string(const toml::node& at, const std::string& what) const {
    const auto* value = at.as_string();
    if (value == nullptr) fail_kind(at, what);
    // The names of files and datasets end there for the system and for HDF5.
    if (value->get().find('\0') != std::string::npos) fail(at, what + " has a null character");
    return value->get();
  }

  // Returns the node as a string. Throws CaseError unless is_identifier() holds for it.
  std::string identifier(const toml::node& at, const std::string& what) const {
    std::string name = string(at, what);
    if (!is_identifier(name)) {
      throw CaseError(location_of(at.source()), what + " is " + in_quotes(name),
                      "expected a name of letters, digits, _ and -");
    }
    return name;
  }

  std::size_t name_index(const toml::node& at, const std::string& what,
                         const std::vector<std::string>& names) const {
    const std::string name = string(at, what);
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i] == name) return i;
    }
    throw CaseError(location_of(at.source()), what + " is " + in_quotes(name),
                    name_hint(name, names));
  }

  // Returns the value as an array of `least` to `most` entries, after adding the places of the
  // entries to the locations. `most` = 0 means no upper limit.
  const toml::array& array(std::size_t least, std::size_t most) const {
    const auto* source = node_.as_array();
    if (source == nullptr) fail_kind();
    const std::size_t size = source->size();
    if (size < least || (most > 0 && size > most)) {
      fail_value(node_, "an array of " + std::to_string(size));
    }
    for (std::size_t i = 0; i < size; ++i) {
      const SourceLocation location = location_of((*source)[i].source());
      locations_.add(join_path(path_, i), location, location);
    }
    return *source;
  }

  static void require_identifier(const std::string& name, const SourceLocation& where) {
    if (is_identifier(name)) return;
    throw CaseError(where, in_quotes(name) + " is not a name",
                    "expected a name of letters, digits, _ and -");
  }

  void named_tables(const TableList& target) const {
    const auto* source = node_.as_table();
    if (source == nullptr) fail_kind();
    for (auto&& [key, node] : *source) {
      const std::string name(key.str());
      const SourceLocation key_location = location_of(key.source());
      if (target.named_by_case_keys) {
        refuse_tables_inside(key, node);
      } else {
        require_identifier(name, key_location);
      }
      if (!node.is_table() && target.named_by_case_keys) {
        throw CaseError(location_of(node.source()), in_quotes(name) + " is " + kind_of(node),
                        "expected a table, such as { list = [0.1, 0.2] }");
      }
      if (!node.is_table()) fail_kind(node, in_quotes(join_path(field_.key, name)));
      const std::string path = join_path(path_, name);
      locations_.add(path, key_location, location_of(node.source()));
      const Table entry = target.append();
      *entry.name = name;
      read_table(*node.as_table(), entry, path, locations_);
    }
  }

  void array_of_tables(const TableList& target) const {
    const toml::array& source = array(1, 0);
    for (std::size_t i = 0; i < source.size(); ++i) {
      if (!source[i].is_table()) fail_kind(source[i], entry(i));
      read_table(*source[i].as_table(), target.append(), join_path(path_, i), locations_);
    }
  }

  // Throws CaseError if the table of a case key has tables inside, because the dots of the key are
  // not in quotes.
  static void refuse_tables_inside(const toml::key& key, const toml::node& node) {
    const toml::table* table = node.as_table();
    if (table == nullptr) return;
    const auto is_table = [](const auto& entry) { return entry.second.is_table(); };
    if (std::any_of(table->begin(), table->end(), is_table))
      refuse_unquoted_key(key, node, "{ list = [...] }");
  }

  const Field& field_;
  const toml::node& node_;
  std::string path_;
  Locations& locations_;
};

// Throws CaseError at a key that another key of the table excludes, or that does not apply.
void refuse_misplaced_keys(const Table& target, const std::string& path,
                           const Locations& locations) {
  for (const Field& field : target.fields) {
    const std::string place = join_path(path, field.key);
    if (!locations.given(place)) continue;
    if (!applies(field, target)) {
      const Field& by = ruled_out_by(field, target);
      const auto& choice = std::get<Choice>(target.find(by.switch_key)->member);
      throw CaseError(
          locations.key(place),
          in_quotes(field.key) + " does not belong to " + by.switch_key + " = " +
              in_quotes(choice.names[choice.get()]),
          "expected only with " + by.switch_key + " = " + quoted_list(by.switch_values));
    }
    for (const std::string& other : field.excluded_by) {
      if (!locations.given(join_path(path, other))) continue;
      throw CaseError(locations.key(place),
                      in_quotes(field.key) + " does not go with " + in_quotes(other),
                      "expected only one of the two");
    }
  }
}

// Throws CaseError at the table's header if the table lacks a required key.
void require_keys(const toml::table& source, const Table& target, const std::string& path) {
  for (const Field& field : target.fields) {
    if (!field.required || !applies(field, target) || source.contains(field.key)) continue;
    throw CaseError(
        location_of(source.source()), title_of(target, path) + " has no " + in_quotes(field.key),
        "expected " + in_quotes(field.key) + ", " + wanted(field, join_path(path, field.key)));
  }
}

}  // namespace

void read_field(const Field& field, const toml::node& node, const std::string& path,
                Locations& locations) {
  refuse_curve(field, node);
  std::visit(ValueReader(field, node, path, locations), field.member);
}

void read_table(const toml::table& source, const Table& target, const std::string& path,
                Locations& locations) {
  if (target.location != nullptr) *target.location = location_of(source.source());
  refuse_unknown_keys(source, target.keys(), title_of(target, path));
  for (auto&& [key, node] : source) {
    const std::string name(key.str());
    locations.add(join_path(path, name), location_of(key.source()), location_of(node.source()));
  }
  for (const Field& field : target.fields) {
    const toml::node* node = source.get(field.key);
    if (node == nullptr) continue;
    read_field(field, *node, join_path(path, field.key), locations);
  }
  require_keys(source, target, path);
  refuse_misplaced_keys(target, path, locations);
}

}  // namespace weft::sim
