// The contents of a case file: each struct of case.h as a list of fields, described once. The
// reader, the overrides, the writer of resolved cases, the JSON schema and the reference page all
// walk these lists, so none of them can disagree with another.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "sim/case/case.h"

namespace weft::sim {

// The numbers a field takes; by default any finite one. NaN and infinity are never allowed.
struct Limits {
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
  bool minimum_excluded = false;
  bool maximum_excluded = false;

  bool allow(double value) const;
  // " > 0", " >= 0", " > -1 and < 1", or nothing.
  std::string text() const;
};

struct Table;

// A member that holds one of an enum's values, written by name, in the enum's order.
struct Choice {
  std::vector<std::string> names;
  std::function<std::size_t()> get;
  std::function<void(std::size_t)> set;
};

// A member that is a table of its own; `open` makes an absent one and describes it.
struct TableMember {
  std::function<bool()> present;
  std::function<Table()> open;
};

// A member that is a list of tables: [[key]], or [key.NAME] where `named`. `append` adds an entry
// of defaults and makes the descriptions of earlier entries stale.
struct TableList {
  bool named = false;
  std::function<std::size_t()> size;
  std::function<Table(std::size_t)> at;
  std::function<Table()> append;
};

// An optional whole number is "auto" where it is absent.
using Member =
    std::variant<bool*, int*, std::optional<int>*, double*, std::optional<double>*, std::string*,
                 Vec3*, std::optional<Vec3>*, std::vector<int>*, std::vector<double>*,
                 std::vector<std::string>*, Choice, TableMember, TableList>;

struct Field {
  std::string key;
  Member member;
  std::string meaning;
  std::string unit;          // empty: none
  Limits limits;             // of a number, or of each entry of an array
  bool required = false;     // ... where the field applies
  bool identifier = false;   // a string that is_identifier()
  std::string default_text;  // words, where the default is worked out rather than stored
  std::size_t minimum_entries = 1, maximum_entries = 0;  // of an array; maximum 0: any
  std::vector<std::string> names;                        // the strings an array may hold
  // The field applies only where the Choice `switch_key` of the same table has one of these values.
  std::string switch_key;
  std::vector<std::string> switch_values;
  std::string excluded_by;  // key of the same table that rules this one out

  Field& with_default(std::string text);
  Field& needed();
  Field& named_with_letters();
  Field& entries(std::size_t minimum, std::size_t maximum);
  Field& out_of(std::vector<std::string> allowed);
  Field& only_for(std::string choice_key, std::vector<std::string> values);
  Field& not_with(std::string key_that_excludes);
};

struct Table {
  std::vector<Field> fields;
  std::string* name = nullptr;         // of [key.NAME] entries, which take it from their key
  SourceLocation* location = nullptr;  // where the struct keeps its place in the file

  const Field* find(const std::string& key) const;
  std::vector<std::string> keys() const;
};

// The fields of a whole case, as they stand in `target`, which must outlive the description and
// whose lists must not grow by other means while it is in use.
Table describe(Case& target);

// Tells whether a field with a switch belongs to the value which the switch has in the table.
bool applies(const Field& field, const Table& table);

// Says what a field takes: `a number > 0 (s)`, `an array of 3 numbers (m)`, `one of "a", "b"`.
std::string expected_text(const Field& field);

// A place in a case: keys joined by dots, the index of a list's entry in brackets, the name of a
// named entry as a key: "body[0].shape.size", "material.cotton". Empty: the case itself.
std::string join_path(const std::string& path, const std::string& key);
std::string join_path(const std::string& path, std::size_t index);

// The table at a path as a user would write it: `[body.shape]`, `[[body.pin]]`,
// `[material.cotton]`, or `the case`.
std::string heading(const std::string& path);

}  // namespace weft::sim
