#include "sim/view/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <sstream>

#include "sim/base/file_error.h"

namespace weft::sim {

namespace {

constexpr double width = 820, height = 520;                      // size of the picture (pixels)
constexpr double left = 78, right = 190, top = 66, bottom = 58;  // margins (pixels)
constexpr double legend_x = width - right + 22;

// Colours of series, for readers with any colour vision (after Okabe and Ito).
constexpr std::array<const char*, 7> colours{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                             "#e69f00", "#56b4e9", "#444444"};

std::string text_of(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

// An axis: maps values to pixels from `begin` to `end`, and has ticks at round numbers.
class Scale {
 public:
  Scale(bool logarithmic, double low, double high, double begin, double end)
      : logarithmic_(logarithmic), begin_(begin), end_(end) {
    if (logarithmic) {
      low_ = std::floor(std::log10(low) + 1e-9);
      high_ = std::ceil(std::log10(high) - 1e-9);
      if (high_ <= low_) high_ = low_ + 1;
      const int decades = static_cast<int>(high_ - low_);
      for (int i = 0; i <= decades; ++i) ticks_.push_back(std::pow(10, low_ + i));
      return;
    }
    const double step = round_step((high > low ? high - low : 1) / 6);
    low_ = step * std::floor(low / step);
    high_ = step * std::max(std::ceil(high / step), std::floor(low / step) + 1);
    const int steps = static_cast<int>(std::lround((high_ - low_) / step));
    for (int i = 0; i <= steps; ++i) {
      const double tick = low_ + i * step;
      ticks_.push_back(std::abs(tick) < 1e-9 * step ? 0 : tick);
    }
  }

  double pixel(double value) const {
    const double t = ((logarithmic_ ? std::log10(value) : value) - low_) / (high_ - low_);
    return begin_ + t * (end_ - begin_);
  }
  const std::vector<double>& ticks() const { return ticks_; }
  // Returns the minor ticks, at 2 to 9 times each power of ten. Only a logarithmic axis of at most
  // six decades has minor ticks.
  std::vector<double> minor_ticks() const {
    std::vector<double> minor;
    if (!logarithmic_ || high_ - low_ > 6) return minor;
    for (std::size_t i = 0; i + 1 < ticks_.size(); ++i) {
      for (int k = 2; k < 10; ++k) minor.push_back(k * ticks_[i]);
    }
    return minor;
  }
  std::string label(double tick) const {
    if (!logarithmic_ || (tick > 9e-4 && tick < 9e3)) return text_of(tick);
    return "10<tspan dy=\"-5\" font-size=\"9\">" + text_of(std::round(std::log10(tick))) +
           "</tspan>";
  }

 private:
  static double round_step(double step) {
    const double decade = std::pow(10, std::floor(std::log10(step)));
    for (const double factor : {1.0, 2.0, 5.0}) {
      if (step <= factor * decade) return factor * decade;
    }
    return 10 * decade;
  }

  bool logarithmic_;
  double begin_, end_;
  double low_ = 0, high_ = 1;
  std::vector<double> ticks_;
};

Scale scale_of(const Plot& plot, const PlotAxis& axis, std::vector<double> PlotSeries::*values,
               double begin, double end) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const PlotSeries& series : plot.series) {
    for (const double value : series.*values) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  return {axis.logarithmic, low, high, begin, end};
}

// Returns the text with which all charts begin, and by which is_own_svg() knows them.
std::string beginning_of_charts() {
  std::ostringstream out;
  out << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << width << "\" height=\"" << height
      << "\" viewBox=\"0 0 " << width << ' ' << height
      << "\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"12\" fill=\"#222222\">\n"
      << "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
  return out.str();
}

void draw_line(std::ostream& out, double x1, double y1, double x2, double y2, const char* style) {
  out << "<line x1=\"" << text_of(x1) << "\" y1=\"" << text_of(y1) << "\" x2=\"" << text_of(x2)
      << "\" y2=\"" << text_of(y2) << "\" " << style << "/>\n";
}

void draw_frame(std::ostream& out, const Scale& x, const Scale& y) {
  constexpr const char* grid = "stroke=\"#dddddd\"";
  constexpr const char* fine = "stroke=\"#f1f1f1\"";
  for (const double tick : x.minor_ticks())
    draw_line(out, x.pixel(tick), top, x.pixel(tick), height - bottom, fine);
  for (const double tick : y.minor_ticks())
    draw_line(out, left, y.pixel(tick), width - right, y.pixel(tick), fine);
  for (const double tick : x.ticks()) {
    draw_line(out, x.pixel(tick), top, x.pixel(tick), height - bottom, grid);
    out << "<text x=\"" << text_of(x.pixel(tick)) << "\" y=\"" << height - bottom + 18
        << "\" text-anchor=\"middle\">" << x.label(tick) << "</text>\n";
  }
  for (const double tick : y.ticks()) {
    draw_line(out, left, y.pixel(tick), width - right, y.pixel(tick), grid);
    out << "<text x=\"" << left - 8 << "\" y=\"" << text_of(y.pixel(tick) + 4)
        << "\" text-anchor=\"end\">" << y.label(tick) << "</text>\n";
  }
  constexpr const char* edge = "stroke=\"#333333\"";
  draw_line(out, left, height - bottom, width - right, height - bottom, edge);
  draw_line(out, left, top, left, height - bottom, edge);
}

void draw_titles(std::ostream& out, const Plot& plot) {
  out << "<text x=\"" << left << "\" y=\"26\" font-size=\"16\" font-weight=\"bold\">"
      << escaped(plot.title) << "</text>\n"
      << "<text x=\"" << left << "\" y=\"46\" fill=\"#555555\">" << escaped(plot.note)
      << "</text>\n"
      << "<text x=\"" << 0.5 * (left + width - right) << "\" y=\"" << height - 16
      << "\" text-anchor=\"middle\">" << escaped(plot.x.title) << "</text>\n"
      << "<text transform=\"translate(20 " << 0.5 * (top + height - bottom)
      << ") rotate(-90)\" text-anchor=\"middle\">" << escaped(plot.y.title) << "</text>\n";
}

void draw_series(std::ostream& out, const PlotSeries& series, const Scale& x, const Scale& y,
                 const char* colour, double legend_y) {
  const auto mark = [&](double px, double py) {
    out << "<circle cx=\"" << text_of(px) << "\" cy=\"" << text_of(py) << "\" r=\"3\" fill=\""
        << colour << "\"/>\n";
  };
  const std::string style = std::string("fill=\"none\" stroke-width=\"2\" stroke=\"") + colour +
                            (series.dashed ? "\" stroke-dasharray=\"5 3\"" : "\"");
  if (series.line) {
    out << "<polyline " << style << " points=\"";
    for (std::size_t i = 0; i < series.x.size(); ++i)
      out << text_of(x.pixel(series.x[i])) << ',' << text_of(y.pixel(series.y[i])) << ' ';
    out << "\"/>\n";
    draw_line(out, legend_x, legend_y, legend_x + 22, legend_y, style.c_str());
  }
  for (std::size_t i = 0; i < series.x.size(); ++i)
    mark(x.pixel(series.x[i]), y.pixel(series.y[i]));
  mark(legend_x + 11, legend_y);
  out << "<text x=\"" << legend_x + 30 << "\" y=\"" << legend_y + 4 << "\">" << escaped(series.name)
      << "</text>\n";
}

}  // namespace

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else {
      out += c;
    }
  }
  return out;
}

