// A shadow map: the depths of surfaces seen from a distant light. Points behind these surfaces are
// in their shadow.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "gpu/triangle_batch.h"
#include "gpu/view.h"

namespace weft::gpu {

class DepthMap {
 public:
  // The map has size x size texels.
  explicit DepthMap(int size) : size_(size) {}

  // Draws the triangles as seen from a distant light in `direction` (unit, towards the light). The
  // map covers a square of half side `reach` (m) around the origin, perpendicular to the light.
  // Points outside this square are lit, but shadows at its sides may continue outside, weakened.
  // O(triangles + texels covered).
  void draw(const TriangleBatch& batch, const Vec3& direction, const Vec3& up, double reach);

  // Side of a texel, m.
  float texel() const { return texel_; }
  // Return the lit fraction (0..1) of a square of the map around a position (m). The square has 1 x
  // 1 texel for lit() and 3 x 3 texels for softly_lit(), which makes the edges of shadows soft.
  float lit(const Eigen::Vector3f& position) const;
  float softly_lit(const Eigen::Vector3f& position) const;

 private:
  // Converts a position (m) to coordinates of the map: texels across, texels down, and the depth in
  // the direction of the light's rays (m).
  Eigen::Vector3f place(const Eigen::Vector3f& position) const {
    return rows_ * position + Eigen::Vector3f(middle(), middle(), 0);
  }
  float middle() const { return 0.5F * static_cast<float>(size_); }
  void draw_triangle(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c);

  int size_;
  float texel_ = 0;
  Eigen::Matrix3f rows_ = Eigen::Matrix3f::Zero();
  std::vector<float> depths_;            // depth of the nearest surface by texel, row by row, m
  std::vector<Eigen::Vector3f> places_;  // coordinates of the batch's vertices in the map
};

}  // namespace weft::gpu
