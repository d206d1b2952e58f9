// Heat maps, which are tables of coloured cells, as SVG files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace weft::sim {

struct HeatPanel {
  std::string title;
  std::string x_title, y_title;
  // x_labels has one label per column, at least one. y_labels has one per row, or is empty.
  std::vector<std::string> x_labels, y_labels;
  std::vector<int> cells;  // indices into HeatMap::classes, row by row from the bottom
};

struct HeatRow {
  std::string title;
  std::vector<HeatPanel> panels;  // drawn side by side
};

struct HeatClass {
  std::string name, colour;
};

struct HeatMap {
  std::string title, note;
  std::vector<HeatClass> classes;
  std::vector<HeatRow> rows;
};

// Returns the map as SVG text.
std::string svg_of(const HeatMap& map);

// Writes the map to an SVG file. Throws FileError if the file cannot be written.
void write_svg(const HeatMap& map, const std::filesystem::path& path);

}  // namespace weft::sim
