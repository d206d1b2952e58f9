// Values of factors: text in TOML, and numbers.
#pragma once

#include <optional>
#include <string>

#include "sim/case/case_schema.h"

namespace weft::sim {

// Returns a TOML value for people and tables: a string without its quotes, anything else as it is.
std::string plain_text(const std::string& toml);

// Returns the number of a TOML value; 1 or 0 for a boolean; nothing for other values.
std::optional<double> number_of(const std::string& toml);

// Returns the value of a unit coordinate: between `least` and `most`, evenly or in the logarithm.
// Rounded to ten digits, which hides the last bits of exp() and log(), so that it is the same on
// every machine.
double uniform_value(double least, double most, double coordinate);
double log_uniform_value(double least, double most, double coordinate);

// Returns the whole number of a unit coordinate: each number from `least` to `most` is equally
// probable, or has the share of the logarithm from itself to the next. Preconditions: both are
// whole numbers, and `least` > 0 for the logarithm.
double uniform_whole(double least, double most, double coordinate);
double log_uniform_whole(double least, double most, double coordinate);

// Returns value `index` of `count` values that lie evenly from `first` to `last`, rounded to ten
// digits except for the ends.
double range_value(double first, double last, int count, int index);

}  // namespace weft::sim
