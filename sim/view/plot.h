// Line charts as SVG files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace weft::sim {

struct PlotSeries {
  std::string name;
  std::vector<double> x, y;  // of equal length; positive on logarithmic axes
  bool line = true;          // false: marks alone
  bool dashed = false;
};

struct PlotAxis {
  std::string title;  // with its unit
  bool logarithmic = true;
};

struct Plot {
  std::string title;
  std::string note;  // one line below the title
  PlotAxis x, y;
  std::vector<PlotSeries> series;
};

// Returns the chart as SVG text. At least one series must have a point.
std::string svg_of(const Plot& plot);

// Writes the chart as an SVG file. Throws FileError that names the path.
void write_svg(const Plot& plot, const std::filesystem::path& path);

// Returns the text escaped for SVG.
std::string escaped(const std::string& text);

// Writes text to a file, after creating its folder if needed. Throws FileError that names the path.
void write_text(const std::string& text, const std::filesystem::path& path);

}  // namespace weft::sim
