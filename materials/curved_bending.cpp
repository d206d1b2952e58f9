#include "materials/curved_bending.h"

#include <cassert>

namespace weft::materials {

namespace {

std::array<double, 4> numbers_of(const OrthotropicModuli& moduli) {
  return {moduli.warp, moduli.coupling, moduli.weft, moduli.shear};
}

}  // namespace

CurvedBending::CurvedBending(std::span<const double> curvatures,
                             std::span<const OrthotropicModuli> moduli)
    : flat_(numbers_of(moduli.front())) {
  assert(curvatures.size() == moduli.size() && curvatures.front() == 0);
  std::array<double, 4> slope{};
  for (std::size_t i = 0; i < curvatures.size(); ++i) {
    const bool is_last = i + 1 == curvatures.size();
    Ramp ramp{curvatures[i], {}};
    bool changes = false;
    for (std::size_t k = 0; k < 4; ++k) {
      const double next = is_last ? 0
                                  : (numbers_of(moduli[i + 1])[k] - numbers_of(moduli[i])[k]) /
                                        (curvatures[i + 1] - curvatures[i]);
      ramp.change[k] = next - slope[k];
      slope[k] = next;
      changes |= ramp.change[k] != 0;
    }
    if (changes) ramps_.push_back(ramp);
  }
}

}  // namespace weft::materials
