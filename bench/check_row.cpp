#include "bench/check_row.h"

#include <algorithm>
#include <cstdio>

#include "sim/view/plot.h"

namespace weft::bench {

namespace {

std::string image_of(const CheckRow& row) {
  std::string text;
  for (const int each : row.resolution) text += (text.empty() ? "" : " x ") + std::to_string(each);
  return text;
}

std::string percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g %%", 100 * share);
  return text;
}

std::string limit_of(const CheckRow& row) {
  switch (row.bound) {
    case Bound::error:
      return percent(row.limit);
    case Bound::at_most:
      return "at most";
    case Bound::wanted:
      return "at least";
    case Bound::none:
    case Bound::reported:
      break;
  }
  return "-";
}

std::string number_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

const char* remark_on(const CheckRow& row) {
  if (row.bound == Bound::wanted && row.value < row.reference) return "  less than wanted";
  return row.holds() ? "" : "  beyond its limit";
}

}  // namespace

nlohmann::json json_of(const CheckRow& row) {
  nlohmann::json json{{"check", row.check},   {"case", nullptr},    {"resolution", row.resolution},
                      {"value", nullptr},     {"error", nullptr},   {"limit", nullptr},
                      {"reference", nullptr}, {"cpu_s", row.cpu_s}, {"source", nullptr},
                      {"quantity", nullptr}};
  if (!row.case_path.empty()) json["case"] = row.case_path;
  if (row.bound == Bound::error) json["limit"] = row.limit;
  if (row.bound == Bound::at_most) json["limit"] = 0;
  if (!row.failure.empty()) {
    json[row.skipped ? "skipped" : "failure"] = row.failure;
    return json;
  }
  json["quantity"] = row.quantity;
  json["value"] = row.value;
  if (row.bound != Bound::reported) json["reference"] = row.reference;
  if (row.has_error()) json["error"] = row.error();
  if (row.bound == Bound::wanted) json["bound"] = "at least, wanted";
  if (row.bound == Bound::at_most) json["bound"] = "at most";
  json["source"] = row.source;
  return json;
}

void print_heading(const char* what) {
  std::printf("%-50s %-11s %-21s %12s %12s %11s %9s %9s\n", what, "image", "quantity", "value",
              "reference", "error", "limit", "cpu_s");
}

void print_row(const CheckRow& row) {
  std::printf("%-50s %-11s ", row.check.c_str(), image_of(row).c_str());
  if (!row.failure.empty()) {
    std::printf("%s\n", row.failure.c_str());
    return;
  }
  char error[32] = "-";
  if (row.has_error()) std::snprintf(error, sizeof error, "%.4f %%", 100 * row.error());
  const std::string reference = row.bound == Bound::reported ? "-" : number_of(row.reference);
  std::printf("%-21s %12.6g %12s %11s %9s %9.3f%s\n", row.quantity.c_str(), row.value,
              reference.c_str(), error, limit_of(row).c_str(), row.cpu_s, remark_on(row));
}

void write_convergence(const std::vector<CheckRow>& rows, const std::filesystem::path& directory) {
  std::vector<std::string> charts;
  for (const CheckRow& row : rows) {
    if (!row.chart.empty() && std::ranges::find(charts, row.chart) == charts.end())
      charts.push_back(row.chart);
  }
  for (const std::string& chart : charts) {
    sim::Plot plot{"Error against control points: " + chart,
                   "weft bench shells",
                   {"control points, or vertices of cloth"},
                   {"relative error"},
                   {}};
    for (const CheckRow& row : rows) {
      if (row.chart != chart || !row.failure.empty() || !row.has_error() || row.error() == 0)
        continue;
      if (plot.series.empty() || plot.series.back().name != row.check)
        plot.series.push_back({row.check, {}, {}});
      plot.series.back().x.push_back(row.points);
      plot.series.back().y.push_back(row.error());
    }
    if (!plot.series.empty()) sim::write_svg(plot, directory / ("shells_" + chart + ".svg"));
  }
}

}  // namespace weft::bench
