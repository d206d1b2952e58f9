// Tables of coloured cells as an SVG file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace weft::sim {

struct HeatPanel {
  std::string title;
  std::string x_title, y_title;
  std::vector<std::string> x_labels, y_labels;  // y_labels: empty for none
  std::vector<int> cells;  // classes, row by row from the bottom; a row has one per x_label
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

// Writes the map as an SVG file. Throws FileError, naming the path.
void write_svg(const HeatMap& map, const std::filesystem::path& path);

}  // namespace weft::sim
