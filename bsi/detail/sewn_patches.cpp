#include "bsi/detail/sewn_patches.h"

#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

namespace weft::bsi {

void check_size(const char* name, double value) {
  if (value > 0 && std::isfinite(value)) return;
  throw std::invalid_argument(std::string(name) + " must be a positive length, not " +
                              std::to_string(value));
}

std::vector<int> number_particles(std::vector<int> first_of) {
  int count = 0;
  for (std::size_t texel = 0; texel < first_of.size(); ++texel) {
    const auto first = static_cast<std::size_t>(first_of[texel]);
    // first <= texel, so first_of[first] already holds a particle index unless first == texel.
    first_of[texel] = first == texel ? count++ : first_of[first];
  }
  return first_of;
}

Surface make_sewn(const std::vector<Patch>& patches, const std::vector<Label>& labels,
                  const std::function<Vec3(const Label&)>& position) {
  std::vector<int> order(labels.size());
  std::iota(order.begin(), order.end(), 0);
  sort_texels(order, [&](int a, int b) { return labels[a] < labels[b]; });
  std::vector<int> first_of(labels.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && labels[order[i]] == labels[order[i - 1]];
    first_of[order[i]] = same ? first_of[order[i - 1]] : order[i];
  }
  std::vector<int> particles = number_particles(std::move(first_of));
  Surface surface;
  surface.positions.resize(*std::ranges::max_element(particles) + 1);
  for (std::size_t texel = 0; texel < labels.size(); ++texel) {
    surface.positions[particles[texel]] = position(labels[texel]);
  }
  surface.atlas = Atlas(patches, std::move(particles));
  return surface;
}

}  // namespace weft::bsi
