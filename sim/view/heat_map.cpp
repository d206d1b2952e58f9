#include "sim/view/heat_map.h"

#include <algorithm>
#include <cassert>
#include <sstream>

#include "sim/view/plot.h"

namespace weft::sim {

namespace {

// Sizes (pixels).
constexpr double margin = 24, header = 84, cell_width = 15, cell_height = 15;
constexpr double character = 5.4;  // mean width of a character (pixels)
constexpr double row_title = 24, panel_title = 16, between = 16;

std::size_t longest(const std::vector<std::string>& labels) {
  std::size_t length = 0;
  for (const std::string& label : labels) length = std::max(length, label.size());
  return length;
}

double length_of(const std::vector<std::string>& labels) {
  return character * static_cast<double>(longest(labels));
}

std::size_t rows_of(const HeatPanel& panel) { return panel.cells.size() / panel.x_labels.size(); }

// Returns the width (pixels) of the labels and the title at the left of the cells.
double label_width(const HeatPanel& panel) {
  return panel.y_labels.empty() ? 0
                                : length_of(panel.y_labels) + 8 + (panel.y_title.empty() ? 0 : 14);
}

double width_of(const HeatPanel& panel) {
  const double cells = cell_width * static_cast<double>(panel.x_labels.size());
  const double titles =
      character * static_cast<double>(std::max(panel.title.size(), panel.x_title.size()));
  return label_width(panel) + std::max(cells, titles) + between;
}

double height_of(const HeatPanel& panel) {
  return panel_title + cell_height * static_cast<double>(rows_of(panel)) +
         length_of(panel.x_labels) + 12 + (panel.x_title.empty() ? 0 : 16);
}

void draw_text(std::ostream& out, double x, double y, const std::string& style,
               const std::string& text) {
  out << "<text x=\"" << x << "\" y=\"" << y << "\" " << style << ">" << escaped(text)
      << "</text>\n";
}

void draw_turned(std::ostream& out, double x, double y, const std::string& anchor,
                 const std::string& text) {
  out << "<text transform=\"translate(" << x << ' ' << y << ") rotate(-90)\" text-anchor=\""
      << anchor << "\">" << escaped(text) << "</text>\n";
}

void draw_labels(std::ostream& out, const HeatPanel& panel, double left, double top,
                 double bottom) {
  const std::size_t columns = panel.x_labels.size();
  for (std::size_t i = 0; i < columns; ++i)
    draw_turned(out, left + (static_cast<double>(i) + 0.5) * cell_width + 3, bottom + 4, "end",
                panel.x_labels[i]);
  for (std::size_t j = 0; j < panel.y_labels.size(); ++j)
    draw_text(out, left - 4, bottom - (static_cast<double>(j) + 0.5) * cell_height + 3,
              "text-anchor=\"end\"", panel.y_labels[j]);
  if (!panel.x_title.empty())
    draw_text(out, left, bottom + length_of(panel.x_labels) + 20, "fill=\"#555555\"",
              panel.x_title);
  if (!panel.y_title.empty() && !panel.y_labels.empty())
    draw_turned(out, left - label_width(panel) + 10, 0.5 * (top + bottom), "middle", panel.y_title);
}

void draw_panel(std::ostream& out, const HeatMap& map, const HeatPanel& panel, double x, double y) {
  const double left = x + label_width(panel), top = y + panel_title;
  const double bottom = top + cell_height * static_cast<double>(rows_of(panel));
  draw_text(out, left, top - 5, "font-weight=\"bold\"", panel.title);
  const std::size_t columns = panel.x_labels.size();
  for (std::size_t i = 0; i < panel.cells.size(); ++i) {
    const std::size_t above = i / columns;
    const double column = static_cast<double>(i % columns), row = static_cast<double>(above);
    out << "<rect x=\"" << left + column * cell_width << "\" y=\""
        << bottom - (row + 1) * cell_height << "\" width=\"" << cell_width - 1 << "\" height=\""
        << cell_height - 1 << "\" fill=\""
        << map.classes[static_cast<std::size_t>(panel.cells[i])].colour << "\"/>\n";
  }
  draw_labels(out, panel, left, top, bottom);
}

void draw_header(std::ostream& out, const HeatMap& map) {
  draw_text(out, margin, 28, "font-size=\"16\" font-weight=\"bold\"", map.title);
  draw_text(out, margin, 46, "font-size=\"11\" fill=\"#555555\"", map.note);
  double x = margin;
  for (const HeatClass& each : map.classes) {
    out << "<rect x=\"" << x << "\" y=\"58\" width=\"13\" height=\"13\" fill=\"" << each.colour
        << "\"/>\n";
    draw_text(out, x + 19, 69, "font-size=\"12\"", each.name);
    x += 44 + 7 * static_cast<double>(each.name.size());
  }
}

}  // namespace

std::string svg_of(const HeatMap& map) {
  std::ostringstream body;
  draw_header(body, map);
  double y = header, width = 920;  // 920 pixels have room for the header
  for (const HeatRow& row : map.rows) {
    double x = margin, height = 0;
    draw_text(body, x, y + 14, "font-size=\"13\" font-weight=\"bold\"", row.title);
    y += row.title.empty() ? 0 : row_title;
    for (const HeatPanel& panel : row.panels) {
      assert(!panel.x_labels.empty() && panel.cells.size() % panel.x_labels.size() == 0);
      draw_panel(body, map, panel, x, y);
      x += width_of(panel);
      height = std::max(height, height_of(panel));
    }
    width = std::max(width, x + margin - between);
    y += height + 12;
  }
  std::ostringstream out;
  out << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << width << "\" height=\"" << y
      << "\" viewBox=\"0 0 " << width << ' ' << y
      << "\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"9.5\" fill=\"#222222\">\n"
      << "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
      << body.str() << "</svg>\n";
  return out.str();
}

void write_svg(const HeatMap& map, const std::filesystem::path& path) {
  write_text(svg_of(map), path);
}

}  // namespace weft::sim
