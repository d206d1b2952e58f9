// A shadow map: the depths of surfaces seen from a distant light. Whatever lies behind them is in
// their shadow.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "gpu/triangle_batch.h"
#include "gpu/view.h"

namespace weft::gpu {

class DepthMap {
 public:
  // `size` texels along each side.
  explicit DepthMap(int size) : size_(size) {}

  // Draws the triangles as seen by a light that shines against `direction` (unit) on a box of half
  // size `reach` around the origin. Nothing beyond the box is in shadow, but surfaces between the
  // box and the light throw shadows into it. O(triangles + texels covered).
  void draw(const TriangleBatch& batch, const Vec3& direction, const Vec3& up, double reach);

  // Size of a texel, m.
  float texel() const { return texel_; }
  // Return the lit share, 0..1, of a square of texels around the position: of 1 x 1 texel (`lit`),
  // and of 3 x 3, which makes the rims of shadows soft (`softly_lit`).
  float lit(const Eigen::Vector3f& position) const;
  float softly_lit(const Eigen::Vector3f& position) const;

 private:
  // Returns the place in the map: texels across and down, and the depth along the light, m.
  Eigen::Vector3f place(const Eigen::Vector3f& position) const {
    return rows_ * position + Eigen::Vector3f(middle(), middle(), 0);
  }
  float middle() const { return 0.5F * static_cast<float>(size_); }
  void draw_triangle(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c);

  int size_;
  float texel_ = 0;
  Eigen::Matrix3f rows_ = Eigen::Matrix3f::Zero();
  std::vector<float> depths_;            // row after row
  std::vector<Eigen::Vector3f> places_;  // by vertex
};

}  // namespace weft::gpu
