#include "gpu/depth_map.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace weft::gpu {
namespace {

using Eigen::Vector3f;

// Width of the map's border in texels. The border stays empty, so a position beyond it is lit.
// softly_lit() makes an exception: beyond the last column or row, it includes one drawn column or
// row, so a position there may be lit by two thirds only.
constexpr int border = 3;

}  // namespace

void DepthMap::draw(const TriangleBatch& batch, const Vec3& direction, const Vec3& up,
                    double reach) {
  depths_.assign(static_cast<std::size_t>(size_) * size_, std::numeric_limits<float>::infinity());
  texel_ = static_cast<float>(2 * reach / (size_ - 2 * border));
  const ViewFrame frame = look_along(direction, up);
  rows_.row(0) = frame.right.cast<float>() / texel_;
  rows_.row(1) = -frame.up.cast<float>() / texel_;
  rows_.row(2) = -frame.backward.cast<float>();
  places_.clear();
  for (const BatchVertex& vertex : batch.vertices) {
    places_.push_back(place(vertex.position().matrix()));
  }
  for (const auto& [corners, surface] : batch.triangles) {
    draw_triangle(places_[corners[0]], places_[corners[1]], places_[corners[2]]);
  }
}

// Draws a triangle row by row. The triangle's edges bound the texels to draw in each row.
void DepthMap::draw_triangle(const Vector3f& a, const Vector3f& b, const Vector3f& c) {
  const Vector3f low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
  const auto least = static_cast<float>(border), most = static_cast<float>(size_ - 1 - border);
  const float top = std::ceil(std::max(low.y() - 0.5F, least));
  const float bottom = std::floor(std::min(high.y() - 0.5F, most));
  const float left = std::ceil(std::max(low.x() - 0.5F, least));
  const float right = std::floor(std::min(high.x() - 0.5F, most));
  if (!(top <= bottom && left <= right)) return;  // also if a coordinate is not a number
  const Vector3f normal = (b - a).cross(c - a);
  if (normal.z() == 0) return;

  // An edge of the triangle: it crosses row `row` of the texels at column start + slope * row. Left
  // edges have the triangle on their right. Horizontal edges are omitted.
  struct Edge {
    float start, slope;
  };
  std::array<Edge, 3> left_edges, right_edges;
  int left_count = 0, right_count = 0;
  for (const auto& [tail, head] : {std::pair(&a, &b), std::pair(&b, &c), std::pair(&c, &a)}) {
    const float rise = head->y() - tail->y();
    if (rise == 0) continue;
    const float slope = (head->x() - tail->x()) / rise;
    const Edge edge{tail->x() + slope * (0.5F - tail->y()) - 0.5F, slope};
    if ((rise > 0) == (normal.z() > 0)) {
      right_edges[right_count++] = edge;
    } else {
      left_edges[left_count++] = edge;
    }
  }
  // Depths are increased in proportion to the slope, so that a surface does not shade itself.
  const float slope_x = -normal.x() / normal.z(), slope_y = -normal.y() / normal.z();
  const float depth = a.z() + 1.5F * std::max(std::abs(slope_x), std::abs(slope_y)) +
                      slope_x * (0.5F - a.x()) + slope_y * (0.5F - a.y());
  for (int number = static_cast<int>(top); number <= static_cast<int>(bottom); ++number) {
    const auto row = static_cast<float>(number);
    float begin = left, end = right;
    for (int i = 0; i < left_count; ++i) {
      begin = std::max(begin, std::ceil(left_edges[i].start + left_edges[i].slope * row));
    }
    for (int i = 0; i < right_count; ++i) {
      end = std::min(end, std::floor(right_edges[i].start + right_edges[i].slope * row));
    }
    if (begin > end) continue;
    float* const depths = &depths_[static_cast<std::size_t>(number) * size_];
    const float row_depth = depth + slope_y * row;
    for (int col = static_cast<int>(begin); col <= static_cast<int>(end); ++col) {
      // Rounding must not bring a triangle seen edge-on nearer to the light than its corners.
      const float here = std::max(row_depth + slope_x * static_cast<float>(col), low.z());
      depths[col] = std::min(depths[col], here);
    }
  }
}

float DepthMap::lit(const Vector3f& position) const {
  const Vector3f at = place(position);
  const auto limit = static_cast<float>(size_ - 2);
  const float x = std::clamp(at.x() - 0.5F, 0.0F, limit);
  const float y = std::clamp(at.y() - 0.5F, 0.0F, limit);
  const int col = static_cast<int>(x), row = static_cast<int>(y);
  const float right = x - static_cast<float>(col), down = y - static_cast<float>(row);
  const float* const upper = &depths_[static_cast<std::size_t>(row) * size_ + col];
  const float* const lower = upper + size_;
  const auto seen = [&at](float depth) { return depth >= at.z() ? 1.0F : 0.0F; };
  const float above = (1 - right) * seen(upper[0]) + right * seen(upper[1]);
  const float below = (1 - right) * seen(lower[0]) + right * seen(lower[1]);
  return (1 - down) * above + down * below;
}

// Averages over 4 x 4 texels. Each texel is weighted by the fraction of it that the square of 3 x 3
// texels covers.
float DepthMap::softly_lit(const Vector3f& position) const {
  const Vector3f at = place(position);
  const auto limit = static_cast<float>(size_ - 3);
  const float x = std::clamp(at.x() - 0.5F, 1.0F, limit);
  const float y = std::clamp(at.y() - 0.5F, 1.0F, limit);
  const int col = static_cast<int>(x), row = static_cast<int>(y);
  const float right = x - static_cast<float>(col), down = y - static_cast<float>(row);
  const std::array<float, 4> shares{1 - down, 1, 1, down};
  const float* texels = &depths_[static_cast<std::size_t>(row - 1) * size_ + (col - 1)];
  float sum = 0;
  for (int i = 0; i < 4; ++i, texels += size_) {
    const auto seen = [&](int j) { return texels[j] >= at.z() ? 1.0F : 0.0F; };
    sum += shares[i] * ((1 - right) * seen(0) + seen(1) + seen(2) + right * seen(3));
  }
  return sum / 9;
}

}  // namespace weft::gpu
