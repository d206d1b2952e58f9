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
// every machine. Samples from a narrow interval have more digits: rounding moves none by more than
// a billionth of the interval, or of its logarithm.
double uniform_value(double least, double most, double coordinate);
double log_uniform_value(double least, double most, double coordinate);

// Returns the whole number of a unit coordinate: each number from `least` to `most` is equally
// probable, or has the share of the logarithm from itself to the next. Preconditions: both are
// whole numbers, and `least` > 0 for the logarithm.
double uniform_whole(double least, double most, double coordinate);
double log_uniform_whole(double least, double most, double coordinate);

// Returns value `index` of `count` values that lie evenly from `first` to `last`: the decimal
// number of the fewest digits that differs from it by at most four units in the last place and by
// at most a quarter of the distance of two values.
double range_value(double first, double last, int count, int index);

}  // namespace weft::sim
