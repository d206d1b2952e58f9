// The exception for mistakes in a case or in the options of a command on a case.
#pragma once

#include <stdexcept>
#include <string>

#include "sim/case/case.h"

namespace weft::sim {

// Returns the place as `file:line:column`, or as `file` if the line is 0.
std::string place_text(const SourceLocation& where);

// An error in a case. what() is the place, ": " and the message, followed by the hint, if any, on
// the next line.
class CaseError : public std::runtime_error {
 public:
  CaseError(const SourceLocation& where, const std::string& message, const std::string& hint = "");
  const SourceLocation& where() const { return where_; }

 private:
  SourceLocation where_;
};

}  // namespace weft::sim