std::string svg_of(const Plot& plot) {
  const Scale x = scale_of(plot, plot.x, &PlotSeries::x, left, width - right);
  const Scale y = scale_of(plot, plot.y, &PlotSeries::y, height - bottom, top);
  std::ostringstream out;
  out << beginning_of_charts();
  draw_frame(out, x, y);
  draw_titles(out, plot);
  double legend_y = top + 10;
  for (std::size_t i = 0; i < plot.series.size(); ++i, legend_y += 20)
    draw_series(out, plot.series[i], x, y, colours[i % colours.size()], legend_y);
  out << "</svg>\n";
  return out.str();
}

void write_text(const std::string& text, const std::filesystem::path& path) {
  std::error_code failure;
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), failure);
  std::ofstream file(path, std::ios::binary);
  file << text;
  if (!file.flush()) throw FileError(path.string() + ": cannot be written");
}

bool is_own_svg(const std::filesystem::path& path) {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(path, unknown)) return false;
  const std::string expected = beginning_of_charts();
  std::string begin(expected.size(), '\0');
  std::ifstream(path, std::ios::binary).read(begin.data(), std::ssize(begin));
  return begin == expected;
}

void write_svg(const Plot& plot, const std::filesystem::path& path) {
  write_text(svg_of(plot), path);
}

}  // namespace weft::sim
