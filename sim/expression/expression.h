// Small expressions over named variables, such as "contact.friction < 0.3 && runs > 2".
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/case/located_text.h"
#include "sim/expression/expression_tokens.h"

namespace weft::sim {

// A variable of an expression. Its name may be a path of a case, such as "contact.friction". An
// expression writes a name with other characters than letters, digits, _ and dots in quotes. A
// variable without a name is for tokens of the kind `variable`.
struct ExpressionVariable {
  std::string name;
  // True if the value is a text. An expression may only compare it with a text in quotes, by == or
  // !=: time.method == 'euler'.
  bool is_text = false;
};

// An expression of numbers, read once and evaluated often.
//
// Operators, those that bind most tightly first: ^ (to the right), - + ! before a value, * /, + -,
// comparisons (< <= > >= == !=), &&, ||, a ? b : c. Conditions are 1 or 0, and any number but 0
// holds. Functions: abs, sqrt, exp, log (natural), log10, log2, sin, cos, tan, asin, acos, atan,
// atan2 (radians), floor, ceil, round, min, max. Constants: pi, true (1), false (0).
class Expression {
 public:
  // Throws CaseError at the character at fault. Its hint names the nearest variable or function.
  Expression(const LocatedText& text, const std::vector<ExpressionVariable>& variables);
  // Reads an expression from its tokens, of which the last is of the kind `end`. The caller may
  // have put tokens of the kind `variable` in the place of others.
  Expression(const LocatedText& text, std::vector<Token> tokens,
             const std::vector<ExpressionVariable>& variables);
  ~Expression();
  Expression(Expression&&) noexcept;
  Expression& operator=(Expression&&) noexcept;

  // Returns the value, given one number per variable. The number of a variable that is a text is
  // code_of() its value. The result may be infinite or NaN, as that of 1 / 0. Calls on one object
  // must not overlap in time. O(length of the expression).
  double value(std::span<const double> values) const;
  // True if the value is a number other than 0.
  bool holds(std::span<const double> values) const;
  // Returns the number that stands for a text as value of a variable. It is the same for all texts
  // with which the expression compares nothing.
  double code_of(const std::string& text) const;
  // Returns the indices of the variables that the expression uses, each once, in increasing order.
  const std::vector<int>& used() const { return used_; }

  // Returns the functions that all expressions may call.
  static std::span<const FunctionArguments> functions();

 private:
  struct Evaluator;
  std::vector<int> used_;
  std::unique_ptr<Evaluator> evaluator_;
};

}  // namespace weft::sim
