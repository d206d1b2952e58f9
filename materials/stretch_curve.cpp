#include "materials/stretch_curve.h"

#include <algorithm>
#include <cassert>

namespace weft::materials {

// Returns the kinks of the curve that starts at (0, 0) and passes through these points (strain,
// tension). Precondition: the strains are positive and increase.
std::vector<TensionCurve::Ramp> TensionCurve::ramps(std::span<const std::array<double, 2>> points) {
  std::vector<Ramp> all;
  double strain = 0, tension = 0, slope = 0;
  for (const auto& [next_strain, next_tension] : points) {
    const double next_slope = (next_tension - tension) / (next_strain - strain);
    all.push_back({strain, next_slope - slope});
    strain = next_strain;
    tension = next_tension;
    slope = next_slope;
  }
  return all;
}

TensionCurve::TensionCurve(std::span<const double> strains, std::span<const double> tensions) {
  assert(strains.size() == tensions.size() && strains.size() >= 2);
  std::vector<std::array<double, 2>> pull, push;
  for (std::size_t i = 0; i < strains.size(); ++i) {
    if (strains[i] > 0) pull.push_back({strains[i], tensions[i]});
    if (strains[i] < 0) push.insert(push.begin(), {-strains[i], -tensions[i]});
  }
  pull_ = ramps(pull);
  push_ = ramps(push);
  if (pull_.empty()) pull_ = {push_.front()};
  if (push_.empty()) push_ = {pull_.front()};
}

TensionCurve TensionCurve::mirrored(std::span<const double> strains,
                                    std::span<const double> tensions) {
  TensionCurve curve(strains, tensions);
  curve.push_ = curve.pull_;
  return curve;
}

double TensionCurve::largest_stiffness() const {
  double largest = 0;
  for (const auto* side : {&pull_, &push_}) {
    double slope = 0;
    for (const Ramp& ramp : *side) largest = std::max(largest, slope += ramp.slope);
  }
  return largest;
}

}  // namespace weft::materials
