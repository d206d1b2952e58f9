// Helpers of the functions in shapes.h: a check of sizes, and patches sewn by the integer labels of
// their texels.
#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <vector>

#include "bsi/shapes.h"

namespace weft::bsi {

// The label of a texel. Texels with equal labels become one particle. Integer labels avoid the
// comparison of floating-point numbers along seams.
using Label = std::array<int, 3>;

// Throws std::invalid_argument unless `value` is positive and finite. `name` names the size in the
// message.
void check_size(const char* name, double value);

// Sorts texel indices by `less`, then by index.
template <typename Less>
void sort_texels(std::vector<int>& texels, Less less) {
  std::ranges::sort(texels, [&](int a, int b) {
    if (less(a, b)) return true;
    if (less(b, a)) return false;
    return a < b;
  });
}

// Returns the particle of each texel, numbered in the order of first texels. first_of[texel] is the
// first texel at the same point as `texel`.
std::vector<int> number_particles(std::vector<int> first_of);

// Makes a surface of patches with one label per texel, patch by patch and row by row.
// position(label) returns the position (m) of a texel.
Surface make_sewn(const std::vector<Patch>& patches, const std::vector<Label>& labels,
                  const std::function<Vec3(const Label&)>& position);

}  // namespace weft::bsi
