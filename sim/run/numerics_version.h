// The number of the numerics.
#pragma once

namespace weft::sim {

// Changes when the same case gives other numbers than before, on the same machine. Sweeps run a
// case again only if this number, the case or a file that it reads has changed. The test
// NumericsVersion.NumberChangesWithTheNumerics fails when results move and this number does not.
inline constexpr int numerics_version = 25;

}  // namespace weft::sim
