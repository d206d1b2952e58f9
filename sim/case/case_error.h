// The one exception for bad user input, thrown only while a case is loaded and its scene built.
#pragma once

#include <stdexcept>
#include <string>

#include "sim/case/case.h"

namespace weft::sim {

// `file:line:col` of the parts that are known.
std::string place_text(const SourceLocation& where);

// what() reads `file:line:col: message` with the hint, if any, on the next line.
class CaseError : public std::runtime_error {
 public:
  CaseError(const SourceLocation& where, const std::string& message, const std::string& hint = "");
  const SourceLocation& where() const { return where_; }

 private:
  SourceLocation where_;
};

}  // namespace weft::sim
