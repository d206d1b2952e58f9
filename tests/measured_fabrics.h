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

// The work per rest area (N/m) of a fabric at the Green strain E_11, E_22, E_12, as
// docs/theory.md, "Woven triangles", defines it: a second evaluation of the law, which shares
// nothing with materials/measured_stretch.h.
inline double tabulated_work(const MeasuredFabric& fabric, double e11, double e22, double e12) {
  using std::numbers::pi;
  const auto rows = clamped_coefficients(fabric);
  const double mean = 0.5 * (e11 + e22), half = 0.5 * (e11 - e22), radius = std::hypot(half, e12);
  const double major = mean + radius, minor = mean - radius;
  const double phi = 0.5 * std::atan2(e12, half);
  const bool both = minor > 0;
  const double q = both ? radius / mean : 1;
  const double part = (15 * q - 10 * std::pow(q, 3) + 3 * std::pow(q, 5)) / 8;
  // Cosine series through the five angles (a discrete cosine transform), times r^j.
  const auto stretched = [&](std::size_t k) {
    double sum = 0;
    for (int j = 0; j <= 4; ++j) {
      double amplitude = 0;
      for (int i = 0; i <= 4; ++i) {
        const double end = i == 0 || i == 4 ? 0.5 : 1;
        amplitude += end * rows[static_cast<std::size_t>(1 + i)][k] * std::cos(pi * i * j / 4);
      }
      amplitude *= (j == 0 || j == 4 ? 0.5 : 1) / 2.0;
      sum += amplitude * std::pow(part, j) * std::cos(2 * j * phi);
    }
    return sum;
  };
  double measure = major;
  if (both) {
    measure +=
        (major + minor) * (15 * q * q - 10 * std::pow(q, 4) + 3 * std::pow(q, 6) - 8 * q) / 16;
  }
  // h = int 2 t s(t) dt by the trapezoidal rule, in t^2.
  double h = 0;
  constexpr int parts = 20000;
  for (int i = 0; i < parts; ++i) {
    const double t = std::sqrt((i + 0.5) / parts);
    h += std::clamp(6 * (std::sqrt(std::max(1 + 2 * t * measure, 0.0)) - 1), 0.0, 1.0) / parts;
  }
  // The strain with a limited contraction, in the axes of warp and weft.
  double limited = minor;
  if (major > 0 && minor < -major) {
    const double y = -(1 + minor / major) / 2;
    limited = -major * (1 + 2 * y / std::sqrt(1 + y * y));
  }
  const double c = std::cos(phi), s = std::sin(phi);
  const std::array<double, 3> whole{e11, e22, e12},
      less{c * c * major + s * s * limited, s * s * major + c * c * limited,
           c * s * (major - limited)};
  const auto form = [](const std::array<double, 4>& m, const std::array<double, 3>& e) {
    return m[0] * e[0] * e[0] + 2 * m[1] * e[0] * e[1] + m[2] * e[1] * e[1] +
           2 * m[3] * e[2] * e[2];
  };
  std::array<double, 4> change{};
  for (std::size_t k = 0; k < 4; ++k) change[k] = stretched(k) - rows[0][k];
  return 0.5 * (form(rows[0], whole) + h * form(change, less));
}

}  // namespace weft
