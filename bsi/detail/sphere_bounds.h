// Rounding allowances that make float32 spheres bound float64 vertices. The header has constants
// only, so that kernels can include it.
#pragma once

namespace weft::bsi {

// Factor that enlarges a computed length. u = 2^-24 is the unit roundoff of float32. A length
// sqrt(dx^2 + dy^2 + dz^2) computed from float32 differences is too small by at most 3.5 u of
// itself. Adding a radius and multiplying make this 5.5 u (standard model, Higham 2002, section
// 2.2). Rounding a vertex p to float32 moves it by at most u |p|. For any centre c, |p| is at most
// |p - c| + |c|, and |c| at most |c|_1. Rounding the vertex therefore adds u of the length and u
// |c|_1. The factor covers 6.5 u < 8 u of the length.
inline constexpr float round_up = 1 + 0x1p-21F;
// Factor on |c|_1 that covers the rounding of vertices, u |c|_1 (see round_up).
inline constexpr float centre_rounding = 0x1p-24F * (1 + 0x1p-20F);
// Factor on |c|_1 for a sphere around a box. It also covers another u |c|, by which the rounded
// centre may be off the middle of the box.
inline constexpr float box_rounding = 2 * centre_rounding;
// Length (m) added to every radius for underflow, far below any physical length. Squares of lengths
// below 1.1e-19 m underflow: they lose bits or are flushed to zero.
inline constexpr float radius_floor = 1e-18F;
// Two spheres count as touching if the computed distance of their centres is at most this factor
// times the sum of their radii (squares are compared). The squared distance is accurate to 5 u of
// itself (see round_up), and the sum of two radii and a margin is accurate to 3 u of itself.
inline constexpr float touch_factor = 1 + 0x1p-20F;

}  // namespace weft::bsi
