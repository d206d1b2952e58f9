#include "sim/probes/recorded_quantity.h"

#include <algorithm>
#include <charconv>
#include <optional>

#include "sim/case/case_text.h"

namespace weft::sim {

namespace {

using QuantityKind = RecordedQuantity::Kind;
using QuantityPart = RecordedQuantity::Part;

// The arguments and the value of a function.
struct Form {
  const char* name;
  QuantityKind kind;
  bool takes_name;  // the name of a field or a record comes first
  bool takes_body;
  bool takes_texel;
  int components;  // 0: those of the field or the record
  const char* usage;
};

constexpr Form forms[] = {
    {"position", QuantityKind::position, false, true, true, 3, "position('BODY', ROW, COLUMN).z"},
    {"displacement", QuantityKind::displacement, false, true, true, 3,
     "displacement('BODY', ROW, COLUMN).z"},
    {"field", QuantityKind::field, true, true, true, 0, "field('FIELD', 'BODY', ROW, COLUMN)"},
    {"largest", QuantityKind::largest, true, true, false, 1, "largest('FIELD', 'BODY')"},
    {"smallest", QuantityKind::smallest, true, true, false, 1, "smallest('FIELD', 'BODY')"},
    {"lower", QuantityKind::lower, false, true, false, 3, "lower('BODY').z"},
    {"upper", QuantityKind::upper, false, true, false, 3, "upper('BODY').z"},
    {"size", QuantityKind::size, false, true, false, 3, "size('BODY').z"},
    {"shadow", QuantityKind::shadow, false, true, false, 3, "shadow('BODY').z"},
    {"area", QuantityKind::area, false, true, false, 1, "area('BODY')"},
    {"record", QuantityKind::record, true, false, false, 0, "record('PATH')"}};

// An argument of a call: a text, or a whole number.
struct Argument {
  std::size_t begin = 0;  // its first byte
  std::string text;
  std::optional<int> number;  // empty for a text
};

class CallReader {
 public:
  CallReader(const LocatedText& expression, std::span<const Token> tokens, std::size_t first,
             std::size_t close, const TrajectoryContents& contents)
      : expression_(expression),
        tokens_(tokens),
        name_(tokens[first]),
        close_(close),
        contents_(contents),
        form_(*std::ranges::find(forms, name_.text, &Form::name)),
        arguments_(read_arguments(first + 2)) {}

  QuantityCall read() {
    require_arguments();
    RecordedQuantity quantity;
    quantity.kind = form_.kind;
    quantity.components = form_.components;
    std::size_t next = 0;
    if (form_.takes_name) quantity.name = arguments_[next++].text;
    if (form_.takes_body) {
      quantity.body = body_of(arguments_[next]);
      require_surface(quantity.body, arguments_[next++]);
    }
    if (form_.takes_texel) quantity.particle = particle_of(quantity.body, next);
    if (form_.takes_name) {
      const int found = form_.takes_body ? components_of_field(quantity.body) : record_components();
      if (quantity.components == 0) quantity.components = found;
    }
    const std::size_t end = read_part(quantity);
    return {quantity, end};
  }

 private:
  [[noreturn]] void fail(std::size_t byte, const std::string& message,
                         const std::string& hint) const {
    fail_in_expression(expression_, byte, message, hint);
  }
  std::string usage() const { return "expected " + std::string(form_.usage); }

  std::vector<Argument> read_arguments(std::size_t first) const {
    std::vector<Argument> arguments;
    for (std::size_t i = first; i < close_; ++i) {
      const bool is_negative = tokens_[i].is_operation("-") && i + 1 < close_;
      const Token& token = tokens_[is_negative ? i + 1 : i];
      Argument& argument = arguments.emplace_back(Argument{tokens_[i].begin, token.text, {}});
      if (is_negative) ++i;
      if (token.kind == Token::Kind::number) {
        argument.number = whole_number(token.text, is_negative);
        if (!argument.number) fail_argument(argument.begin);
      } else if (token.kind != Token::Kind::text || is_negative) {
        fail_argument(argument.begin);
      }
      ++i;
      if (i < close_ && tokens_[i].kind != Token::Kind::comma) fail_argument(tokens_[i].begin);
      if (i < close_ && i + 1 == close_) fail_argument(tokens_[close_].begin);
    }
    return arguments;
  }

  [[noreturn]] void fail_argument(std::size_t byte) const {
    fail(byte, "this is no argument of " + in_quotes(name_.text),
         usage() + ", with texts in quotes and whole numbers");
  }

  static std::optional<int> whole_number(const std::string& text, bool is_negative) {
    int value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return is_negative ? -value : value;
  }

  // Throws CaseError unless the numbers and kinds of arguments are those of the form.
  void require_arguments() const {
    const std::size_t texts = (form_.takes_name ? 1 : 0) + (form_.takes_body ? 1 : 0);
    const std::size_t least = texts + (form_.takes_texel ? 2 : 0);
    const std::size_t most = least + (form_.takes_texel ? 1 : 0);
    if (arguments_.size() < least || arguments_.size() > most) {
      fail(name_.begin,
           in_quotes(name_.text) + " has " +
               counted(std::ssize(arguments_), "argument", "arguments"),
           usage() + (form_.takes_texel ? "; PATCH before ROW for a body of several" : ""));
    }
    for (std::size_t i = 0; i < arguments_.size(); ++i) {
      if (arguments_[i].number.has_value() != (i >= texts)) fail_argument(arguments_[i].begin);
    }
  }

  int body_of(const Argument& argument) const {
    std::vector<std::string> names;
    for (const TrajectoryBody& body : contents_.bodies) names.push_back(body.name);
    const auto found = std::ranges::find(names, argument.text);
    if (found == names.end()) {
      fail(argument.begin, "no body " + in_quotes(argument.text) + " is recorded",
           name_hint(argument.text, names));
    }
    return static_cast<int>(found - names.begin());
  }

