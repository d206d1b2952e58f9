// How outputs of a sweep depend on its factors: correlations and plots.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/sweep/summary.h"

namespace weft::sim {

// Returns Pearson's correlation of x and y: their covariance over the root of the product of their
// variances. Returns nothing for fewer than two pairs, or if x or y is constant. Precondition: x
// and y are finite and of one size.
std::optional<double> pearson_correlation(std::span<const double> x, std::span<const double> y);

// Returns Spearman's correlation: Pearson's of the ranks, where equal values share the mean of
// their ranks. Returns nothing as pearson_correlation() does.
std::optional<double> spearman_correlation(std::span<const double> x, std::span<const double> y);

// The correlation of an output with a factor, over the runs that are done and have the output.
struct Correlation {
  std::string output, factor;
  int runs = 0;     // runs that count
  int missing = 0;  // runs of the summary that do not
  std::optional<double> pearson, spearman;
  std::string note;  // reason for a missing correlation, in words; else empty
};

// Returns the correlations of each output with each factor, in the order of the summary. A boolean
// counts as 0 or 1. Texts have no correlation.
std::vector<Correlation> correlations_of(const Summary& summary);
// Returns the table as comma-separated values: output, factor, runs, missing, pearson, spearman and
// note. Correlations have six digits.
std::string correlations_csv(const std::vector<Correlation>& correlations);

// Writes `folder`/correlations.csv, and a plot of each output against each factor,
// `folder`/plots/OUTPUT-FACTOR.svg. Texts are numbered in the order of their first runs. The axis
// tells the number of each, or of the first and the last one if they are more than twelve. A pair
// without any value has no plot; correlations.csv says so. Removes other plots of Weft from
// `folder`/plots, which are those of earlier outputs; SVG files of others stay. Throws FileError.
void write_plots(const Summary& summary, const std::filesystem::path& folder);

}  // namespace weft::sim
