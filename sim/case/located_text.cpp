#include "sim/case/located_text.h"

#include <optional>
#include <string_view>

namespace weft::sim {

namespace {

bool continues_character(char byte) { return (static_cast<unsigned char>(byte) & 0xC0) == 0x80; }

// Walks over the source of a TOML string, and lists the places of the bytes that it decodes to.
class StringWalk {
 public:
  StringWalk(std::string_view source, LocatedText::Place start) : source_(source), at_(start) {}

  // Returns the places of all bytes and of the end, or nothing if there is no complete string.
  std::optional<std::vector<LocatedText::Place>> places() {
    if (source_.empty() || (source_[0] != '"' && source_[0] != '\'')) return std::nullopt;
    quote_ = source_[0];
    has_lines_ = source_.substr(0, 3) == std::string(3, quote_);
    advance(has_lines_ ? 3 : 1);
    if (has_lines_) skip_line_end();
    while (!at_end()) {
      if (next_ >= source_.size()) return std::nullopt;
      if (quote_ == '"' && source_[next_] == '\\') {
        escape();
      } else {
        places_.push_back(at_);
        advance(1);
      }
    }
    places_.push_back(at_);
    return places_;
  }

 private:
  bool starts_with(std::string_view text) const { return source_.substr(next_).starts_with(text); }

  // True at the closing quotes. A string of several lines may end in one or two quotes of its own.
  bool at_end() const {
    if (!has_lines_) return starts_with(std::string(1, quote_));
    return starts_with(std::string(3, quote_)) && !starts_with(std::string(4, quote_));
  }

  void advance(std::size_t bytes) {
    for (; bytes > 0 && next_ < source_.size(); --bytes) {
      const char byte = source_[next_++];
      if (byte == '\n') {
        ++at_.line;
        at_.column = 1;
      } else if (next_ >= source_.size() || !continues_character(source_[next_])) {
        ++at_.column;
      }
    }
  }

  void skip_line_end() {
    if (starts_with("\r\n")) advance(1);
    if (starts_with("\n")) advance(1);
  }

  // Follows an escape: a backslash with a letter, with the digits of a character, or with the end
  // of a line, which stands for nothing.
  void escape() {
    const LocatedText::Place start = at_;
    const char letter = next_ + 1 < source_.size() ? source_[next_ + 1] : '\0';
    if (letter == ' ' || letter == '\t' || letter == '\r' || letter == '\n') {
      advance(1);
      const std::size_t end = source_.find_first_not_of(" \t\r\n", next_);
      advance((end == std::string_view::npos ? source_.size() : end) - next_);
      return;
    }
    const std::size_t digits = letter == 'u' ? 4 : letter == 'U' ? 8 : 0;
    const std::size_t bytes = digits > 0 ? encoded_size(source_.substr(next_ + 2, digits)) : 1;
    places_.insert(places_.end(), bytes, start);
    advance(2 + digits);
  }

  // Returns the number of bytes in UTF-8 of the character with these hexadecimal digits.
  static std::size_t encoded_size(std::string_view digits) {
    const unsigned long code = std::stoul("0" + std::string(digits), nullptr, 16);
    return code < 0x80 ? 1 : code < 0x800 ? 2 : code < 0x10000 ? 3 : 4;
  }

  std::string_view source_;
  LocatedText::Place at_;
  std::size_t next_ = 0;
  char quote_ = '"';
  bool has_lines_ = false;  // true if the string has three quotes
  std::vector<LocatedText::Place> places_;
};

// Returns the position of a place in a text, or npos if the text has no such place.
std::size_t position_of(const SourceLocation& place, const std::string& text) {
  std::size_t position = 0;
  for (int line = 1; line < place.line; ++line) {
    position = text.find('\n', position);
    if (position == std::string::npos) return position;
    ++position;
  }
  for (int column = 1; column < place.column; ++column) {
    do {
      if (position >= text.size()) return std::string::npos;
      ++position;
    } while (position < text.size() && continues_character(text[position]));
  }
  return position;
}

}  // namespace

LocatedText located_text(const std::string& text, const SourceLocation& location,
                         const std::string& file_text) {
  LocatedText result{text, location};
  if (location.line == 0) return result;
  const std::size_t start = position_of(location, file_text);
  if (start == std::string::npos) return result;
  const auto source = std::string_view(file_text).substr(start);
  auto places = StringWalk(source, {location.line, location.column}).places();
  if (places && places->size() == text.size() + 1) result.places = std::move(*places);
  return result;
}

}  // namespace weft::sim