  // Refuses the area of a group of particles, which has no triangles.
  void require_surface(int body, const Argument& argument) const {
    const bool is_of_triangles =
        form_.kind == QuantityKind::shadow || form_.kind == QuantityKind::area;
    if (!is_of_triangles || !contents_.bodies[body].is_of_spheres()) return;
    fail(argument.begin,
         in_quotes(argument.text) + " are particles, which have no " + name_.text + "()",
         "expected a body with a surface");
  }

  // Returns the particle of a texel. `next` is the index of the argument with its patch or row.
  int particle_of(int body, std::size_t next) const {
    const TrajectoryBody& of = contents_.bodies[body];
    const int patches = static_cast<int>(of.atlas.patches().size());
    int patch = 0;
    if (arguments_.size() - next == 3) {
      const Argument& argument = arguments_[next++];
      patch = *argument.number;
      if (patch < 0 || patch >= patches) {
        fail(argument.begin,
             "body " + in_quotes(of.name) + " has no patch " + std::to_string(patch),
             "expected 0 to " + std::to_string(patches - 1));
      }
    } else if (patches > 1) {
      fail(name_.begin,
           "body " + in_quotes(of.name) + " has " + std::to_string(patches) + " patches",
           "expected the number of a patch before the row");
    }
    const bsi::Patch& size = of.atlas.patches()[patch];
    const int row = index_of(arguments_[next], "row", size.rows, of.part_rows);
    const int col = index_of(arguments_[next + 1], "column", size.cols, of.part_cols);
    return of.atlas.particle(patch, row, col);
  }

  // Returns the index of a row or column in the recorded image, of which `count` are recorded.
  // `recorded` lists them; empty for all of an image.
  int index_of(const Argument& argument, const std::string& axis, int count,
               const std::vector<int>& recorded) const {
    const int number = *argument.number;
    if (number < 0 && number >= -count) return count + number;
    if (recorded.empty()) {
      if (number >= 0 && number < count) return number;
      fail(argument.begin, axis + ' ' + std::to_string(number) + " lies outside of the image",
           "expected 0 to " + std::to_string(count - 1) + ", or -1 to -" + std::to_string(count) +
               " from the end");
    }
    const auto found = std::ranges::find(recorded, number);
    if (found != recorded.end()) return static_cast<int>(found - recorded.begin());
    std::string list;
    for (const int each : recorded) list += (list.empty() ? "" : ", ") + std::to_string(each);
    fail(argument.begin, axis + ' ' + std::to_string(number) + " is not recorded",
         "expected one of " + list);
  }

  int components_of_field(int body) const {
    const TrajectoryBody& of = contents_.bodies[body];
    const Argument& argument = arguments_[0];
    const auto found = std::ranges::find(of.fields, argument.text, &TrajectoryField::name);
    if (found != of.fields.end()) return found->components;
    std::vector<std::string> names;
    for (const TrajectoryField& field : of.fields) names.push_back(field.name);
    fail(argument.begin, "body " + in_quotes(of.name) + " has no field " + in_quotes(argument.text),
         names.empty() ? "expected a field that output.channels records; it has none"
                       : name_hint(argument.text, names));
  }

  int record_components() const {
    const Argument& argument = arguments_[0];
    const auto& records = contents_.records;
    const auto found = std::ranges::find(records, argument.text, &TrajectoryRecord::path);
    if (found != records.end()) return found->components;
    std::vector<std::string> paths;
    for (const TrajectoryRecord& record : records) paths.push_back(record.path);
    fail(argument.begin, "there is no record " + in_quotes(argument.text),
         paths.empty() ? "expected a record that output.channels asks for; the file has none"
                       : name_hint(argument.text, paths));
  }

  // Reads .x, .y, .z or .length behind a vector. Returns the first token behind the call.
  std::size_t read_part(RecordedQuantity& quantity) const {
    const std::size_t behind = close_ + 1;
    const Token& token = tokens_[behind];
    std::vector<std::string> parts = {"x", "y", "z"};
    if (quantity.kind != QuantityKind::shadow) parts.emplace_back("length");
    const std::string all =
        quantity.kind == QuantityKind::shadow ? ".x, .y or .z" : ".x, .y, .z or .length";
    if (token.kind != Token::Kind::member) {
      if (quantity.components == 1) return behind;
      const bool is_shadow = quantity.kind == QuantityKind::shadow;
      fail(tokens_[close_].begin,
           in_quotes(name_.text) + (is_shadow ? " has no axis" : " is a vector"),
           "expected " + all + " behind it");
    }
    if (quantity.components == 1) {
      fail(token.begin, in_quotes(name_.text) + " is a number", "expected no ." + token.text);
    }
    const auto found = std::ranges::find(parts, token.text);
    if (found == parts.end()) {
      fail(token.begin, in_quotes(name_.text) + " has no part ." + token.text, "expected " + all);
    }
    quantity.part = static_cast<QuantityPart>(found - parts.begin());
    return behind + 1;
  }

  const LocatedText& expression_;
  std::span<const Token> tokens_;
  const Token& name_;
  std::size_t close_;
  const TrajectoryContents& contents_;
  const Form& form_;
  std::vector<Argument> arguments_;
};

}  // namespace

std::vector<std::string> quantity_names() {
  std::vector<std::string> names;
  for (const Form& form : forms) names.emplace_back(form.name);
  return names;
}

QuantityCall read_quantity(const LocatedText& expression, std::span<const Token> tokens,
                           std::size_t first, std::size_t close,
                           const TrajectoryContents& contents) {
  return CallReader(expression, tokens, first, close, contents).read();
}

}  // namespace weft::sim
