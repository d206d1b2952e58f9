#include "sim/expression/expression.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/case/case_error.h"

namespace weft::sim::expression_test {

namespace {

// An expression in line 3 of a file, as the value of `rule = "..."`.
LocatedText located(const std::string& text) {
  return located_text(text, {"sweep.toml", 3, 8}, "\n\nrule = '" + text + "'\n");
}

double value_of(const std::string& text, const std::vector<ExpressionVariable>& variables = {},
                const std::vector<double>& values = {}) {
  return Expression({text, {}}, variables).value(values);
}

const std::vector<ExpressionVariable> factors = {
    {"contact.friction"}, {"material.cotton.density"}, {"time.method", true}, {"body.my-sheet.x"}};

std::string error_of(const std::string& text) {
  try {
    const Expression expression(located(text), factors);
  } catch (const CaseError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Expression, ComputesAsWritten) {
  EXPECT_EQ(value_of("1 + 2 * 3 - 4 / 8"), 6.5);
  EXPECT_EQ(value_of("2 ^ 3 ^ 2"), 512);
  EXPECT_EQ(value_of("-2 ^ 2"), -4);
  EXPECT_EQ(value_of("(1 + 2) * -3"), -9);
  EXPECT_EQ(value_of("1e-3 * 2.5E+2 + .5"), 0.75);
  EXPECT_EQ(value_of("min(3, 1, 2) + max(3, 4)"), 5);
  EXPECT_EQ(value_of("2 > 1 ? 5 : 1 / 0"), 5);
  EXPECT_DOUBLE_EQ(value_of("atan2(1, -1) + sqrt(abs(-4))"), 0.75 * std::numbers::pi + 2);
  EXPECT_DOUBLE_EQ(value_of("cos(pi) + exp(0) + log(exp(2)) + log10(1000) + log2(8)"), 8);
  EXPECT_EQ(value_of("floor(1.5) + ceil(1.5) + round(1.6)"), 5);
  EXPECT_TRUE(std::isinf(value_of("1 / 0")));
  EXPECT_TRUE(std::isnan(value_of("0 / 0")));
}

TEST(Expression, JoinsConditions) {
  EXPECT_EQ(value_of("1 < 2 && 3 >= 3"), 1);
  EXPECT_EQ(value_of("1 > 2 || 2 != 2"), 0);
  EXPECT_EQ(value_of("!(1 > 2) && true"), 1);
  EXPECT_EQ(value_of("1 == 1 || 1 == 2 && false"), 1);
  const Expression nothing({"0 / 0", {}}, {});
  EXPECT_FALSE(nothing.holds({}));
}

TEST(Expression, TakesSeveralSignsBeforeAValue) {
  EXPECT_EQ(value_of("--3"), 3);
  EXPECT_EQ(value_of("1 - - -3"), -2);
  EXPECT_EQ(value_of("-+-2 ^ 2"), 4);
  EXPECT_EQ(value_of("2 ^ --3 * +-(1)"), -8);
  EXPECT_EQ(value_of("!-1"), 0);
  EXPECT_EQ(value_of("!!7"), 1);
  EXPECT_EQ(value_of("!!!(7)"), 0);
  EXPECT_EQ(value_of("2 - !0"), 1);
  EXPECT_EQ(value_of("-!0 + 5"), 4);
  EXPECT_EQ(value_of("-!!3 * 2"), -2);
  EXPECT_EQ(value_of("--!!-!0"), 1);
  EXPECT_EQ(value_of("max(--1, -!1) < 2 && !!-2 ? --5 : !6"), 5);
  const Expression expression({"!!contact.friction == 1 && --'body.my-sheet.x' < 2", {}}, factors);
  EXPECT_TRUE(expression.holds(std::vector<double>{0.3, 0, 0, 1}));
  EXPECT_FALSE(expression.holds(std::vector<double>{0, 0, 0, 1}));
}

TEST(Expression, ReadsVariables) {
  const std::string rule = "contact.friction > 0.2 && 'body.my-sheet.x' < material.cotton.density";
  const Expression expression({rule, {}}, factors);
  EXPECT_EQ(expression.used(), (std::vector<int>{0, 1, 3}));
  EXPECT_TRUE(expression.holds(std::vector<double>{0.3, 2, 0, 1}));
  EXPECT_FALSE(expression.holds(std::vector<double>{0.3, 2, 0, 3}));
  EXPECT_FALSE(expression.holds(std::vector<double>{0.2, 2, 0, 1}));
}

TEST(Expression, ComparesTexts) {
  const Expression expression({"time.method == 'euler' || \"cvode\" == time.method", {}}, factors);
  const auto holds = [&](const std::string& method) {
    return expression.holds(std::vector<double>{0, 0, expression.code_of(method), 0});
  };
  EXPECT_TRUE(holds("euler"));
  EXPECT_TRUE(holds("cvode"));
  EXPECT_FALSE(holds("verlet"));
  const Expression other({"time.method != 'euler'", {}}, factors);
  EXPECT_FALSE(other.holds(std::vector<double>{0, 0, other.code_of("euler"), 0}));
  EXPECT_TRUE(other.holds(std::vector<double>{0, 0, other.code_of("arkode"), 0}));
}

TEST(Expression, SaysWhereItIsWrong) {
  const std::pair<const char*, const char*> errors[] = {
      {"contact.frction > 1",
       "sweep.toml:3:9: unknown name \"contact.frction\"\n  did you mean \"contact.friction\"?"},
      {"1 + sqr(2)", "sweep.toml:3:13: unknown function \"sqr\"\n  did you mean \"sqrt\"?"},
      {"1 +",
       "sweep.toml:3:12: the expression ends where a value is expected\n"
       "  expected a number, a name or a bracket"},
      {"", "sweep.toml:3:9: the expression is empty\n  expected a value"},
      {"1 = 1", "sweep.toml:3:11: unexpected \"=\"\n  expected == to compare"},
      {"1 & 1", "sweep.toml:3:11: unexpected \"&\"\n  expected &&"},
      {"2 * µ",
       "sweep.toml:3:13: unexpected \"µ\"\n"
       "  expected numbers, names, operators and brackets"},
      {"1.2.3",
       "sweep.toml:3:9: \"1.2.3\" is no number\n  expected a number such as 2, 0.5 or 1e-3"},
      {"2 pi",
       "sweep.toml:3:11: unexpected \"pi\" behind a value\n"
       "  expected an operator between two values"},
      {"1 and 2",
       "sweep.toml:3:11: unexpected \"and\" behind a value\n"
       "  expected && for \"and\", || for \"or\", ! for \"not\""},
      {"(1 + 2", "sweep.toml:3:9: the bracket is not closed\n  expected a matching )"},
      {"1 + 2)", "sweep.toml:3:14: unexpected \")\"\n  expected a ( for each )"},
      {"(1, 2)",
       "sweep.toml:3:11: unexpected \",\"\n"
       "  expected commas only between the arguments of a function"},
      {"sqrt(1, 2)", "sweep.toml:3:9: \"sqrt\" has 2 arguments\n  expected 1 argument"},
      {"0 < contact.friction < 1",
       "sweep.toml:3:30: a comparison is compared\n"
       "  expected && between comparisons: 0 < a && a < 1"},
      {"1 > 0 ? 2", "sweep.toml:3:18: a ? has no :\n  expected a > 0 ? b : c"},
      {"1 : 2",
       "sweep.toml:3:11: unexpected \":\"\n  expected it only behind ?, as in a > 0 ? b : c"},
      {"time.method > 1",
       "sweep.toml:3:9: \"time.method\" is a text\n"
       "  expected a comparison with a text: time.method == 'TEXT'"},
      {"contact.friction == \"euler\"",
       "sweep.toml:3:29: the text \"euler\" is compared with no text\n"
       "  expected it beside == or != and the name of a text"},
      {"1 + time.method == \"euler\"",
       "sweep.toml:3:13: \"time.method\" is a text\n  expected a comparison with a text: "
       "time.method == 'TEXT'"},
      {"1 == \"a", "sweep.toml:3:14: the text has no closing quote\n  expected \" at its end"},
      {"contact.friction ! 1",
       "sweep.toml:3:26: unexpected \"!\" behind a value\n"
       "  expected != to compare, or ! before a condition"},
      {"(1).x",
       "sweep.toml:3:12: nothing here has a part .x\n"
       "  expected .x, .y, .z or .length only behind a vector"}};
  for (const auto& [text, message] : errors) EXPECT_EQ(error_of(text), message) << text;
  EXPECT_EQ(error_of(std::string(2001, '1')),
            "sweep.toml:3:9: the expression has 2001 bytes\n  expected at most 2000");
}

TEST(Expression, SaysWhichCharacterOfAnOverrideIsWrong) {
  try {
    const Expression expression({"1 + b", {"--set outputs.a=1 + b"}}, {});
    FAIL() << "no error";
  } catch (const CaseError& error) {
    EXPECT_STREQ(error.what(),
                 "--set outputs.a=1 + b: unknown name \"b\" (character 5 of \"1 + b\")\n"
                 "  expected one of \"pi\", \"true\", \"false\"");
  }
}

// The longest expressions are still within the limits of muParser.
TEST(Expression, ReadsLongExpressions) {
  std::vector<ExpressionVariable> variables;
  for (int i = 0; i < 1000; ++i) variables.push_back({"b" + std::to_string(i)});
  variables.push_back({"a"});
  std::string text = "a";
  while (text.size() + 2 <= 2000) text += "+a";
  const std::vector<double> ones(variables.size(), 1);
  EXPECT_EQ(value_of(text, variables, ones), static_cast<double>(text.size() + 1) / 2);
  EXPECT_EQ(value_of(std::string(999, '(') + "a" + std::string(999, ')'), variables, ones), 1);
}

TEST(LocatedText, FollowsEscapesAndLines) {
  const auto places = [](const std::string& text, const std::string& source) {
    std::string result;
    for (const auto& [line, column] : located_text(text, {"f", 1, 1}, source).places)
      result += std::to_string(line) + ':' + std::to_string(column) + ' ';
    return result;
  };
  EXPECT_EQ(places("ab", "\"ab\""), "1:2 1:3 1:4 ");
  EXPECT_EQ(places("ab", "'ab'"), "1:2 1:3 1:4 ");
  EXPECT_EQ(places("a\"b", "\"a\\\"b\""), "1:2 1:3 1:5 1:6 ");
  EXPECT_EQ(places("\xC3\xA4"
                   "b",
                   "\"\\u00e4b\""),
            "1:2 1:2 1:8 1:9 ");
  EXPECT_EQ(places("\xC3\xA4"
                   "b",
                   "\"\xC3\xA4"
                   "b\""),
            "1:2 1:2 1:3 1:4 ");
  EXPECT_EQ(places("a\nb", "\"\"\"\na\nb\"\"\""), "2:1 2:2 3:1 3:2 ");
  EXPECT_EQ(places("ab", "'''ab'''"), "1:4 1:5 1:6 ");
  EXPECT_EQ(places("ab", "\"\"\"a\\\n   b\"\"\""), "1:4 2:4 2:5 ");
}

TEST(LocatedText, KnowsNoPlacesInOtherTexts) {
  EXPECT_TRUE(located_text("a", {"--set a"}, "'a'").places.empty());
  EXPECT_TRUE(located_text("a", {"f", 1, 1}, "'a").places.empty());
  EXPECT_TRUE(located_text("a", {"f", 1, 1}, "12").places.empty());
  EXPECT_TRUE(located_text("a", {"f", 9, 1}, "'a'").places.empty());
  EXPECT_TRUE(located_text("a", {"f", 1, 99}, "'a'").places.empty());
  EXPECT_TRUE(located_text("abc", {"f", 1, 1}, "'a'").places.empty());
}

}  // namespace

}  // namespace weft::sim::expression_test
