// The schema of a case file. It describes each table once, as a list of fields. The reader, the
// overrides, the writer of resolved cases, the JSON schema and the reference page use these lists
// and therefore agree.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "sim/case/case.h"

namespace weft::sim {

// The range of numbers that a field allows. By default it allows every finite number. It never
// allows NaN or infinity.
struct Limits {
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
  bool minimum_excluded = false;
  bool maximum_excluded = false;

  bool allow(double value) const;
  // Returns the limits as text, such as " > 0" or " > -1 and < 1"; empty without limits.
  std::string text() const;
};

struct Table;

// A value whose type is not known when it is read: it belongs to a case key that the file names.
struct TomlValue {
  std::string text;  // the value as TOML, on one line
  bool is_string = false;
  SourceLocation where;
};
struct KeyedValue {
  std::string key;  // path of a case key, with dots
  SourceLocation key_place;
  TomlValue value;
};

// A member that holds a value of an enum, which case files write by name. get() and set() use the
// index of the name in `names`.
struct Choice {
  std::vector<std::string> names;
  std::function<std::size_t()> get;
  std::function<void(std::size_t)> set;
};

// A member that is a table. open() creates the table if it is absent, and returns its description.
struct TableMember {
  std::function<bool()> present;
  std::function<Table()> open;
};

// A member that is a list of tables: [[key]], or [key.NAME] if `named`. append() adds an entry with
// default values and returns its description. It invalidates the descriptions of earlier entries.
struct TableList {
  bool named = false;
  bool named_by_case_keys = false;  // if true, a NAME is a case key in quotes, not an identifier
  std::function<std::size_t()> size;
  std::function<Table(std::size_t)> at;
  std::function<Table()> append;
};

// The member that a field describes. An absent std::optional<int> is written "auto". KeyedValues
// are a table of case keys in quotes, in the order of the text.
using Member =
    std::variant<bool*, int*, std::optional<int>*, double*, std::optional<double>*, std::string*,
                 Vec3*, std::optional<Vec3>*, std::vector<int>*, std::vector<double>*,
                 std::vector<Vec3>*, std::vector<std::string>*, std::vector<TomlValue>*,
                 std::vector<KeyedValue>*, Varying<double>*, Varying<Vec3>*, Choice, TableMember,
                 TableList, std::vector<OutputExpression>*>;

struct Field {
  std::string key;
  Member member;
  std::string meaning;
  std::string unit;          // empty: the value has no unit or is not a number
  Limits limits;             // limits of a number, or of each number in an array
  bool required = false;     // if true, the table needs the key wherever the field applies
  bool identifier = false;   // if true, is_identifier() must hold for the string
  std::string default_text;  // default in words, if the member does not store it
  std::size_t minimum_entries = 1, maximum_entries = 0;  // size of an array; maximum 0: no limit
  // Allowed values of a string, or of each string in an array. Empty: no restriction to a list.
  std::vector<std::string> names;
  // A field with a switch_key applies only if the Choice of this key, in the same table, applies
  // and has one of the switch_values. A field without a switch_key always applies.
  std::string switch_key;
  std::vector<std::string> switch_values;
  std::vector<std::string> excluded_by;  // keys of the same table that must be absent
  bool takes_gust = false;               // a vector that varies may also be a gust

  Field& with_default(std::string text);
  Field& needed();
  Field& named_with_letters();
  Field& entries(std::size_t minimum, std::size_t maximum);
  Field& out_of(std::vector<std::string> allowed);
  Field& only_for(std::string choice_key, std::vector<std::string> values);
  Field& not_with(std::string key_that_excludes);
  Field& may_be_gust();
};

struct Table {
  std::vector<Field> fields;
  std::string root_name = "the case";  // name in messages if the table is the root of a file
  std::string* name = nullptr;  // member that stores NAME of [key.NAME]; null in other tables
  SourceLocation* location = nullptr;  // member that stores the table's place, or null

  const Field* find(const std::string& key) const;
  std::vector<std::string> keys() const;
};

// Describes a whole case. The fields point into `target`, which must outlive the description. While
// the description is in use, lists of the case may grow only by `append`.
Table describe(Case& target);

// Describe the tables of a case. Each `target` must outlive its description.
Table describe(TimeCase& target);
Table describe(StaticCase& target);
Table describe(WorldCase& target);
Table describe(ContactPairCase& target);
Table describe(ContactCase& target);
Table describe(OutputPartCase& target);
Table describe(OutputCase& target);
Table describe(ComputeCase& target);
Table describe(RestartCase& target);
Table describe(IncludeCase& target);
Table describe(StretchCurveCase& target);
Table describe(OrthotropicMembraneCase& target);
Table describe(MeasuredMembraneCase& target);
Table describe(OrthotropicBendingCase& target);
Table describe(MaterialCase& target);
Table describe(ShapeCase& target);
Table describe(StartCase& target);
Table describe(KeyframeCase& target);
Table describe(MotionCase& target);
Table describe(PinCase& target);
Table describe(BodyCase& target);
Table describe(ObstacleCase& target);
Table describe(PositionsCase& target);
Table describe(ParticlesCase& target);
Table describe(LoadCase& target);
Table describe(TieCase& target);
Table describe(SeamCase& target);

// Describe the tables that may replace the constant of a Varying field: a curve or a gust. The
// values of a curve have the unit and the limits of the field `of`.
template <class Value>
Table describe_curve(CurveCase<Value>& target, const Field& of);
extern template Table describe_curve(CurveCase<double>&, const Field&);
extern template Table describe_curve(CurveCase<Vec3>&, const Field&);
Table describe_gust(GustCase& target);

inline bool is_varying(const Field& field) {
  return std::holds_alternative<Varying<double>*>(field.member) ||
         std::holds_alternative<Varying<Vec3>*>(field.member);
}
// True if the present value of the field varies in time.
bool varies(const Field& field);
// Returns the keys that may vary in time: "world.wind", "material.NAME.mass_damping", ...
std::vector<std::string> keys_that_vary();

// True if the field, which belongs to `table`, applies there (see Field::switch_key).
bool applies(const Field& field, const Table& table);
// Returns the reason why a field does not apply: a field whose switch applies but does not have one
// of the switch_values. It is the field itself, its switch, the switch of its switch, or a
// switch further up. Precondition: the field does not apply.
const Field& ruled_out_by(const Field& field, const Table& table);

// Returns the JSON schema (draft 2020-12) of a file with this table at its root.
std::string json_schema(const Table& table, const std::string& title,
                        const std::string& description);
// Returns the sections of a reference page, in Markdown: one table of keys per table of the file.
std::string reference_sections(const Table& table);

// Returns the values that a field allows, in words: `a number > 0 (s)`, `an array of 3 numbers
// (m)`, `one of "a", "b"`.
std::string expected_text(const Field& field);

// Return a path extended by a key or an index, such as "body[0].shape.size". Dots separate keys.
// Brackets hold the index of an entry of a list. The name of a named entry is a key, as in
// "material.cotton". The empty path is the case itself.
std::string join_path(const std::string& path, const std::string& key);
std::string join_path(const std::string& path, std::size_t index);

// Returns the header of the table at a path, as case files write it: `[body.shape]`,
// `[[body.pin]]`, `[material.cotton]`. Returns `the case` for the empty path.
std::string heading(const std::string& path);

}  // namespace weft::sim
