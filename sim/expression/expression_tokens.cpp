#include "sim/expression/expression_tokens.h"

#include <algorithm>
#include <charconv>
#include <optional>

#include "sim/case/case_error.h"
#include "sim/case/case_text.h"

namespace weft::sim {

namespace {

constexpr std::size_t most_bytes = 2000;

bool is_digit(char byte) { return byte >= '0' && byte <= '9'; }
bool starts_name(char byte) {
  return (byte >= 'a' && byte <= 'z') || (byte >= 'A' && byte <= 'Z') || byte == '_';
}
bool continues_name(char byte) { return starts_name(byte) || is_digit(byte) || byte == '.'; }

// Splits the text of an expression.
class Splitter {
 public:
  explicit Splitter(const LocatedText& expression)
      : expression_(expression), text_(expression.text) {}

  std::vector<Token> tokens() {
    if (text_.size() > most_bytes) {
      fail_in_expression(expression_, 0,
                         "the expression has " + std::to_string(text_.size()) + " bytes",
                         "expected at most " + std::to_string(most_bytes));
    }
    while (true) {
      next_ = std::min(text_.find_first_not_of(" \t\r\n", next_), text_.size());
      if (next_ == text_.size()) break;
      tokens_.push_back(token());
    }
    tokens_.push_back({Token::Kind::end, "", text_.size()});
    return std::move(tokens_);
  }

 private:
  char after(std::size_t bytes) const {
    return next_ + bytes < text_.size() ? text_[next_ + bytes] : '\0';
  }

  // Returns the next `bytes` bytes as a token, and goes on behind them.
  Token take(Token::Kind kind, std::size_t bytes) {
    Token token{kind, text_.substr(next_, bytes), next_};
    next_ += bytes;
    return token;
  }

  Token token() {
    const char first = after(0);
    if (is_digit(first) || (first == '.' && is_digit(after(1)))) return number();
    if (starts_name(first)) return take(Token::Kind::name, length_of_name(0));
    if (first == '"' || first == '\'') return quoted();
    if (first == '.' && starts_name(after(1)) && follows_bracket()) {
      Token member = take(Token::Kind::member, length_of_name(1));
      member.text.erase(0, 1);
      return member;
    }
    if (first == '(') return take(Token::Kind::open, 1);
    if (first == ')') return take(Token::Kind::close, 1);
    if (first == ',') return take(Token::Kind::comma, 1);
    for (const char* sign : {"==", "!=", "<=", ">=", "&&", "||"}) {
      if (text_.compare(next_, 2, sign) == 0) return take(Token::Kind::operation, 2);
    }
    if (std::string_view("+-*/^<>!?:").find(first) != std::string_view::npos)
      return take(Token::Kind::operation, 1);
    fail_character();
  }

  bool follows_bracket() const {
    return !tokens_.empty() && tokens_.back().kind == Token::Kind::close;
  }

  std::size_t length_of_name(std::size_t start) const {
    std::size_t bytes = start;
    while (continues_name(after(bytes))) ++bytes;
    return bytes;
  }

  Token number() {
    double value = 0;
    const char* begin = text_.data() + next_;
    const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), value);
    const auto bytes = static_cast<std::size_t>(end - begin);
    if (error != std::errc{} || continues_name(after(bytes))) {
      std::size_t all = std::max<std::size_t>(bytes, 1);
      while (continues_name(after(all))) ++all;
      fail_in_expression(expression_, next_, in_quotes(text_.substr(next_, all)) + " is no number",
                         "expected a number such as 2, 0.5 or 1e-3");
    }
    return take(Token::Kind::number, bytes);
  }

  Token quoted() {
    const std::size_t end = text_.find(after(0), next_ + 1);
    if (end == std::string::npos) {
      fail_in_expression(expression_, next_, "the text has no closing quote",
                         "expected " + std::string(1, after(0)) + " at its end");
    }
    Token token{Token::Kind::text, text_.substr(next_ + 1, end - next_ - 1), next_};
    next_ = end + 1;
    return token;
  }

