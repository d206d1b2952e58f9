#include "sim/sweep/sweep_values.h"

#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

namespace weft::sim {

namespace {

// Returns the decimal number of ten digits that is nearest to `value`.
double rounded(double value) {
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                 std::chars_format::scientific, 9)
                       .ptr;
  double result = value;
  std::from_chars(buffer.data(), end, result);
  return result;
}

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
  return std::clamp(rounded(least + (most - least) * coordinate), least, most);
}

double log_uniform_value(double least, double most, double coordinate) {
  return std::clamp(rounded(least * std::exp(coordinate * std::log(most / least))), least, most);
}

double uniform_whole(double least, double most, double coordinate) {
  return std::clamp(std::floor(rounded(least + (most - least + 1) * coordinate)), least, most);
}

double log_uniform_whole(double least, double most, double coordinate) {
  const double value = least * std::exp(coordinate * std::log((most + 1) / least));
  return std::clamp(std::floor(rounded(value)), least, most);
}

double range_value(double first, double last, int count, int index) {
  if (index == 0) return first;
  if (index == count - 1) return last;
  return rounded(first + (last - first) * index / (count - 1));
}

}  // namespace weft::sim
