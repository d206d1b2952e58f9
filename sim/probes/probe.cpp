#include "sim/probes/probe.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <variant>

#include "sim/case/case_text.h"
#include "sim/expression/expression.h"

namespace weft::sim {

// These types are members of Probe's, and therefore not in an unnamed namespace.
enum class Reduction { first, last, least, most, mean, at, first_time };

// The time of an instant.
struct TimeOfInstant {};

// A series, by its index in the contents.
struct SeriesNumber {
  Instants instants;
  int number;
};

namespace {

constexpr double no_value = std::numeric_limits<double>::quiet_NaN();

struct ReductionName {
  const char* name;
  Reduction reduction;
};
constexpr ReductionName reductions[] = {{"first", Reduction::first},
                                        {"last", Reduction::last},
                                        {"min", Reduction::least},
                                        {"max", Reduction::most},
                                        {"mean", Reduction::mean},
                                        {"at", Reduction::at},
                                        {"first_time", Reduction::first_time}};

struct NamedNumber {
  const char* name;
  RunNumber number;
};
constexpr NamedNumber run_numbers[] = {{"cpu_time", RunNumber::cpu_time},
                                       {"wall_time", RunNumber::wall_time},
                                       {"duration", RunNumber::duration},
                                       {"frames", RunNumber::frames}};

bool is_call(std::span<const Token> tokens, std::size_t i) {
  return tokens[i].kind == Token::Kind::name && tokens[i + 1].kind == Token::Kind::open;
}

}  // namespace

// An expression whose variables are found in a trajectory.
struct Probe::Formula {
  using Source = std::variant<RunNumber, TimeOfInstant, SeriesNumber, RecordedQuantity,
                              std::unique_ptr<TimeFunction>>;
  std::optional<Expression> expression;
  std::vector<Source> sources;  // by variable of the expression
  Instants instants = Instants::frames;
};

struct Probe::TimeFunction {
  Reduction reduction = Reduction::last;
  Formula of;    // varies in time
  Formula time;  // time of Reduction::at
};

// Turns the text of a probe into a formula.
class Probe::Compiler {
 public:
  Compiler(const LocatedText& text, const TrajectoryContents& contents)
      : text_(text), contents_(contents), tokens_(tokens_of(text)) {}

  Formula compile() { return compile(0, tokens_.size() - 1, false); }

 private:
  using Source = Formula::Source;

  // Compiles the tokens from `first` to the one before `last`. A formula that `varies` is evaluated
  // at instants.
  Formula compile(std::size_t first, std::size_t last, bool varies) {
    Formula formula;
    std::vector<ExpressionVariable> variables;
    const auto add = [&](const std::string& name, Source source) {
      variables.push_back({name});
      formula.sources.push_back(std::move(source));
    };
    for (const auto& [name, number] : run_numbers) add(name, number);
    if (varies) add_series(add);
    std::vector<Token> tokens;
    const auto put_variable = [&](std::size_t at, Source source) {
      tokens.push_back(
          {Token::Kind::variable, std::to_string(variables.size()), tokens_[at].begin});
      add("", std::move(source));
    };
    for (std::size_t i = first; i < last;) {
      if (!is_call(tokens_, i)) {
        if (!varies) refuse_varying_name(tokens_[i]);
        tokens.push_back(tokens_[i++]);
        continue;
      }
      const std::size_t close = closing(i + 1);
      const std::vector<std::size_t> ends = ends_of_arguments(i + 1, close);
      if (const auto reduction = reduction_of(tokens_[i], ends.size())) {
        put_variable(i, time_function(*reduction, i, ends));
        i = close + 1;
      } else if (is_quantity(tokens_[i].text)) {
        const QuantityCall call = read_quantity(text_, tokens_, i, close, contents_);
        if (!varies) fail_varying(tokens_[i], text_between(i, call.end));
        put_variable(i, call.quantity);
        i = call.end;
      } else {
        require_function(tokens_[i]);
        tokens.push_back(tokens_[i++]);
      }
    }
    tokens.push_back({Token::Kind::end, "", tokens_[last].begin});
    formula.expression.emplace(text_, std::move(tokens), std::move(variables));
    if (varies) formula.instants = instants_of(formula, tokens_[first].begin);
    return formula;
  }

  void add_series(const auto& add) const {
    add("time", TimeOfInstant{});
    for (std::size_t i = 0; i < contents_.series.size(); ++i)
      add(contents_.series[i].name, SeriesNumber{Instants::frames, static_cast<int>(i)});
    for (std::size_t i = 0; i < contents_.step_series.size(); ++i) {
      add("step." + contents_.step_series[i].name,
          SeriesNumber{Instants::steps, static_cast<int>(i)});
    }
  }

  // Returns the token that closes the bracket that token `open` opens.
  std::size_t closing(std::size_t open) const {
    int depth = 0;
    for (std::size_t i = open; i < tokens_.size(); ++i) {
      if (tokens_[i].kind == Token::Kind::open) ++depth;
      if (tokens_[i].kind == Token::Kind::close && --depth == 0) return i;
    }
    fail_in_expression(text_, tokens_[open].begin, "the bracket is not closed",
                       "expected a matching )");
  }

