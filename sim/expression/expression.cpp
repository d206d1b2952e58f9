#include "sim/expression/expression.h"

#include <muParser.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "sim/case/case_text.h"

namespace weft::sim {

namespace {

struct Constant {
  const char* name;
  double value;
};
constexpr Constant constants[] = {{"pi", std::numbers::pi}, {"true", 1}, {"false", 0}};

double least_of(const double* values, int count) {
  return *std::min_element(values, values + count);
}
double most_of(const double* values, int count) {
  return *std::max_element(values, values + count);
}

double not_of(double value) { return value == 0 ? 1 : 0; }

// Defines the operators before a value: ! and, because muParser takes only one such operator, those
// that join_signs() makes of several.
void define_signs(mu::Parser& parser) {
  parser.DefineInfixOprt("!", not_of);
  parser.DefineInfixOprt("!!", [](double value) { return not_of(not_of(value)); });
  parser.DefineInfixOprt("-!", [](double value) { return -not_of(value); });
  parser.DefineInfixOprt("-!!", [](double value) { return -not_of(not_of(value)); });
}

void define_functions(mu::Parser& parser) {
  using One = double (*)(double);
  using Two = double (*)(double, double);
  const std::pair<const char*, One> of_one[] = {
      {"abs", std::fabs},    {"sqrt", std::sqrt}, {"exp", std::exp},    {"log", std::log},
      {"log10", std::log10}, {"log2", std::log2}, {"sin", std::sin},    {"cos", std::cos},
      {"tan", std::tan},     {"asin", std::asin}, {"acos", std::acos},  {"atan", std::atan},
      {"floor", std::floor}, {"ceil", std::ceil}, {"round", std::round}};
  parser.ClearFun();
  for (const auto& [name, function] : of_one) parser.DefineFun(name, function);
  parser.DefineFun("atan2", static_cast<Two>(std::atan2));
  parser.DefineFun("min", least_of);
  parser.DefineFun("max", most_of);
  define_signs(parser);
}

// Returns the operator that equals `sign` (+, - or !) before `following`, which is empty or an
// operator that this function returned. All have the same precedence.
std::string joined_sign(const std::string& sign, const std::string& following) {
  const bool negates = following.starts_with('-');
  if (sign == "+") return following;
  if (sign == "-") return negates ? following.substr(1) : '-' + following;
  return following.substr(negates ? 1 : 0) == "!" ? "!!" : "!";
}

// Joins the operators that stand before the same value. The first token of each such row gets the
// result, the others become empty.
void join_signs(std::vector<Token>& tokens) {
  const auto follows_value = [&](std::size_t i) {
    using enum Token::Kind;
    const Token::Kind before = i == 0 ? open : tokens[i - 1].kind;
    return before != open && before != comma && before != operation;
  };
  // From the last to the first, because a token's operator is joined with that behind it.
  for (std::size_t i = tokens.size() - 1; i-- > 0;) {
    Token& token = tokens[i];
    if (token.kind != Token::Kind::operation || follows_value(i)) continue;
    Token& next = tokens[i + 1];
    const bool is_row = next.kind == Token::Kind::operation;
    token.text = joined_sign(token.text, is_row ? std::exchange(next.text, "") : "");
  }
}

bool tests_equality(const Token& token) {
  return token.is_operation("==") || token.is_operation("!=");
}

// Puts numbers and short names of variables in the place of the names and texts of an expression,
// for muParser.
class Translation {
 public:
  Translation(const LocatedText& expression, std::vector<Token>& tokens,
              const std::vector<ExpressionVariable>& variables)
      : expression_(expression), tokens_(tokens), variables_(variables) {
    for (std::size_t i = 0; i + 1 < tokens_.size(); ++i) translate(i);
  }

  std::vector<std::string> texts;  // texts with which the expression compares variables
  std::set<int> used;              // indices of variables

  static std::string short_name(int variable) { return "v" + std::to_string(variable); }

