// Text of JSON objects for standard output.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace weft::sim {

// Returns the object as text, indented by two spaces. Bytes that are not UTF-8 become the
// replacement character U+FFFD. The control characters U+007F to U+009F are escaped: JSON allows
// them, but terminals obey them.
inline std::string json_text(const nlohmann::ordered_json& object) {
  const std::string raw = object.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
  constexpr const char* digits = "0123456789abcdef";
  std::string text;
  text.reserve(raw.size());
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const auto code = static_cast<unsigned char>(raw[i]);
    const bool upper = code == 0xc2 && i + 1 < raw.size() && (raw[i + 1] & 0x60) == 0;
    if (upper) ++i;
    if (upper || code == 0x7f) {
      const auto control = static_cast<unsigned char>(raw[i]);
      text += std::string("\\u00") + digits[control / 16] + digits[control % 16];
    } else {
      text += raw[i];
    }
  }
  return text;
}

}  // namespace weft::sim
