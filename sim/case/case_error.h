// The exception for bad user input. It is thrown only while a case is loaded and its scene is
// built.
#pragma once

#include <stdexcept>
#include <string>

#include "sim/case/case.h"

namespace weft::sim {

// Returns the place as `file:line:col`, or as `file` if the line is 0.
std::string place_text(const SourceLocation& where);

// An error in a case. what() is `file:line:col: message`, and the hint, if any, on the next line.
class CaseError : public std::runtime_error {
 public:
  CaseError(const SourceLocation& where, const std::string& message, const std::string& hint = "");
  const SourceLocation& where() const { return where_; }

 private:
  SourceLocation where_;
};

}  // namespace weft::sim