 private:
  void translate(std::size_t i) {
    Token& token = tokens_[i];
    if (token.kind == Token::Kind::text) return translate_quoted(i);
    if (token.kind == Token::Kind::variable) return use(i, std::stoi(token.text));
    if (token.kind != Token::Kind::name || tokens_[i + 1].kind == Token::Kind::open) return;
    if (const int variable = index_of(token.text); variable >= 0) return use(i, variable);
    const auto* constant = std::ranges::find(constants, token.text, &Constant::name);
    if (constant == std::end(constants)) fail_unknown(token);
    token.text = number_text(constant->value);
  }

  std::vector<std::string> names_of_variables() const {
    std::vector<std::string> names;
    for (const ExpressionVariable& variable : variables_) {
      if (!variable.name.empty()) names.push_back(variable.name);
    }
    return names;
  }

  int index_of(const std::string& name) const {
    if (name.empty()) return -1;
    const auto found = std::ranges::find(variables_, name, &ExpressionVariable::name);
    return found == variables_.end() ? -1 : static_cast<int>(found - variables_.begin());
  }

  [[noreturn]] void fail_unknown(const Token& token) const {
    std::vector<std::string> names = names_of_variables();
    for (const Constant& constant : constants) names.emplace_back(constant.name);
    fail_in_expression(expression_, token.begin, "unknown name " + in_quotes(token.text),
                       name_hint(token.text, names));
  }

  void use(std::size_t i, int variable) {
    if (variables_[variable].is_text) require_comparison(i, variable);
    used.insert(variable);
    tokens_[i].kind = Token::Kind::name;
    tokens_[i].text = short_name(variable);
  }

  // Throws CaseError unless the variable at token i is compared with a text on one of its sides.
  void require_comparison(std::size_t i, int variable) const {
    if (i >= 2 && tests_equality(tokens_[i - 1]) && is_translated_text(i - 2)) return;
    const bool after = tests_equality(tokens_[i + 1]) && tokens_[i + 2].kind == Token::Kind::text;
    if (after && stands_alone(i)) return;
    const std::string& name = variables_[variable].name;
    fail_in_expression(expression_, tokens_[i].begin, in_quotes(name) + " is a text",
                       "expected a comparison with a text: " + name + " == 'TEXT'");
  }

  bool is_translated_text(std::size_t i) const {
    return std::ranges::find(text_tokens_, i) != text_tokens_.end();
  }

  // True if the comparison whose left side is token i compares this token alone with one token.
  bool stands_alone(std::size_t i) const {
    const auto ends = [](const Token& token) {
      const auto is_sign = [&](const char* sign) { return token.is_operation(sign); };
      return token.kind != Token::Kind::operation || is_sign("&&") || is_sign("||") ||
             is_sign("?") || is_sign(":");
    };
    return (i == 0 || ends(tokens_[i - 1])) && ends(tokens_[i + 3]);
  }

  // Translates a name in quotes, or a text that a variable is compared with.
  void translate_quoted(std::size_t i) {
    Token& token = tokens_[i];
    if (const int variable = index_of(token.text); variable >= 0) return use(i, variable);
    const bool before =
        i >= 2 && tests_equality(tokens_[i - 1]) && is_text_variable(tokens_[i - 2]);
    const bool after = tests_equality(tokens_[i + 1]) && is_text_variable(tokens_[i + 2]);
    if (!(before && stands_alone(i - 2)) && !(after && stands_alone(i))) {
      fail_in_expression(expression_, token.begin,
                         "the text " + in_quotes(token.text) + " is compared with no text",
                         hint_for_text(token.text));
    }
    const auto known = std::ranges::find(texts, token.text);
    const auto code = known - texts.begin();
    if (known == texts.end()) texts.push_back(token.text);
    text_tokens_.push_back(i);
    token.kind = Token::Kind::number;
    token.text = std::to_string(code);
  }