  // Returns the tokens behind each argument of a call: commas, and the closing bracket.
  std::vector<std::size_t> ends_of_arguments(std::size_t open, std::size_t close) const {
    if (open + 1 == close) return {};
    std::vector<std::size_t> ends;
    int depth = 0;
    for (std::size_t i = open; i < close; ++i) {
      if (tokens_[i].kind == Token::Kind::open) ++depth;
      if (tokens_[i].kind == Token::Kind::close) --depth;
      if (tokens_[i].kind == Token::Kind::comma && depth == 1) ends.push_back(i);
    }
    ends.push_back(close);
    return ends;
  }

  // Returns the reduction that a call with this number of arguments is, if it is one. min and max
  // of several arguments are functions of numbers.
  std::optional<Reduction> reduction_of(const Token& name, std::size_t arguments) const {
    const auto* found = std::ranges::find(reductions, name.text, &ReductionName::name);
    if (found == std::end(reductions)) return std::nullopt;
    const Reduction reduction = found->reduction;
    const bool is_extreme = reduction == Reduction::least || reduction == Reduction::most;
    if (is_extreme && arguments != 1) return std::nullopt;
    const std::size_t wanted = reduction == Reduction::at ? 2 : 1;
    if (arguments == wanted) return reduction;
    fail_in_expression(text_, name.begin,
                       in_quotes(name.text) + " has " +
                           counted(static_cast<std::int64_t>(arguments), "argument", "arguments"),
                       reduction == Reduction::at ? "expected a quantity and a time: at(q, t)"
                                                  : "expected 1 argument, which varies in time");
  }

  Source time_function(Reduction reduction, std::size_t name,
                       const std::vector<std::size_t>& ends) {
    auto function = std::make_unique<TimeFunction>();
    function->reduction = reduction;
    function->of = compile(name + 2, ends[0], true);
    if (reduction == Reduction::at) function->time = compile(ends[0] + 1, ends[1], false);
    return function;
  }

  static bool is_quantity(const std::string& name) {
    const std::vector<std::string> names = quantity_names();
    return std::ranges::find(names, name) != names.end();
  }

  // Throws CaseError unless the token names a function of numbers.
  void require_function(const Token& name) const {
    std::vector<std::string> names;
    for (const ReductionName& each : reductions) names.emplace_back(each.name);
    for (const std::string& each : quantity_names()) names.push_back(each);
    for (const FunctionArguments& each : Expression::functions()) {
      if (each.name == name.text) return;
      names.push_back(each.name);
    }
    fail_in_expression(text_, name.begin, "unknown function " + in_quotes(name.text),
                       name_hint(name.text, names));
  }

  // Throws CaseError for a name that varies in time.
  void refuse_varying_name(const Token& token) const {
    if (token.kind != Token::Kind::name && token.kind != Token::Kind::text) return;
    const auto refuse = [&](const std::string& name, const std::string& written) {
      if (token.text == name) fail_varying(token, written);
    };
    const auto quoted = [&](const std::string& name) {
      return token.kind == Token::Kind::text ? '\'' + name + '\'' : name;
    };
    refuse("time", quoted("time"));
    for (const auto& [name, units] : contents_.series) refuse(name, quoted(name));
    for (const auto& [name, units] : contents_.step_series)
      refuse("step." + name, quoted("step." + name));
    const bool is_run_number =
        std::ranges::find(run_numbers, token.text, &NamedNumber::name) != std::end(run_numbers);
    if (!is_run_number) refuse_unknown_series(token);
  }

  // Throws CaseError for an unknown name that resembles a series.
  void refuse_unknown_series(const Token& token) const {
    std::vector<std::string> names = {"time"};
    for (const NamedNumber& number : run_numbers) names.emplace_back(number.name);
    for (const auto& [name, units] : contents_.series) names.push_back(name);
    for (const auto& [name, units] : contents_.step_series) names.push_back("step." + name);
    if (!nearest_name(token.text, names) || is_constant(token.text)) return;
    fail_in_expression(text_, token.begin, "unknown name " + in_quotes(token.text),
                       name_hint(token.text, names));
  }

  static bool is_constant(const std::string& name) {
    return name == "pi" || name == "true" || name == "false";
  }

  [[noreturn]] void fail_varying(const Token& at, const std::string& written) const {
    fail_in_expression(text_, at.begin, in_quotes(at.text) + " varies in time",
                       "expected a function over time around it, such as last(" + written + ")");
  }

  std::string text_between(std::size_t first, std::size_t end) const {
    std::string text =
        text_.text.substr(tokens_[first].begin, tokens_[end].begin - tokens_[first].begin);
    while (!text.empty() && text.back() == ' ') text.pop_back();
    return text;
  }

