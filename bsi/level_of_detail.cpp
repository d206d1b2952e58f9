#include "bsi/level_of_detail.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "bsi/detail/detail_border.h"
#include "bsi/detail/detail_patch.h"

namespace weft::bsi {

namespace {

std::vector<DetailPatch> coarsest_patches(const Pyramid& pyramid,
                                          std::span<const char> left_alone) {
  std::vector<DetailPatch> patches;
  patches.reserve(left_alone.size());
  for (int patch = 0; patch < pyramid.patch_count(); ++patch) {
    patches.emplace_back(pyramid, patch, left_alone[patch] != 0);
  }
  return patches;
}

// The patches, each with all its blocks on one level, and the border sample that replaces each
// particle.
struct PatchesAtLevels {
  std::vector<DetailPatch> patches;
  std::vector<int> sample_of;
};

PatchesAtLevels patches_at_levels(const Pyramid& pyramid, std::span<const int> levels) {
  assert(static_cast<int>(levels.size()) == pyramid.patch_count());
  const std::vector<char> left_alone = patches_left_alone(pyramid.atlas());
  PatchesAtLevels at{coarsest_patches(pyramid, left_alone),
                     sampled_borders(pyramid, levels, left_alone)};
  for (std::size_t i = 0; i < at.patches.size(); ++i) {
    at.patches[i].split_to_level(levels[i]);
    at.patches[i].sample_borders(at.sample_of);
  }
  return at;
}

// Returns the centre (m) of a block's sphere.
Vec3 centre_of(const Pyramid& pyramid, const PatchBlock& block) {
  const Box box = pyramid.box(block.patch, block.level, block.u, block.v);
  Vec3 centre;
  for (int axis = 0; axis < 3; ++axis) {
    centre[axis] = static_cast<double>(0.5F * (box.low[axis] + box.high[axis]));
  }
  return centre;
}

// Returns the smallest integer greater than `place`. Precondition: place >= 0.
int first_after(double place) { return static_cast<int>(place) + 1; }

// Measures the distance of coarse triangles of a patch from the original surface at the same place
// of the image. The edges of both triangulations cut the image into pieces on which both surfaces
// are linear. The distance is therefore largest at a corner of a piece.
class Ruler {
 public:
  Ruler(const Pyramid& pyramid, std::span<const Vec3> positions, int patch,
        const DetailTolerance* tolerance)
      : pyramid_(pyramid),
        positions_(positions),
        patch_(patch),
        size_(pyramid.atlas().patches()[patch]),
        tolerance_(tolerance) {}

  Vec3 position(const DetailPatch& patch, int vertex) const {
    if (patch.is_block(vertex)) return centre_of(pyramid_, patch.block(vertex));
    const Atlas& atlas = pyramid_.atlas();
    return positions_[atlas.particle_of_texel(atlas.first_texel(patch_) + vertex)];
  }

  // Measures a triangle. Returns false at the first point that is not within the tolerance, without
  // measuring further points.
  bool measure(const DetailPatch& patch, const DetailTriangle& triangle);

  // Returns the largest distance (m) measured so far within the tolerance.
  double largest() const { return largest_; }

 private:
  struct Corner {
    Vec3 position;
    double row = 0, col = 0;
  };

  bool check(const Vec3& coarse, const Vec3& original) {
    const double squared = (coarse - original).squaredNorm();
    if (tolerance_ != nullptr) {
      const double allowed = tolerance_->at(original);
      if (!(squared < allowed * allowed)) return false;
    }
    largest_ = std::max(largest_, std::sqrt(squared));
    return true;
  }
  static bool is_original(const DetailPatch& patch, const DetailTriangle& triangle);
  void take_round_wraps(std::array<Corner, 3>& corners) const;
  bool check_edge(const Corner& from, const Corner& to);
  bool check_inside(const std::array<Corner, 3>& corners);
  const Vec3& texel(int row, int col) const {
    return positions_[pyramid_.atlas().particle(patch_, row, col)];
  }
  Vec3 original(double row, double col) const;

