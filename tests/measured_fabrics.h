// The measured fabrics of tests/reference/wang2011_fabrics.csv, and their tensions evaluated anew.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

namespace weft {

struct MeasuredFabric {
  std::string name;
  double density = 0;                            // kg/m^2
  std::array<std::array<double, 4>, 6> stretch;  // N/m, as published
  std::array<std::array<double, 5>, 3> bending;  // N m
};

inline std::vector<MeasuredFabric> measured_fabrics() {
  std::ifstream file(WEFT_REFERENCE_DIR "/wang2011_fabrics.csv");
  std::vector<MeasuredFabric> fabrics;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#') || line.starts_with("fabric,")) continue;
    std::istringstream fields(line);
    std::string name, quantity, index, number;
    std::getline(fields, name, ',');
    std::getline(fields, quantity, ',');
    std::getline(fields, index, ',');
    std::vector<double> values;
    while (std::getline(fields, number, ',')) values.push_back(std::stod(number));
    if (fabrics.empty() || fabrics.back().name != name) fabrics.push_back({name, 0, {}, {}});
    MeasuredFabric& fabric = fabrics.back();
    if (quantity == "density") fabric.density = values[0];
    if (quantity == "stretching")
      std::ranges::copy(values, fabric.stretch[std::stoi(index)].begin());
    if (quantity == "bending") std::ranges::copy(values, fabric.bending[std::stoi(index)].begin());
  }
  return fabrics;
}

// The coefficients C11, C12, C22, C33 with negative ones at zero, and C12 at most the root of C11
// C22.
inline std::array<std::array<double, 4>, 6> clamped_coefficients(const MeasuredFabric& fabric) {
  auto rows = fabric.stretch;
  for (auto& row : rows) {
    for (double& each : row) each = std::max(each, 0.0);
    row[1] = std::min(row[1], std::sqrt(row[0] * row[2]));
  }
  return rows;
}

// The second Piola-Kirchhoff tensions S_11, S_22, S_12 (N/m) at the Green strain E_11, E_22, E_12,
// by the interpolation of ARCSim 0.2 (dde.cpp: evaluate_stretching_sample, without its factor of
// two). Where all directions are stretched alike, the mean over the angle takes the place of a
// direction.
inline std::array<double, 3> published_tension(const MeasuredFabric& fabric, double e11, double e22,
                                               double e12) {
  const auto rows = clamped_coefficients(fabric);
  const double mean = 0.5 * (e11 + e22), half = 0.5 * (e11 - e22), radius = std::hypot(half, e12);
  const double stretch = std::sqrt(1 + 2 * (mean + radius));
  const double share = std::clamp(6 * (stretch - 1), 0.0, 1.0);
  const double angle = 0.5 * std::abs(std::atan2(e12, half));  // 0 … pi/2
  const double place = std::min(8 * angle / std::numbers::pi, 4 - 1e-9);
  const auto k = static_cast<std::size_t>(place);
  const double between = place - static_cast<double>(k);
  std::array<double, 4> c{};
  for (std::size_t i = 0; i < 4; ++i) {
    double stretched = (1 - between) * rows[k + 1][i] + between * rows[k + 2][i];
    if (radius < 1e-9 * std::abs(mean))
      stretched = (0.5 * rows[1][i] + rows[2][i] + rows[3][i] + rows[4][i] + 0.5 * rows[5][i]) / 4;
    c[i] = (1 - share) * rows[0][i] + share * stretched;
  }
  return {c[0] * e11 + c[1] * e22, c[1] * e11 + c[2] * e22, c[3] * e12};
}

}  // namespace weft
