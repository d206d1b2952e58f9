#include "sim/scene/pins.h"

#include <algorithm>

#include "sim/case/case_error.h"

namespace weft::sim {

namespace {

struct IndexRange {
  int first = 0, last = -1;
};

IndexRange resolve_range(const PinCase& pin, const std::vector<int>& range, int count,
                         const char* axis) {
  if (range.empty()) return {0, count - 1};
  const auto from_end = [&](int i) { return i < 0 ? i + count : i; };
  const IndexRange resolved{from_end(range.front()), from_end(range.back())};
  if (resolved.first < 0 || resolved.last >= count || resolved.first > resolved.last) {
    throw CaseError(pin.location,
                    std::string("pin ") + axis + " [" + std::to_string(range.front()) + ", " +
                        std::to_string(range.back()) + "] lie outside the image",
                    "expected first <= last within 0.." + std::to_string(count - 1) +
                        ", or counted from the end: -1 is the last");
  }
  return resolved;
}

class Selection {
 public:
  Selection(const PinCase& pin, const bsi::Atlas& atlas) : pin_(pin), atlas_(atlas) {
    if (pin.patch < 0 || pin.patch >= static_cast<int>(atlas.patches().size())) {
      throw CaseError(pin.location, "the body has no patch " + std::to_string(pin.patch),
                      "expected 0.." + std::to_string(atlas.patches().size() - 1));
    }
  }

  void add_texel(int row, int col) { particles_.push_back(atlas_.particle(pin_.patch, row, col)); }
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
  void add_region(std::span<const Vec3> positions, const Vec3& lowest, const Vec3& highest) {
    for (int i = 0; i < atlas_.particle_count(); ++i) {
      if ((positions[i].array() >= lowest.array()).all() &&
          (positions[i].array() <= highest.array()).all()) {
        particles_.push_back(i);
      }
    }
  }
  const bsi::Patch& patch() const { return atlas_.patches()[pin_.patch]; }
  std::vector<int> take() {
    std::sort(particles_.begin(), particles_.end());
    particles_.erase(std::unique(particles_.begin(), particles_.end()), particles_.end());
    return std::move(particles_);
  }

 private:
  void require_open(bool u_axis, const std::string& name) const {
    if (u_axis ? patch().wrap_u : patch().wrap_v) {
      throw CaseError(pin_.location,
                      "the shape is closed along its " + std::string(u_axis ? "columns" : "rows") +
                          ": it has no \"" + name + "\"",
                      "expected rows, cols or a region instead");
    }
  }

  const PinCase& pin_;
  const bsi::Atlas& atlas_;
  std::vector<int> particles_;
};

}  // namespace

std::vector<int> select_pinned(const PinCase& pin, const bsi::Atlas& atlas,
                               std::span<const Vec3> positions) {
  Selection selection(pin, atlas);
  for (const std::string& corner : pin.corners) selection.add_corner(corner);
  for (const std::string& edge : pin.edges) selection.add_edge(edge);
  if (!pin.rows.empty() || !pin.cols.empty()) {
    selection.add_block(resolve_range(pin, pin.rows, selection.patch().rows, "rows"),
                        resolve_range(pin, pin.cols, selection.patch().cols, "cols"));
  }
  if (pin.region_min && pin.region_max)
    selection.add_region(positions, *pin.region_min, *pin.region_max);
  std::vector<int> particles = selection.take();
  if (particles.empty()) {
    throw CaseError(pin.location, "this pin selects no vertex",
                    "expected a region that holds at least one vertex at t = 0");
  }
  return particles;
}

}  // namespace weft::sim