  std::string hint_for_text(const std::string& text) const {
    if (const auto near = nearest_name(text, names_of_variables()))
      return "did you mean the name \"" + *near + "\"?";
    return "expected it beside == or != and the name of a text";
  }

  // True if the token names a variable that is a text, be it translated or not.
  bool is_text_variable(const Token& token) const {
    for (std::size_t k = 0; k < variables_.size(); ++k) {
      if (!variables_[k].is_text) continue;
      if (token.text == variables_[k].name) return true;
      if (token.kind == Token::Kind::name && token.text == short_name(static_cast<int>(k)) &&
          used.contains(static_cast<int>(k))) {
        return true;
      }
    }
    return false;
  }

  const LocatedText& expression_;
  std::vector<Token>& tokens_;
  const std::vector<ExpressionVariable>& variables_;
  std::vector<std::size_t> text_tokens_;  // tokens that were texts and have become numbers
};

}  // namespace

struct Expression::Evaluator {
  mu::Parser parser;
  std::vector<double> values;  // by variable; muParser reads them
  std::vector<std::string> texts;
};

Expression::Expression(const LocatedText& text, const std::vector<ExpressionVariable>& variables)
    : Expression(text, tokens_of(text), variables) {}

Expression::Expression(const LocatedText& text, std::vector<Token> tokens,
                       const std::vector<ExpressionVariable>& variables)
    : evaluator_(std::make_unique<Evaluator>()) {
  check_grammar(text, tokens, functions());
  Translation translation(text, tokens, variables);
  used_.assign(translation.used.begin(), translation.used.end());
  evaluator_->texts = std::move(translation.texts);
  evaluator_->values.resize(variables.size());
  mu::Parser& parser = evaluator_->parser;
  define_functions(parser);
  for (const int variable : used_)
    parser.DefineVar(Translation::short_name(variable), &evaluator_->values[variable]);
  join_signs(tokens);
  std::string translated;
  std::vector<std::size_t> starts;  // by token: its place in `translated`
  for (const Token& token : tokens) {
    // muParser wants the bracket of a call right behind the name.
    if (token.kind == Token::Kind::open && !translated.empty()) translated.pop_back();
    starts.push_back(translated.size());
    translated += token.text + ' ';
  }
  try {
    parser.SetExpr(translated);
    parser.Eval();
  } catch (const mu::ParserError& error) {
    const auto position = static_cast<std::size_t>(std::max(error.GetPos(), 0));
    const auto behind = std::ranges::upper_bound(starts, position);
    const Token& token = tokens[static_cast<std::size_t>(behind - starts.begin()) - 1];
    fail_in_expression(text, token.begin, "this cannot be evaluated",
                       "muParser says: " + error.GetMsg());
  }
}

Expression::~Expression() = default;
Expression::Expression(Expression&&) noexcept = default;
Expression& Expression::operator=(Expression&&) noexcept = default;

double Expression::value(std::span<const double> values) const {
  std::ranges::copy(values, evaluator_->values.begin());
  return evaluator_->parser.Eval();
}

bool Expression::holds(std::span<const double> values) const {
  const double result = value(values);
  return result != 0 && !std::isnan(result);
}

double Expression::code_of(const std::string& text) const {
  const auto& texts = evaluator_->texts;
  const auto found = std::ranges::find(texts, text);
  return found == texts.end() ? -1 : static_cast<double>(found - texts.begin());
}

std::span<const FunctionArguments> Expression::functions() {
  static const std::vector<FunctionArguments> all = {
      {"abs"},   {"sqrt"}, {"exp"},   {"log"},         {"log10"},     {"log2"},
      {"sin"},   {"cos"},  {"tan"},   {"asin"},        {"acos"},      {"atan"},
      {"floor"}, {"ceil"}, {"round"}, {"atan2", 2, 2}, {"min", 1, 0}, {"max", 1, 0}};
  return all;
}

}  // namespace weft::sim
