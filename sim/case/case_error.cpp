#include "sim/case/case_error.h"

namespace weft::sim {

namespace {

// Builds `file:line:col: message` from the parts that are known, and puts the hint on its own line.
std::string format(const SourceLocation& where, const std::string& message,
                   const std::string& hint) {
  std::string text = where.file;
  if (where.line > 0) {
    text += ':' + std::to_string(where.line) + ':' + std::to_string(where.column);
  }
  if (!text.empty()) text += ": ";
  text += message;
  if (!hint.empty()) text += "\n  " + hint;
  return text;
}

}  // namespace

CaseError::CaseError(const SourceLocation& where, const std::string& message,
                     const std::string& hint)
    : std::runtime_error(format(where, message, hint)), where_(where) {}

}  // namespace weft::sim
