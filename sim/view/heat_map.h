// Tables of coloured cells as SVG files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace weft::sim {

struct HeatPanel {
  std::string title;
  std::string x_title, y_title;
  std::vector<std::string> x_labels, y_labels;  // empty y_labels: none are drawn
  std::vector<int> cells;  // classes, row by row from the bottom; one per x_label and row
};

struct HeatRow {
  std::string title;
  std::vector<HeatPanel> panels;  // side by side
};

struct HeatClass {
  std::string name, colour;
};

struct HeatMap {
  std::string title, note;
  std::vector<HeatClass> classes;
  std::vector<HeatRow> rows;
};

std::string svg_of(const HeatMap& map);

// Writes the map as an SVG file. Throws FileError that names the path.
void write_svg(const HeatMap& map, const std::filesystem::path& path);

}  // namespace weft::sim
