#include "sim/scene/pins.h"

#include <algorithm>

#include "sim/case/case_error.h"
#include "sim/scene/index_range.h"
#include "sim/scene/shell_body.h"

namespace weft::sim {

namespace {

// Distance from a box, as a part of the size of the body, up to which points belong to it.
constexpr double box_margin = 1e-9;

class Selection {
 public:
  Selection(int patch, const SourceLocation& where, const bsi::Atlas& atlas)
      : patch_(patch), where_(where), atlas_(atlas) {
    if (patch < 0 || patch >= static_cast<int>(atlas.patches().size())) {
      throw CaseError(where, "the body has no patch " + std::to_string(patch),
                      "expected 0.." + std::to_string(atlas.patches().size() - 1));
    }
  }

  void add_texel(int row, int col) { particles_.push_back(atlas_.particle(patch_, row, col)); }
  void add_block(IndexRange rows, IndexRange cols) {
    for (int r = rows.first; r <= rows.last; ++r) {
      for (int c = cols.first; c <= cols.last; ++c) add_texel(r, c);
    }
  }
  void add_corner(const std::string& name) {
    require_open(true, name);
    require_open(false, name);
    if (name == "all") {
      for (const char* corner : {"first_first", "first_last", "last_first", "last_last"})
        add_corner(corner);
      return;
    }
    add_texel(name.starts_with("last_") ? patch().rows - 1 : 0,
              name.ends_with("_last") ? patch().cols - 1 : 0);
  }
  void add_edge(const std::string& name) {
    const bool is_row = name.ends_with("_row");
    require_open(!is_row, name);
    const int index = name.starts_with("first") ? 0 : (is_row ? patch().rows : patch().cols) - 1;
    const IndexRange all_rows{0, patch().rows - 1}, all_cols{0, patch().cols - 1};
    if (is_row) add_block({index, index}, all_cols);
    if (!is_row) add_block(all_rows, {index, index});
  }
  void add_region(std::span<const Vec3> points, const Vec3& lowest, const Vec3& highest) {
    const Eigen::AlignedBox3d box = selecting_box(lowest, highest, points);
    for (int i = 0; i < atlas_.particle_count(); ++i) {
      if (box.contains(points[i])) particles_.push_back(i);
    }
  }
  const bsi::Patch& patch() const { return atlas_.patches()[patch_]; }
  std::vector<int> take() {
    std::sort(particles_.begin(), particles_.end());
    particles_.erase(std::unique(particles_.begin(), particles_.end()), particles_.end());
    return std::move(particles_);
  }

 private:
  void require_open(bool u_axis, const std::string& name) const {
    if (u_axis ? patch().wrap_u : patch().wrap_v) {
      throw CaseError(where_,
                      "the shape is closed along its " + std::string(u_axis ? "columns" : "rows") +
                          ": it has no \"" + name + "\"",
                      "expected rows, cols or a region instead");
    }
  }

  int patch_;
  const SourceLocation& where_;
  const bsi::Atlas& atlas_;
  std::vector<int> particles_;
};

}  // namespace

// Points of splines and of rotated shapes are rounded.
Eigen::AlignedBox3d selecting_box(const Vec3& lowest, const Vec3& highest,
                                  std::span<const Vec3> points) {
  Eigen::AlignedBox3d around;
  for (const Vec3& point : points) around.extend(point);
  const Vec3 margin = Vec3::Constant(box_margin * around.diagonal().norm());
  return {lowest - margin, highest + margin};
}

std::vector<int> select_vertices(const VertexSelection& vertices, const SourceLocation& where,
                                 const std::string& owner, const bsi::Atlas& atlas,
                                 std::span<const Vec3> points) {
  Selection selection(vertices.patch, where, atlas);
  for (const std::string& corner : vertices.corners) selection.add_corner(corner);
  for (const std::string& edge : vertices.edges) selection.add_edge(edge);
  if (!vertices.rows.empty() || !vertices.cols.empty()) {
    const bsi::Patch& patch = selection.patch();
    selection.add_block(resolve_range(vertices.rows, patch.rows, owner, "rows", where),
                        resolve_range(vertices.cols, patch.cols, owner, "cols", where));
  }
  if (vertices.region_min && vertices.region_max)
    selection.add_region(points, *vertices.region_min, *vertices.region_max);
  std::vector<int> particles = selection.take();
  if (particles.empty()) {
    throw CaseError(where, "this " + owner + " selects no vertex",
                    "expected a region that holds at least one vertex at t = 0");
  }
  return particles;
}

std::vector<int> select_vertices(const VertexSelection& vertices, const SourceLocation& where,
                                 const std::string& owner, const SceneBody& body,
                                 std::span<const Vec3> positions) {
  if (!vertices.region_min) return select_vertices(vertices, where, owner, body.atlas, {});
  std::vector<Vec3> room;
  return select_vertices(vertices, where, owner, body.atlas,
                         map_to_image(body).points_of(positions, body.particle_count(), room));
}

}  // namespace weft::sim
