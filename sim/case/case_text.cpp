#include "sim/case/case_text.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdio>

namespace weft::sim {

namespace {

// Length (bytes) of the longest text that in_quotes() does not cut.
constexpr std::size_t longest_quote = 160;
// Length (bytes) of the longest text for which a near name is looked for. The search takes time and
// memory in proportion to the product of two lengths, and no one misspells a longer name.
constexpr std::size_t longest_name = 1000;

char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

// Returns the optimal string alignment distance of two texts, ignoring case. Insertion, deletion,
// replacement and the swap of two neighbours cost 1 each.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  const std::size_t width = b.size() + 1;
  std::vector<std::size_t> table((a.size() + 1) * width);
  const auto at = [&](std::size_t i, std::size_t j) -> std::size_t& {
    return table[i * width + j];
  };
  for (std::size_t i = 0; i <= a.size(); ++i) at(i, 0) = i;
  for (std::size_t j = 0; j <= b.size(); ++j) at(0, j) = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const bool same = lower(a[i - 1]) == lower(b[j - 1]);
      at(i, j) = std::min({at(i - 1, j) + 1, at(i, j - 1) + 1, at(i - 1, j - 1) + (same ? 0 : 1)});
      const bool swapped = i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) &&
                           lower(a[i - 2]) == lower(b[j - 1]);
      if (swapped) at(i, j) = std::min(at(i, j), at(i - 2, j - 2) + 1);
    }
  }
  return at(a.size(), b.size());
}

// Returns the length (bytes) of the UTF-8 sequence at `start`, or 0 if there is no valid one.
std::size_t utf8_length(const std::string& text, std::size_t start) {
  const auto byte = [&](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U;
  };
  const unsigned first = byte(start);
  if (first < 0x80) return 1;
  const std::size_t length = first < 0xc2 ? 0 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
  if (length == 0 || first > 0xf4) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(start + i) & 0xc0U) != 0x80) return 0;
  }
  const unsigned second = byte(start + 1);
  const bool too_long = (first == 0xe0 && second < 0xa0) || (first == 0xf0 && second < 0x90);
  const bool no_character = (first == 0xed && second >= 0xa0) || (first == 0xf4 && second >= 0x90);
  return too_long || no_character ? 0 : length;
}

std::string escape_of(unsigned char code) {
  if (code == '\n') return "\\n";
  if (code == '\t') return "\\t";
  if (code == '\r') return "\\r";
  constexpr const char* digits = "0123456789abcdef";
  return std::string("\\x") + digits[code / 16] + digits[code % 16];
}

}  // namespace

std::string printable(const std::string& text, bool keep_lines) {
  std::string result;
  result.reserve(text.size());
  for (std::size_t i = 0; i < text.size();) {
    const auto code = static_cast<unsigned char>(text[i]);
    const std::size_t length = utf8_length(text, i);
    // The UTF-8 sequences of the control characters U+0080 to U+009F begin with byte 0xc2.
    const bool upper_control = code == 0xc2 && length == 2 && (text[i + 1] & 0x60) == 0;
    const bool control = code < 0x20 || code == 0x7f || upper_control;
    if (length > 0 && (!control || (keep_lines && code == '\n'))) {
      result.append(text, i, length);
    } else {
      for (std::size_t j = 0; j < std::max<std::size_t>(1, length); ++j) {
        result += escape_of(static_cast<unsigned char>(text[i + j]));
      }
    }
    i += std::max<std::size_t>(1, length);
  }
  return result;
}

std::optional<std::string> nearest_name(const std::string& name,
                                        const std::vector<std::string>& candidates) {
  if (name.size() > longest_name) return std::nullopt;
  std::optional<std::string> best;
  std::size_t best_distance = 0;
  for (const std::string& candidate : candidates) {
    const std::size_t shorter = std::min(name.size(), candidate.size());
    const std::size_t longer = std::max(name.size(), candidate.size());
    const std::size_t most = std::max<std::size_t>(1, longer / 3);
    if (longer - shorter > most) continue;  // the distance is at least this difference
    const std::size_t distance = edit_distance(name, candidate);
    if (distance > most) continue;
    if (!best || distance < best_distance) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best;
}

std::string name_hint(const std::string& name, const std::vector<std::string>& candidates) {
  if (const auto nearest = nearest_name(name, candidates)) {
    return "did you mean " + in_quotes(*nearest) + "?";
  }
  if (candidates.empty()) return "there is none that could be named here";
  return "expected " + std::string(candidates.size() > 1 ? "one of " : "") +
         quoted_list(candidates);
}

std::string in_one_line(std::string text) {
  for (auto at = text.find('\n'); at != std::string::npos; at = text.find('\n', at)) {
    const auto next = std::min(text.find_first_not_of(" \n", at), text.size());
    text.replace(at, next - at, next < text.size() ? " | " : "");
  }
  return text;
}

std::string in_quotes(const std::string& text) {
  if (text.size() <= longest_quote) return '"' + printable(text) + '"';
  std::size_t end = longest_quote / 2;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0U) == 0x80) --end;
  return '"' + printable(text.substr(0, end)) + "...\" (" + std::to_string(text.size()) + " bytes)";
}

std::string quoted_list(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + in_quotes(name);
  return list;
}

std::string number_text(double value) {
  std::array<char, 32> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), result.ptr};
}

std::string rounded_text(double value) {
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.6g", value);
  return buffer.data();
}

std::string counted(std::int64_t count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

bool is_identifier(const std::string& name) {
  const auto allowed = [](unsigned char c) {
    return c < 128 && (std::isalnum(c) != 0 || c == '_' || c == '-');
  };
  return !name.empty() && std::all_of(name.begin(), name.end(), allowed);
}

}  // namespace weft::sim