  const Pyramid& pyramid_;
  std::span<const Vec3> positions_;
  int patch_;
  Patch size_;
  const DetailTolerance* tolerance_;
  double largest_ = 0;
};

// Returns true if the triangle belongs to the original surface. Its corners are then texels of one
// triangle of a quad.
bool Ruler::is_original(const DetailPatch& patch, const DetailTriangle& triangle) {
  const auto is_within_one = [&](const auto& place) {
    const auto [least, most] =
        std::minmax({place(triangle[0]), place(triangle[1]), place(triangle[2])});
    return most - least <= 1;
  };
  return std::ranges::none_of(
             triangle, [&](const DetailCorner& corner) { return patch.is_block(corner.vertex); }) &&
         is_within_one([](const DetailCorner& corner) { return corner.row; }) &&
         is_within_one([](const DetailCorner& corner) { return corner.col; }) &&
         is_within_one([](const DetailCorner& corner) { return corner.row + corner.col; });
}

// If a corner lies before the first texel of a wrapped axis, shifts the triangle by one period
// along that axis.
void Ruler::take_round_wraps(std::array<Corner, 3>& corners) const {
  for (const Corner& first : corners) {
    const double rows = first.row < 0 ? size_.rows : 0, cols = first.col < 0 ? size_.cols : 0;
    if (rows == 0 && cols == 0) continue;
    for (Corner& corner : corners) {
      corner.row += rows;
      corner.col += cols;
    }
  }
}

bool Ruler::measure(const DetailPatch& patch, const DetailTriangle& triangle) {
  if (is_original(patch, triangle)) return true;
  std::array<Corner, 3> corners;
  for (int i = 0; i < 3; ++i) {
    corners[i] = {position(patch, triangle[i].vertex), triangle[i].row, triangle[i].col};
  }
  take_round_wraps(corners);
  for (const Corner& corner : corners) {
    if (!check(corner.position, original(corner.row, corner.col))) return false;
  }
  if (!check_inside(corners)) return false;
  for (int i = 0; i < 3; ++i) {
    const int from = triangle[i].vertex;
    const int to = triangle[(i + 1) % 3].vertex;
    // Two triangles of the patch share an edge that ends at the centre of a block, and traverse it
    // in opposite directions. Only the triangle that traverses it from the lower to the higher
    // vertex checks it.
    const bool is_inside = patch.is_block(from) || patch.is_block(to);
    if (is_inside && from > to) continue;
    if (!check_edge(corners[i], corners[(i + 1) % 3])) return false;
  }
  return true;
}

// Returns the point of the original surface at (row, col) of the image.
Vec3 Ruler::original(double row, double col) const {
  const int last_row = size_.wrap_v ? 2 * size_.rows - 2 : size_.rows - 2;
  const int last_col = size_.wrap_u ? 2 * size_.cols - 2 : size_.cols - 2;
  const int r = std::clamp(static_cast<int>(row), 0, last_row);
  const int c = std::clamp(static_cast<int>(col), 0, last_col);
  const double down = row - r;
  const double right = col - c;
  const Vec3& upper_right = texel(r, c + 1);
  const Vec3& lower_left = texel(r + 1, c);
  if (down + right <= 1) {
    const Vec3& upper_left = texel(r, c);
    return upper_left + right * (upper_right - upper_left) + down * (lower_left - upper_left);
  }
  const Vec3& lower_right = texel(r + 1, c + 1);
  return lower_right + (1 - right) * (lower_left - lower_right) +
         (1 - down) * (upper_right - lower_right);
}

// Checks the points of an edge where it crosses the rows, the columns and the diagonals of the
// image.
bool Ruler::check_edge(const Corner& from, const Corner& to) {
  const std::array<std::array<double, 2>, 3> ends{
      {{from.row, to.row}, {from.col, to.col}, {from.row + from.col, to.row + to.col}}};
  for (const auto& [start, end] : ends) {
    const double low = std::min(start, end);
    const double high = std::max(start, end);
    for (int line = first_after(low); line < high; ++line) {
      const double t = (line - start) / (end - start);
      const Vec3 point = from.position + t * (to.position - from.position);
      if (!check(point, original(from.row + t * (to.row - from.row),
                                 from.col + t * (to.col - from.col)))) {
        return false;
      }
    }
  }
  return true;
}

// Checks the points of a triangle at the texels inside it.
bool Ruler::check_inside(const std::array<Corner, 3>& corners) {
  const auto [lowest, highest] = std::minmax({corners[0].row, corners[1].row, corners[2].row});
  for (int row = first_after(lowest); row < highest; ++row) {
    // The two points where the row crosses the triangle's border, the lower column first.
    std::array<Corner, 2> ends;
    int found = 0;
    for (int i = 0; i < 3 && found < 2; ++i) {
      const Corner& from = corners[i];
      const Corner& to = corners[(i + 1) % 3];
      if ((from.row <= row) == (to.row <= row)) continue;
      const double t = (row - from.row) / (to.row - from.row);
      ends[found++] = {from.position + t * (to.position - from.position), static_cast<double>(row),
                       from.col + t * (to.col - from.col)};
    }
    if (ends[0].col > ends[1].col) std::swap(ends[0], ends[1]);
    const double width = ends[1].col - ends[0].col;
    for (int col = first_after(ends[0].col); col < ends[1].col; ++col) {
      const Vec3 point =
          ends[0].position + (col - ends[0].col) / width * (ends[1].position - ends[0].position);
      if (!check(point, texel(row, col))) return false;
    }
  }
  return true;
}

// Splits blocks until every triangle is within the tolerance. Returns an upper bound (m) of the
// distances that remain.
double refine(DetailPatch& patch, Ruler& ruler) {
  std::vector<char> too_coarse;
  int first_new = patch.texel_count();  // vertices from here on are new blocks, not yet measured
  for (;;) {
    too_coarse.assign(patch.block_count(), 0);
    bool done = true;
    patch.for_each_triangle([&](const DetailTriangle& triangle) {
      bool is_new = false;
      int coarsest = std::numeric_limits<int>::max();
      for (const DetailCorner& corner : triangle) {
        if (patch.is_block(corner.vertex)) {
          coarsest = std::min(coarsest, patch.block(corner.vertex).level);
          is_new = is_new || corner.vertex >= first_new;
        } else {
          is_new = true;  // the texel may have been part of a block until now
        }
      }
      // A triangle can be inverted in the image where a long block meets a wide one.
      if (!is_new || (image_area(triangle) > 0 && ruler.measure(patch, triangle))) return;
      done = false;
      for (const DetailCorner& corner : triangle) {
        if (patch.is_block(corner.vertex) && patch.block(corner.vertex).level == coarsest) {
          too_coarse[corner.vertex - patch.texel_count()] = 1;
        }
      }
    });
    if (done) return ruler.largest();
    first_new = patch.texel_count() + patch.block_count();
    for (std::size_t i = 0; i < too_coarse.size(); ++i) {
      if (too_coarse[i] != 0) patch.split(patch.texel_count() + static_cast<int>(i));
    }
  }
}

DetailSurface assemble(const Pyramid& pyramid, std::span<const Vec3> positions,
                       const std::vector<DetailPatch>& patches) {
  const Atlas& atlas = pyramid.atlas();
  DetailSurface surface;
  std::vector<int> index_of_particle(atlas.particle_count(), -1);
  std::vector<int> index_of_block;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const DetailPatch& patch = patches[i];
    const int first_texel = atlas.first_texel(static_cast<int>(i));
    index_of_block.assign(patch.block_count(), -1);
    const auto index_of = [&](int vertex) {
      const bool is_block = patch.is_block(vertex);
      const int particle = atlas.particle_of_texel(first_texel + patch.middle_texel(vertex));
      int& index =
          is_block ? index_of_block[vertex - patch.texel_count()] : index_of_particle[particle];
      if (index < 0) {
        index = static_cast<int>(surface.positions.size());
        surface.positions.push_back(is_block ? centre_of(pyramid, patch.block(vertex))
                                             : positions[particle]);
        surface.particles.push_back(particle);
      }
      return index;
    };
    patch.for_each_triangle([&](const DetailTriangle& triangle) {
      std::array<int, 3> corners{};
      for (int k = 0; k < 3; ++k) corners[k] = index_of(triangle[k].vertex);
      surface.triangles.push_back(corners);
    });
  }
  return surface;
}

}  // namespace

