// Rounding allowances that make float32 spheres bound float64 vertices. The header has constants
// only, so that kernels can include it.
#pragma once

namespace weft::bsi {

// Factor on a computed length. u = 2^-24 is the unit roundoff of float32. A length sqrt(dx^2 + dy^2
// + dz^2) computed from float32 differences is too small by at most 3.5 u of itself. Adding a
// radius and multiplying make this 5.5 u (standard model, Higham 2002, section 2.2). Rounding a
// vertex p to float32 moves it by at most u |p|. For any centre c, |p| <= |c| + |p - c| <= |c|_1 +
// |p - c|, which adds one more u of the length and u |c|_1. The factor covers the former (6.5 u < 8
// u), and centre_rounding |c|_1 covers the latter.
inline constexpr float round_up = 1 + 0x1p-21F;
inline constexpr float centre_rounding = 0x1p-24F * (1 + 0x1p-20F);
// Factor on |c|_1 for a sphere around a box. The rounded centre may lie another u |c| off the
// middle of the box, from which half the diagonal is measured.
inline constexpr float box_rounding = 2 * centre_rounding;
// Added to every radius, m, for underflow: far below any physical length. Squares of lengths below
// 1e-22 m underflow, and squares of lengths below 1e-19 m may be flushed to zero.
inline constexpr float radius_floor = 1e-18F;
// If the computed float32 distance of one vertex exceeds that of another by this factor, the first
// vertex is certainly farther. The factor covers twice the 3.5 u above, a sum and a product.
inline constexpr float prune_factor = 1 + 0x1p-20F;
// Two spheres count as touching if the computed distance of their centres is at most this factor
// times the sum of their radii (squares are compared). The squared distance is accurate to 5 u of
// itself, the sum of two radii and a margin to 3 u.
inline constexpr float touch_factor = 1 + 0x1p-20F;

}  // namespace weft::bsi
