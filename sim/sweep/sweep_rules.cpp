#include "sim/sweep/sweep_rules.h"

#include <algorithm>
#include <limits>

#include "sim/case/located_text.h"
#include "sim/sweep/sweep_values.h"

namespace weft::sim {

SweepRules::SweepRules(const SweepCase& sweep, const std::vector<RuleFactor>& factors)
    : factors_(factors) {
  std::vector<ExpressionVariable> variables;
  for (const RuleFactor& factor : factors) variables.push_back({factor.key, factor.is_text});
  const auto read = [&](const std::vector<TomlValue>& rules, std::vector<Expression>& into) {
    for (const TomlValue& rule : rules) {
      into.emplace_back(located_text(plain_text(rule.text), rule.where, sweep.text), variables);
    }
  };
  read(sweep.sample.include, include_);
  read(sweep.sample.exclude, exclude_);
}

bool SweepRules::keep(const std::vector<std::string>& values) const {
  const auto holds = [&](const Expression& rule) {
    std::vector<double> numbers;
    for (std::size_t i = 0; i < values.size(); ++i) {
      constexpr double none = std::numeric_limits<double>::quiet_NaN();
      numbers.push_back(factors_[i].is_text ? rule.code_of(plain_text(values[i]))
                                            : number_of(values[i]).value_or(none));
    }
    return rule.holds(numbers);
  };
  return std::ranges::all_of(include_, holds) && std::ranges::none_of(exclude_, holds);
}

}  // namespace weft::sim
