// Line charts as SVG files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace weft::sim {

struct PlotSeries {
  std::string name;
  std::vector<double> x, y;  // coordinates of the points; positive on logarithmic axes
  bool line = true;          // if true, a line joins the points
  bool dashed = false;
};

struct PlotAxis {
  std::string title;  // name and unit of the quantity
  bool logarithmic = true;
};

struct Plot {
  std::string title;
  std::string note;  // line of text below the title
  PlotAxis x, y;
  std::vector<PlotSeries> series;
};

// Returns the chart as SVG text. At least one series must have a point.
std::string svg_of(const Plot& plot);

// Writes the chart to an SVG file. Throws FileError if the file cannot be written.
void write_svg(const Plot& plot, const std::filesystem::path& path);

// True if the file at `path` is a chart that write_svg() made, by how it begins.
bool is_own_svg(const std::filesystem::path& path);

// Returns the text with '&' and '<' escaped for SVG.
std::string escaped(const std::string& text);

// Writes text to a file, and creates its folder if that is missing. Throws FileError if the file
// cannot be written.
void write_text(const std::string& text, const std::filesystem::path& path);

}  // namespace weft::sim