  // Returns the instants at which a formula has values. Throws CaseError if it mixes frames and
  // steps.
  Instants instants_of(const Formula& formula, std::size_t begin) const {
    bool has_frames = false, has_steps = false;
    for (const int variable : formula.expression->used()) {
      const Source& source = formula.sources[variable];
      const auto* series = std::get_if<SeriesNumber>(&source);
      if (series != nullptr && series->instants == Instants::steps) has_steps = true;
      if (series != nullptr && series->instants == Instants::frames) has_frames = true;
      if (std::holds_alternative<RecordedQuantity>(source)) has_frames = true;
    }
    if (has_frames && has_steps) {
      fail_in_expression(text_, begin, "series of steps are mixed with quantities of frames",
                         "expected only names step.NAME, or none of them, within one function over "
                         "time");
    }
    return has_steps ? Instants::steps : Instants::frames;
  }

  const LocatedText& text_;
  const TrajectoryContents& contents_;
  std::vector<Token> tokens_;
};

// Evaluates a formula: once, or at instants.
class Probe::Evaluation {
 public:
  Evaluation(const Formula& formula, RecordedValues& recorded)
      : formula_(formula), recorded_(recorded), values_(formula.sources.size(), 0.0) {
    for (const int variable : formula_.expression->used()) {
      const Formula::Source& source = formula_.sources[variable];
      if (const auto* number = std::get_if<RunNumber>(&source)) {
        values_[variable] = recorded_.number(*number);
      } else if (const auto* function = std::get_if<std::unique_ptr<TimeFunction>>(&source)) {
        values_[variable] = reduce(**function);
      }
    }
  }

  double constant() const { return formula_.expression->value(values_); }

  int count() const { return recorded_.count(formula_.instants); }
  double time(int index) const { return recorded_.time(formula_.instants, index); }
  double at(int index) {
    for (const int variable : formula_.expression->used()) {
      const Formula::Source& source = formula_.sources[variable];
      if (const auto* series = std::get_if<SeriesNumber>(&source)) {
        values_[variable] = recorded_.series(series->instants, series->number, index);
      } else if (const auto* quantity = std::get_if<RecordedQuantity>(&source)) {
        values_[variable] = recorded_.quantity(*quantity, index);
      } else if (std::holds_alternative<TimeOfInstant>(source)) {
        values_[variable] = time(index);
      }
    }
    return formula_.expression->value(values_);
  }

 private:
  double reduce(const TimeFunction& function) {
    Evaluation of(function.of, recorded_);
    const int count = of.count();
    if (count == 0) return no_value;
    switch (function.reduction) {
      case Reduction::first:
        return of.at(0);
      case Reduction::last:
        return of.at(count - 1);
      case Reduction::least:
        return of.extreme(std::less<>());
      case Reduction::most:
        return of.extreme(std::greater<>());
      case Reduction::mean:
        return of.mean();
      case Reduction::at:
        return of.at_time(Evaluation(function.time, recorded_).constant());
      case Reduction::first_time:
        return of.first_time();
    }
    return no_value;
  }

  double extreme(const auto& is_further) {
    double result = no_value;
    for (int i = 0; i < count(); ++i) {
      const double value = at(i);
      if (!std::isnan(value) && (std::isnan(result) || is_further(value, result))) result = value;
    }
    return result;
  }

  // Returns the mean over the intervals at both ends of which there are numbers. Without one, it is
  // the first number.
  double mean() {
    double integral = 0, length = 0, single = no_value, last = no_value;
    for (int i = 0; i < count(); ++i) {
      const double value = at(i);
      if (std::isnan(single)) single = value;
      if (i > 0 && !std::isnan(last) && !std::isnan(value)) {
        const double interval = time(i) - time(i - 1);
        integral += 0.5 * interval * (last + value);
        length += interval;
      }
      last = value;
    }
    return length > 0 ? integral / length : single;
  }

  double at_time(double wanted) {
    const int count = this->count();
    if (!(wanted >= time(0) && wanted <= time(count - 1))) return no_value;
    int low = 0, high = count - 1;  // time(low) <= wanted <= time(high)
    while (high - low > 1) {
      const int middle = low + (high - low) / 2;
      (time(middle) <= wanted ? low : high) = middle;
    }
    if (wanted == time(low)) return at(low);
    if (wanted == time(high)) return at(high);
    const double share = (wanted - time(low)) / (time(high) - time(low));
    const double before = at(low);
    return before + share * (at(high) - before);
  }

  double first_time() {
    for (int i = 0; i < count(); ++i) {
      const double value = at(i);
      if (value != 0 && !std::isnan(value)) return time(i);
    }
    return no_value;
  }

  const Formula& formula_;
  RecordedValues& recorded_;
  std::vector<double> values_;  // by variable
};

Probe::Probe(const LocatedText& text, const TrajectoryContents& contents)
    : formula_(std::make_unique<Formula>(Compiler(text, contents).compile())) {}
Probe::~Probe() = default;
Probe::Probe(Probe&&) noexcept = default;
Probe& Probe::operator=(Probe&&) noexcept = default;

double Probe::value(RecordedValues& values) const {
  return Evaluation(*formula_, values).constant();
}

}  // namespace weft::sim
