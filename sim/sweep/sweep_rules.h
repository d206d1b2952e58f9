// The rules of a sweep, which leave out combinations of values.
#pragma once

#include <string>
#include <vector>

#include "sim/expression/expression.h"
#include "sim/sweep/sweep_case.h"

namespace weft::sim {

// A factor as the variable of a rule.
struct RuleFactor {
  std::string key;
  bool is_text = false;  // all of its values are strings
};

class SweepRules {
 public:
  // Reads the rules sample.include and sample.exclude. Throws CaseError at the character of a rule
  // that is at fault.
  SweepRules(const SweepCase& sweep, const std::vector<RuleFactor>& factors);

  // True if all rules of `include` hold and none of `exclude`. `values` are TOML, one per factor. A
  // value that is neither a number, a boolean nor a string counts as not a number.
  bool keep(const std::vector<std::string>& values) const;

 private:
  std::vector<RuleFactor> factors_;
  std::vector<Expression> include_, exclude_;
};

}  // namespace weft::sim