  [[noreturn]] void fail_character() const {
    const std::string sign(1, after(0));
    std::string hint = "expected numbers, names, operators and brackets";
    if (sign == "=") hint = "expected == to compare";
    if (sign == "&" || sign == "|") hint = "expected " + sign + sign;
    if (sign == "%") hint = "expected no %: no expression needs a remainder";
    std::size_t bytes = 1;
    while ((static_cast<unsigned char>(after(bytes)) & 0xC0) == 0x80) ++bytes;
    fail_in_expression(expression_, next_, "unexpected " + in_quotes(text_.substr(next_, bytes)),
                       hint);
  }

  const LocatedText& expression_;
  const std::string& text_;
  std::size_t next_ = 0;
  std::vector<Token> tokens_;
};

bool compares(const Token& token) {
  if (token.kind != Token::Kind::operation) return false;
  return token.text[0] == '<' || token.text[0] == '>' || token.text == "==" || token.text == "!=";
}

// Checks the order of tokens, one after the other.
class GrammarCheck {
 public:
  GrammarCheck(const LocatedText& expression, std::span<const Token> tokens,
               std::span<const FunctionArguments> functions)
      : expression_(expression), tokens_(tokens), functions_(functions) {}

  void run() {
    for (next_ = 0; tokens_[next_].kind != Token::Kind::end; ++next_) {
      if (expects_value_) {
        value(tokens_[next_]);
      } else {
        follower(tokens_[next_]);
      }
    }
    if (brackets_.size() > 1) {
      fail_in_expression(expression_, tokens_[brackets_.back().token].begin,
                         "the bracket is not closed", "expected a matching )");
    }
    if (expects_value_) fail_missing(tokens_[next_]);
    require_alternatives(tokens_[next_]);
  }

 private:
  // An open bracket. The first entry stands for the whole expression.
  struct Bracket {
    std::size_t token = 0;
    const FunctionArguments* function = nullptr;  // null if the bracket is no call
    int arguments = 1;
    int choices = 0;        // numbers of ? without their :
    bool compared = false;  // true after a comparison that no && or || has ended
  };

  // Checks a token where a value is expected.
  void value(const Token& token) {
    switch (token.kind) {
      case Token::Kind::number:
      case Token::Kind::text:
      case Token::Kind::variable:
        expects_value_ = false;
        return;
      case Token::Kind::name:
        if (tokens_[next_ + 1].kind == Token::Kind::open) {
          open(&function_of(token), ++next_);
        } else {
          expects_value_ = false;
        }
        return;
      case Token::Kind::open:
        open(nullptr, next_);
        return;
      case Token::Kind::operation:
        if (token.text == "-" || token.text == "+" || token.text == "!") return;
        break;
      default:
        break;
    }
    fail_missing(token);
  }

  void open(const FunctionArguments* function, std::size_t token) {
    brackets_.push_back({token, function});
  }

  [[noreturn]] void fail_missing(const Token& token) const {
    if (next_ == 0 && token.kind == Token::Kind::end) {
      fail_in_expression(expression_, token.begin, "the expression is empty", "expected a value");
    }
    const bool ends = token.kind == Token::Kind::end;
    fail_in_expression(expression_, token.begin,
                       ends ? "the expression ends where a value is expected"
                            : "unexpected " + in_quotes(token.text),
                       "expected a number, a name or a bracket");
  }

  const FunctionArguments& function_of(const Token& token) const {
    const auto found = std::ranges::find(functions_, token.text, &FunctionArguments::name);
    if (found != functions_.end()) return *found;
    std::vector<std::string> names;
    for (const FunctionArguments& function : functions_) names.push_back(function.name);
    fail_in_expression(expression_, token.begin, "unknown function " + in_quotes(token.text),
                       name_hint(token.text, names));
  }