DetailSurface detail_at_levels(const Pyramid& pyramid, std::span<const Vec3> positions,
                               std::span<const int> levels) {
  assert(pyramid.is_built());
  const auto [patches, sample_of] = patches_at_levels(pyramid, levels);
  DetailSurface surface = assemble(pyramid, positions, patches);
  for (std::size_t i = 0; i < sample_of.size(); ++i) {
    const double distance = (positions[i] - positions[sample_of[i]]).norm();
    surface.deviation = std::max(surface.deviation, distance);
  }
  for (const DetailPatch& patch : patches) {
    patch.for_each_triangle([&](const DetailTriangle& triangle) {
      for (const DetailCorner& corner : triangle) {
        if (!patch.is_block(corner.vertex)) continue;
        const auto radius = static_cast<double>(pyramid.sphere(patch.block(corner.vertex)).radius);
        surface.deviation = std::max(surface.deviation, radius);
      }
    });
  }
  return surface;
}

DetailSurface detail_within(const Pyramid& pyramid, std::span<const Vec3> positions,
                            const DetailTolerance& tolerance) {
  assert(pyramid.is_built());
  std::vector<DetailPatch> patches = coarsest_patches(pyramid, patches_left_alone(pyramid.atlas()));
  std::vector<double> largest(patches.size());
#pragma omp parallel for schedule(dynamic)
  for (std::size_t i = 0; i < patches.size(); ++i) {
    Ruler ruler(pyramid, positions, static_cast<int>(i), &tolerance);
    largest[i] = refine(patches[i], ruler);
  }
  DetailSurface surface = assemble(pyramid, positions, patches);
  for (const double distance : largest) surface.deviation = std::max(surface.deviation, distance);
  return surface;
}

double deviation_at_levels(const Pyramid& pyramid, std::span<const Vec3> positions,
                           std::span<const int> levels) {
  assert(pyramid.is_built());
  const std::vector<DetailPatch> patches = patches_at_levels(pyramid, levels).patches;
  double largest = 0;
  for (int i = 0; i < pyramid.patch_count(); ++i) {
    Ruler ruler(pyramid, positions, i, nullptr);
    patches[i].for_each_triangle(
        [&](const DetailTriangle& triangle) { ruler.measure(patches[i], triangle); });
    largest = std::max(largest, ruler.largest());
  }
  return largest;
}

}  // namespace weft::bsi
