#include "sim/sweep/correlation.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <unordered_map>

#include "sim/base/file_error.h"
#include "sim/case/case_text.h"
#include "sim/view/plot.h"

namespace weft::sim {

namespace {

namespace fs = std::filesystem;

// Values of a factor and an output in the runs that have both.
struct Points {
  std::vector<double> x, y;
  std::vector<std::string> texts;  // of a factor that is a text: text i has the number i + 1
  std::unordered_map<std::string, std::size_t> numbers_of_texts;
  int missing = 0;
};

double coordinate_of(const FactorValue& value, Points& points) {
  if (value.number) return *value.number;
  const auto [found, is_new] = points.numbers_of_texts.emplace(value.text, points.texts.size() + 1);
  if (is_new) points.texts.push_back(value.text);
  return static_cast<double>(found->second);
}

Points points_of(const Summary& summary, std::size_t output, std::size_t factor) {
  Points points;
  for (const SummaryRow& row : summary.rows) {
    const double x = coordinate_of(row.factors[factor], points);
    const double y = row.outputs[output];
    if (row.status != "done" || !std::isfinite(y) || !std::isfinite(x)) {
      ++points.missing;
      continue;
    }
    points.x.push_back(x);
    points.y.push_back(y);
  }
  return points;
}

bool is_constant(std::span<const double> values) {
  return std::ranges::all_of(values, [&](double value) { return value == values.front(); });
}

// Returns the ranks from 1; equal values share the mean of their ranks.
std::vector<double> ranks_of(std::span<const double> values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return values[i]; });
  std::vector<double> ranks(values.size());
  for (std::size_t first = 0; first < order.size();) {
    std::size_t last = first;
    while (last + 1 < order.size() && values[order[last + 1]] == values[order[first]]) ++last;
    for (std::size_t i = first; i <= last; ++i)
      ranks[order[i]] = 1 + 0.5 * static_cast<double>(first + last);
    first = last + 1;
  }
  return ranks;
}

// Returns the reason why the points have no correlation, or an empty text.
std::string reason_against(const Points& points) {
  if (points.x.empty()) return "no run has a value";
  if (!points.texts.empty()) return "the factor is a text, which has no order";
  if (points.x.size() < 3) return "fewer than three runs have values";
  if (is_constant(points.y)) return "the output is constant";
  if (is_constant(points.x)) return "the factor is constant";
  return "";
}

// Returns an axis that is logarithmic if all values are positive and span a factor of thirty.
PlotAxis axis_of(const std::string& title, const std::vector<double>& values) {
  const auto [least, most] = std::ranges::minmax(values);
  return {title, least > 0 && most > 30 * least};
}

std::string name_of_plot(const Correlation& pair) {
  return pair.output + '-' + pair.factor + ".svg";
}

// Returns ": 1 = cvode, 2 = euler", or an empty text for a factor of numbers. Of many texts it has
// the first and the last one.
std::string key_of_texts(const std::vector<std::string>& texts) {
  constexpr std::size_t most = 12;
  std::string key;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const bool is_left_out = texts.size() > most && 0 < i && i + 1 < texts.size();
    if (is_left_out && i > 1) continue;
    key +=
        (i == 0 ? ": " : ", ") + (is_left_out ? "..." : std::to_string(i + 1) + " = " + texts[i]);
  }
  return key;
}

Plot plot_of(const Correlation& pair, const Points& points) {
  Plot plot;
  plot.title = pair.output + " by " + pair.factor;
  plot.note = counted(pair.runs, "run", "runs");
  if (pair.missing > 0) plot.note += ", " + std::to_string(pair.missing) + " without a value";
  if (pair.pearson) {
    plot.note += "; correlation " + rounded_text(*pair.pearson) + " (Pearson), " +
                 rounded_text(*pair.spearman) + " (Spearman)";
  } else {
    plot.note += "; no correlation: " + pair.note;
  }
  plot.x = axis_of(pair.factor + key_of_texts(points.texts), points.x);
  plot.y = axis_of(pair.output, points.y);
  if (!points.texts.empty()) plot.x.logarithmic = false;
  plot.series.push_back({.name = "runs", .x = points.x, .y = points.y, .line = false});
  return plot;
}