  // Checks a token behind a value.
  void follower(const Token& token) {
    switch (token.kind) {
      case Token::Kind::operation:
        return operation(token);
      case Token::Kind::comma:
        return comma(token);
      case Token::Kind::close:
        return close(token);
      case Token::Kind::member:
        fail_in_expression(expression_, token.begin, "nothing here has a part ." + token.text,
                           "expected .x, .y, .z or .length only behind a vector");
      default: {
        const bool is_word = token.text == "and" || token.text == "or" || token.text == "not";
        fail_in_expression(expression_, token.begin,
                           "unexpected " + in_quotes(token.text) + " behind a value",
                           is_word ? "expected && for \"and\", || for \"or\", ! for \"not\""
                                   : "expected an operator between two values");
      }
    }
  }

  void operation(const Token& token) {
    Bracket& here = brackets_.back();
    if (token.text == "!") {
      fail_in_expression(expression_, token.begin, "unexpected \"!\" behind a value",
                         "expected != to compare, or ! before a condition");
    }
    if (compares(token)) {
      if (here.compared) {
        fail_in_expression(expression_, token.begin, "a comparison is compared",
                           "expected && between comparisons: 0 < a && a < 1");
      }
      here.compared = true;
    } else if (token.text == "&&" || token.text == "||") {
      here.compared = false;
    } else if (token.text == "?") {
      ++here.choices;
      here.compared = false;
    } else if (token.text == ":") {
      if (here.choices == 0) {
        fail_in_expression(expression_, token.begin, "unexpected \":\"",
                           "expected it only behind ?, as in a > 0 ? b : c");
      }
      --here.choices;
      here.compared = false;
    }
    expects_value_ = true;
  }

  void require_alternatives(const Token& end) const {
    if (brackets_.back().choices == 0) return;
    fail_in_expression(expression_, end.begin, "a ? has no :", "expected a > 0 ? b : c");
  }

  void comma(const Token& token) {
    Bracket& here = brackets_.back();
    require_alternatives(token);
    if (here.function == nullptr) {
      fail_in_expression(expression_, token.begin, "unexpected \",\"",
                         "expected commas only between the arguments of a function");
    }
    ++here.arguments;
    here.compared = false;
    expects_value_ = true;
  }

  void close(const Token& token) {
    const Bracket here = brackets_.back();
    if (brackets_.size() == 1) {
      fail_in_expression(expression_, token.begin, "unexpected \")\"", "expected a ( for each )");
    }
    require_alternatives(token);
    brackets_.pop_back();
    if (here.function == nullptr) return;
    const auto& [name, least, most] = *here.function;
    if (here.arguments >= least && (most == 0 || here.arguments <= most)) return;
    const bool too_few = here.arguments < least;
    const int wanted = too_few ? least : most;
    fail_in_expression(expression_, tokens_[here.token - 1].begin,
                       in_quotes(name) + " has " + counted(here.arguments, "argument", "arguments"),
                       "expected " +
                           std::string(least == most ? ""
                                       : too_few     ? "at least "
                                                     : "at most ") +
                           counted(wanted, "argument", "arguments"));
  }

  const LocatedText& expression_;
  std::span<const Token> tokens_;
  std::span<const FunctionArguments> functions_;
  std::size_t next_ = 0;
  bool expects_value_ = true;
  std::vector<Bracket> brackets_{1};
};

}  // namespace

void fail_in_expression(const LocatedText& expression, std::size_t byte, const std::string& message,
                        const std::string& hint) {
  const SourceLocation place = expression.at(std::min(byte, expression.text.size()));
  const bool is_known = !expression.places.empty();
  throw CaseError(place,
                  is_known ? message
                           : message + " (character " + std::to_string(byte + 1) + " of " +
                                 in_quotes(expression.text) + ")",
                  hint);
}

std::vector<Token> tokens_of(const LocatedText& expression) {
  return Splitter(expression).tokens();
}

void check_grammar(const LocatedText& expression, std::span<const Token> tokens,
                   std::span<const FunctionArguments> functions) {
  GrammarCheck(expression, tokens, functions).run();
}

}  // namespace weft::sim
