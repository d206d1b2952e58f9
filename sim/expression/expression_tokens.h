// The parts of an expression's text: numbers, names, texts in quotes, operators and brackets.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim/case/located_text.h"

namespace weft::sim {

// A part of an expression.
struct Token {
  enum class Kind {
    number,
    name,    // letters, digits, _ and dots: `energy_total`, `contact.friction`
    text,    // 'cloth' or "cloth"
    member,  // .x behind a closing bracket
    operation,
    open,
    close,
    comma,
    variable,  // put there by a caller of Expression: `text` is the index of a variable
    end        // follows the last part
  };
  Kind kind = Kind::end;
  std::string text;       // without the quotes of a text and the dot of a member
  std::size_t begin = 0;  // first byte in the expression's text
  bool is(Kind wanted, const char* with) const { return kind == wanted && text == with; }
  bool is_operation(const char* sign) const { return is(Kind::operation, sign); }
};

// Returns the parts of the text, followed by one of the kind `end`. Throws CaseError for a
// character that no expression has, a number such as 1.2.3, a text without a closing quote, and an
// expression of more than 2000 bytes.
std::vector<Token> tokens_of(const LocatedText& expression);

// Throws CaseError at a byte of the expression. If the place of an expression has no line, the
// message says which character it is.
[[noreturn]] void fail_in_expression(const LocatedText& expression, std::size_t byte,
                                     const std::string& message, const std::string& hint);

// A function that expressions may call. `most` arguments at most; 0 if there is no limit.
struct FunctionArguments {
  std::string name;
  int least = 1, most = 1;
};

// Throws CaseError unless the tokens are one expression: values, operators and calls in their
// order, brackets in pairs, calls of `functions` with the right number of arguments, and no
// comparison of a comparison. The last token must be of the kind `end`. Names are not looked up.
void check_grammar(const LocatedText& expression, std::span<const Token> tokens,
                   std::span<const FunctionArguments> functions);

}  // namespace weft::sim
