#include "sim/case/case_error.h"

namespace weft::sim {

namespace {

// Returns `file:line:column: message`, and the hint on its own line. Empty parts are left out.
std::string format(const SourceLocation& where, const std::string& message,
                   const std::string& hint) {
  std::string text = place_text(where);
  if (!text.empty()) text += ": ";
  text += message;
  if (!hint.empty()) text += "\n  " + hint;
  return text;
}

}  // namespace

std::string place_text(const SourceLocation& where) {
  if (where.line == 0) return where.file;
  return where.file + ':' + std::to_string(where.line) + ':' + std::to_string(where.column);
}

CaseError::CaseError(const SourceLocation& where, const std::string& message,
                     const std::string& hint)
    : std::runtime_error(format(where, message, hint)), where_(where) {}

}  // namespace weft::sim