std::string optional_number(const std::optional<double>& value) {
  return value ? rounded_text(*value) : "";
}

// Removes the charts of Weft that are not among `kept`, and leaves SVG files of others.
void remove_other_plots(const fs::path& folder, const std::set<std::string>& kept) {
  std::error_code failure;
  std::vector<fs::path> others;
  for (const auto& entry : fs::directory_iterator(folder, failure)) {
    const fs::path& path = entry.path();
    if (path.extension() == ".svg" && !kept.contains(path.filename().string()) && is_own_svg(path))
      others.push_back(path);
  }
  for (const fs::path& path : others) {
    if (!fs::remove(path, failure) && failure)
      throw FileError(path.string() + ": cannot be removed: " + failure.message());
  }
}

}  // namespace

std::optional<double> pearson_correlation(std::span<const double> x, std::span<const double> y) {
  if (x.size() < 2 || is_constant(x) || is_constant(y)) return std::nullopt;
  const auto count = static_cast<double>(x.size());
  const double mean_x = std::accumulate(x.begin(), x.end(), 0.0) / count;
  const double mean_y = std::accumulate(y.begin(), y.end(), 0.0) / count;
  // Deviations are taken relative to the largest one, so that no square overflows or vanishes.
  double scale_x = 0, scale_y = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    scale_x = std::max(scale_x, std::abs(x[i] - mean_x));
    scale_y = std::max(scale_y, std::abs(y[i] - mean_y));
  }
  double xx = 0, yy = 0, xy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double dx = (x[i] - mean_x) / scale_x, dy = (y[i] - mean_y) / scale_y;
    xx += dx * dx;
    yy += dy * dy;
    xy += dx * dy;
  }
  return std::clamp(xy / std::sqrt(xx * yy), -1.0, 1.0);
}

std::optional<double> spearman_correlation(std::span<const double> x, std::span<const double> y) {
  return pearson_correlation(ranks_of(x), ranks_of(y));
}

std::vector<Correlation> correlations_of(const Summary& summary) {
  std::vector<Correlation> result;
  for (std::size_t o = 0; o < summary.outputs.size(); ++o) {
    for (std::size_t f = 0; f < summary.factors.size(); ++f) {
      const Points points = points_of(summary, o, f);
      Correlation& pair = result.emplace_back();
      pair.output = summary.outputs[o];
      pair.factor = summary.factors[f];
      pair.runs = static_cast<int>(points.x.size());
      pair.missing = points.missing;
      pair.note = reason_against(points);
      if (!pair.note.empty()) continue;
      pair.pearson = pearson_correlation(points.x, points.y);
      pair.spearman = spearman_correlation(points.x, points.y);
    }
  }
  return result;
}

std::string correlations_csv(const std::vector<Correlation>& correlations) {
  std::string text = "output,factor,runs,missing,pearson,spearman,note\n";
  for (const Correlation& pair : correlations) {
    text += pair.output + ',' + pair.factor + ',' + std::to_string(pair.runs) + ',' +
            std::to_string(pair.missing) + ',' + optional_number(pair.pearson) + ',' +
            optional_number(pair.spearman) + ',' +
            (pair.note.find(',') == std::string::npos ? pair.note : '"' + pair.note + '"') + '\n';
  }
  return text;
}

void write_plots(const Summary& summary, const fs::path& folder) {
  const std::vector<Correlation> correlations = correlations_of(summary);
  write_text(correlations_csv(correlations), folder / "correlations.csv");
  std::set<std::string> names;
  for (std::size_t i = 0; i < correlations.size(); ++i) {
    const Correlation& pair = correlations[i];
    if (pair.runs == 0) continue;
    const Points points =
        points_of(summary, i / summary.factors.size(), i % summary.factors.size());
    write_svg(plot_of(pair, points), folder / "plots" / name_of_plot(pair));
    names.insert(name_of_plot(pair));
  }
  remove_other_plots(folder / "plots", names);
}

}  // namespace weft::sim
