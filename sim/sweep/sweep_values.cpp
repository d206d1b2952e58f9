#include "sim/sweep/sweep_values.h"

#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "sim/case/case_text.h"

namespace weft::sim {

namespace {

// Values are computed in more digits than a double has where the machine has such numbers.
using Wide = long double;

constexpr int digits_of_double = 17;

// Returns the decimal number of the fewest digits, at least `digits`, that differs from `value` by
// at most `distance`; or the double that is nearest to `value`.
double short_decimal(Wide value, int digits, Wide distance) {
  const auto nearest = static_cast<double>(value);
  for (; digits < digits_of_double; ++digits) {
    std::array<char, 32> buffer{};
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), nearest,
                                   std::chars_format::scientific, digits - 1)
                         .ptr;
    double result = nearest;
    std::from_chars(buffer.data(), end, result);
    if (std::abs(result - value) <= distance) return result;
  }
  return nearest;
}

// Returns four units in the last place of a double.
Wide four_ulps(Wide value) {
  const double size = std::abs(static_cast<double>(value));
  return 4 * (static_cast<Wide>(std::nextafter(size, HUGE_VAL)) - size);
}

// Returns a sample as a decimal number of ten digits, or of more if that would move it by more than
// a billionth of `width`, the width of the distribution there.
double rounded_sample(Wide value, Wide width) { return short_decimal(value, 10, 1e-9L * width); }

// Returns the whole number below a value whose last bits may be wrong.
double whole_below(Wide value) { return std::floor(short_decimal(value, 1, four_ulps(value))); }

// Returns the decimal number that a double is written as.
Wide as_written(double value) { return std::strtold(number_text(value).c_str(), nullptr); }

}  // namespace

std::string plain_text(const std::string& toml) {
  if (!toml.starts_with('"')) return toml;
  const toml::table document = toml::parse("value = " + toml);
  return document["value"].value_or(std::string());
}

std::optional<double> number_of(const std::string& toml) {
  if (toml == "true") return 1;
  if (toml == "false") return 0;
  double value = 0;
  const char* end = toml.data() + toml.size();
  const auto [stop, error] = std::from_chars(toml.data(), end, value);
  if (error != std::errc() || stop != end) return std::nullopt;
  return value;
}

double uniform_value(double least, double most, double coordinate) {
  const Wide width = static_cast<Wide>(most) - least;
  return std::clamp(rounded_sample(least + width * coordinate, width), least, most);
}

double log_uniform_value(double least, double most, double coordinate) {
  const Wide width = std::log(static_cast<Wide>(most) / least);
  const Wide value = least * std::exp(coordinate * width);
  return std::clamp(rounded_sample(value, value * width), least, most);
}

double uniform_whole(double least, double most, double coordinate) {
  const Wide width = static_cast<Wide>(most) - least + 1;
  return std::clamp(whole_below(least + width * coordinate), least, most);
}

double log_uniform_whole(double least, double most, double coordinate) {
  const Wide width = std::log((static_cast<Wide>(most) + 1) / least);
  return std::clamp(whole_below(least * std::exp(coordinate * width)), least, most);
}

double range_value(double first, double last, int count, int index) {
  if (index == 0) return first;
  if (index == count - 1) return last;
  const Wide begin = as_written(first), end = as_written(last);
  const Wide value = begin + (end - begin) * index / (count - 1);
  const Wide quarter_step = std::abs(end - begin) / (count - 1) / 4;
  const bool cancels = std::abs(value) < 1e-18L * std::max(std::abs(begin), std::abs(end));
  return cancels ? 0 : short_decimal(value, 1, std::min(four_ulps(value), quarter_step));
}

}  // namespace weft::sim
