// Rounding allowances that make float32 spheres bound float64 vertices. Constants only, for kernels
// too.
#pragma once

namespace weft::bsi {

// u = 2^-24 is the unit roundoff of float32. A length computed as sqrt(dx^2 + dy^2 + dz^2) from
// float32 differences is too small by at most 3.5 u of itself; adding a radius and multiplying make
// it 5.5 u (standard model, Higham 2002, section 2.2). Rounding a vertex p to float32 moves it by
// at most u |p|, and |p| <= |c| + |p - c| <= |c|_1 + |p - c| for any centre c: one more u of the
// length. The sum is below the 8 u that round_up adds, and the rest is centre_rounding |c|_1.
inline constexpr float round_up = 1 + 0x1p-21F;
inline constexpr float centre_rounding = 0x1p-24F * (1 + 0x1p-20F);
// Allowance for a sphere around a box. The sphere's rounded centre may also lie u |c| off the
// middle of the box, and half the diagonal is measured from that middle.
inline constexpr float box_rounding = 2 * centre_rounding;
// Added to every radius: far below any physical length, and above all that underflow can lose (the
// square of a length under 1e-22 m, or one flushed to zero under 1e-19 m).
inline constexpr float radius_floor = 1e-18F;
// If one of two float32 lengths exceeds the other by this factor, its vertex is certain to be
// farther. The factor covers twice the 3.5 u above, a sum and a product.
inline constexpr float prune_factor = 1 + 0x1p-20F;
// Two spheres count as touching if the squared float32 distance of their centres is at most the
// square of this factor times the sum of their radii. The distance is accurate to 2.5 u of itself,
// the sum of two radii and a margin to 3 u.
inline constexpr float touch_factor = 1 + 0x1p-20F;

}  // namespace weft::bsi
