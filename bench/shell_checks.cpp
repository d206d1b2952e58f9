#include "bench/shell_checks.h"

#include <cmath>
#include <fstream>
#include <numbers>
#include <stdexcept>

namespace weft::bench {

namespace {

using std::numbers::pi;

Measured relative(std::string quantity, double value, ReferenceFigure reference) {
  const double scale = std::abs(reference.value);
  return {std::move(quantity), value, std::move(reference), scale};
}
Measured by_name(std::string quantity, double value, const std::string& name) {
  return relative(std::move(quantity), value, reference_figure(name));
}

std::vector<CheckedImage> strips(std::vector<std::pair<int, double>> columns) {
  std::vector<CheckedImage> images;
  for (const auto& [count, limit] : columns) images.push_back({{4, count}, limit});
  return images;
}
std::vector<CheckedImage> squares(std::vector<std::pair<int, double>> sizes) {
  std::vector<CheckedImage> images;
  for (const auto& [size, limit] : sizes) images.push_back({{size, size}, limit});
  return images;
}

// The strip of length 10 ends at x = 5. Displacements of the tip, in lengths.
std::vector<Measured> measure_end_shear(const FramedBody& strip, int frame) {
  if (frame == 0) return {};
  const std::string name = "elastica_end_load_" + std::to_string(frame);
  const sim::Vec3 way = strip.way(0, -1) / 10;
  return {by_name("inward", -way.x(), name + "_inward"),
          by_name("across", way.z(), name + "_across")};
}

// A strip of length 12 under a moment that bends it to the angle t 2 pi. Errors are in lengths.
std::vector<Measured> measure_end_moment(const FramedBody& strip, int frame) {
  if (frame == 0) return {};
  const double angle = 2 * pi * frame / 8;
  const sim::Vec3 way = strip.way(0, -1) / 12;
  const std::string source = "circle of the angle M L / (E I)";
  return {{"inward", -way.x(), {1 - std::sin(angle) / angle, source}, 1},
          {"across", way.z(), {(1 - std::cos(angle)) / angle, source}, 1}};
}

std::vector<Measured> measure_sag(const FramedBody& sheet, int frame, const std::string& gamma) {
  if (frame != 10) return {};
  const sim::Vec3& tip = sheet.now(0, -1);
  return {by_name("drop", -tip.z(), "heavy_elastica_" + gamma + "_drop"),
          by_name("reach", tip.x() - sheet.start(0, 0).x(), "heavy_elastica_" + gamma + "_reach")};
}

ShellCheck heavy_elastica(const std::string& gamma, std::vector<std::pair<int, double>> columns) {
  // Gamma = rho h g L^3 / D is 12 times g.
  const std::string gravity = std::to_string(-std::stod(gamma) / 12);
  return {"heavy elastica, Gamma = " + gamma,
          "heavy_elastica",
          "sheet",
          {"world.gravity={ times = [0, 1], values = [[0, 0, 0], [0, 0, " + gravity + "]] }"},
          strips(std::move(columns)),
          [gamma](const FramedBody& sheet, int frame) { return measure_sag(sheet, frame, gamma); }};
}

std::vector<Measured> measure_full_hemisphere(const FramedBody& quarter, int frame) {
  if (frame != 8) return {};
  return {by_name("outward", quarter.way(0, 0).x(), "hemisphere_full_load_outward"),
          by_name("inward", -quarter.way(0, -1).y(), "hemisphere_full_load_inward")};
}

std::vector<Measured> measure_small_hemisphere(const FramedBody& quarter, int frame) {
  if (frame == 0) return {};
  constexpr double load = 1e-3;
  return {by_name("outward", quarter.way(0, 0).x() / load, "hemisphere_with_hole_linear"),
          by_name("inward", -quarter.way(0, -1).y() / load, "hemisphere_with_hole_linear")};
}

std::vector<Measured> measure_roof(const FramedBody& roof, int frame) {
  if (frame == 0) return {};
  constexpr double load = 1e-4;
  return {by_name("deflection", -roof.way(-1, -1).x() / load, "scordelis_lo_thin_shell")};
}

std::vector<Measured> measure_cylinder(const FramedBody& octant, int frame) {
  if (frame == 0) return {};
  return {by_name("deflection", -octant.way(-1, 0).x(), "pinched_cylinder")};
}

std::vector<ShellCheck> all_checks() {
  return {
      {"cantilever, end shear",
       "cantilever_end_shear",
       "strip",
       {},
       strips({{7, 0}, {11, 3e-3}, {19, 1e-4}, {35, 0}}),
       measure_end_shear},
      {"cantilever, end moment",
       "cantilever_end_moment",
       "strip",
       {},
       strips({{16, 0}, {32, 6e-4}, {64, 0}}),
       measure_end_moment},
      heavy_elastica("1", {{19, 0}, {35, 5e-4}}),
      heavy_elastica("10", {{19, 0}, {35, 5e-4}}),
      heavy_elastica("100", {{19, 0}, {35, 5e-4}, {67, 0}}),
      heavy_elastica("1000", {{35, 0}, {67, 2e-3}}),
      {"hemisphere with hole, full load",
       "hemisphere_full_load",
       "hemisphere",
       {},
       squares({{8, 0}, {16, 3e-2}, {32, 6e-3}}),
       measure_full_hemisphere},
      {"hemisphere with hole, linear",
       "hemisphere_linear",
       "hemisphere",
       {},
       squares({{9, 0}, {17, 3e-3}, {33, 0}}),
       measure_small_hemisphere},
      {"Scordelis-Lo roof",
       "scordelis_lo",
       "roof",
       {},
       squares({{5, 0}, {9, 1e-3}, {17, 2e-4}, {33, 0}}),
       measure_roof},
      {"pinched cylinder",
       "pinched_cylinder",
       "cylinder",
       {},
       squares({{9, 0}, {17, 2e-2}, {33, 3e-3}, {65, 0}}),
       measure_cylinder},
  };
}

}  // namespace

ReferenceFigure reference_figure(const std::string& name) {
  const std::string path = WEFT_SOURCE_DIR "/tests/reference/closed_forms.csv";
  std::ifstream file(path);
  std::string source;
  for (std::string line; std::getline(file, line);) {
    const std::size_t first = line.find(','), second = line.find(',', first + 1);
    if (second == std::string::npos) continue;
    std::string text = line.substr(second + 1);
    // "the same" stands for the source of the line before.
    source = text.starts_with("the same") ? source : std::move(text);
    if (line.compare(0, first, name) == 0)
      return {std::stod(line.substr(first + 1, second - first - 1)), source};
  }
  throw std::runtime_error(path + " has no " + name);
}

const std::vector<ShellCheck>& shell_checks() {
  static const std::vector<ShellCheck> all = all_checks();
  return all;
}

}  // namespace weft::bench
