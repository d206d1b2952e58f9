#include "sim/case/case_shape_checks.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <numeric>
#include <optional>

#include "sim/case/case_error.h"
#include "sim/case/case_schema.h"
#include "sim/case/case_text.h"

namespace weft::sim {

namespace {

// Largest number of vertices of a shape, so that the index of a vertex in its shape fits an int.
constexpr int most_vertices = 100'000'000;

// The size of a shape's image. Rows and columns have 64 bits because, for some shapes, they exceed
// the resolution, which is an int.
struct ImageSize {
  std::int64_t patches;  // number of patches, which all have the same rows and columns
  std::int64_t rows;
  std::int64_t cols;

  // Returns the number of vertices, as a double because the product may exceed 64 bits.
  double vertices() const {
    return static_cast<double>(patches) * static_cast<double>(rows) * static_cast<double>(cols);
  }
  // Returns the size in words: "17 x 33 vertices", "6 patches of 9 x 9 vertices".
  std::string text() const {
    return (patches > 1 ? std::to_string(patches) + " patches of " : std::string()) +
           std::to_string(rows) + " x " + std::to_string(cols) + " vertices";
  }
  bool operator==(const ImageSize&) const = default;
};

// Returns the size of the image that make_box() (bsi/shapes.h) gives a box with x, y and z quads
// along its axes. The number of patches is capped at 1e18, because it may exceed 64 bits.
ImageSize block_size(std::int64_t x, std::int64_t y, std::int64_t z) {
  const std::int64_t side = std::gcd(std::gcd(x, y), z);
  const auto tiles = [side](std::int64_t quads) {
    const std::int64_t count = quads / side;
    return static_cast<double>(count);
  };
  const double patches = 2 * (tiles(x) * tiles(y) + tiles(y) * tiles(z) + tiles(z) * tiles(x));
  return {static_cast<std::int64_t>(std::min(patches, 1e18)), side + 1, side + 1};
}

// True if the shape's uncut image is closed: its last column is joined to the first one.
// Precondition: the shape does not come from a file.
bool closes_around(const ShapeCase& shape) {
  switch (shape.type) {
    case ShapeType::annulus:
    case ShapeType::cylinder:
    case ShapeType::sphere_sector:
      return shape.angle_deg == 360;
    case ShapeType::cone:
      return !has_apex(shape);
    default:
      return shape.type == ShapeType::torus;
  }
}

// Returns the number of rows of quads (axis 0) or of columns of quads (axis 1) in a shape's uncut
// image. Precondition: the shape does not come from a file.
std::int64_t quads_along(const ShapeCase& shape, int axis) {
  const bool is_closed = axis == 0 ? shape.type == ShapeType::torus : closes_around(shape);
  return shape.resolution[axis] - (is_closed ? 0 : 1);
}

// Returns the size of a shape's image, cut into ShapeCase::patches if these are given.
ImageSize cut_size(const ShapeCase& shape) {
  ImageSize size{1, shape.resolution[0], shape.resolution[1]};
  if (shape.patches.empty()) return size;
  const std::int64_t n = shape.patches[0], m = shape.patches[1];
  if (n > 1) size.rows = quads_along(shape, 0) / n + 1;
  if (m > 1) size.cols = quads_along(shape, 1) / m + 1;
  size.patches = n * m;
  return size;
}

// Returns the size of a shape's image. Returns nothing for a shape from a file, whose size is
// unknown before the file is opened. Precondition: the resolution has the right number of entries,
// each at least 2.
std::optional<ImageSize> image_size(const ShapeCase& shape) {
  if (shape.type == ShapeType::file) return std::nullopt;
  if (shape.type == ShapeType::plane) return ImageSize{1, plane_vertices, plane_vertices};
  const std::int64_t n = shape.resolution[0];
  const std::int64_t last = shape.resolution.back();
  switch (shape.type) {
    case ShapeType::sphere:
      return ImageSize{6, n, n};
    case ShapeType::disc:
      return ImageSize{12, n, n};
    case ShapeType::cone:
      return has_apex(shape) ? ImageSize{12, n, n} : ImageSize{1, n, last};
    case ShapeType::blob:
      return ImageSize{48, 2 * n - 1, n};
    case ShapeType::box:
      return block_size(n - 1, shape.resolution[1] - 1, last - 1);
    case ShapeType::capsule:
      return block_size(2 * (last - 1), 2 * (last - 1), 2 * (last - 1) + n - 1);
    default:
      return cut_size(shape);
  }
}

// The number of entries that a shape's "resolution" must have, and a hint that explains them.
struct ResolutionEntries {
  std::size_t count;
  const char* hint;
};

ResolutionEntries resolution_entries(const ShapeCase& shape) {
  const ResolutionEntries patch_edge{1, "expected [n], the vertices along an edge of each patch"};
  const ResolutionEntries image{2, "expected [rows, cols]"};
  switch (shape.type) {
    case ShapeType::sphere:
    case ShapeType::disc:
    case ShapeType::blob:
      return patch_edge;
    case ShapeType::cone:
      return has_apex(shape) ? patch_edge : image;
    case ShapeType::capsule:
      return {2,
              "expected [rows, n]: rows of the straight part, vertices along an eighth of the way "
              "around"};
    case ShapeType::box:
      return {3, "expected [x, y, z], the vertices along each axis"};
    default:
      return image;
  }
}

class ShapeChecker {
 public:
  ShapeChecker(const ShapeCase& shape, const std::string& path, const Locations& locations)
      : shape_(shape), path_(path), locations_(locations) {}

  void check() const {
    if (!shape_.size.empty()) size();
    if (shape_.type != ShapeType::plane) {
      resolution();
      closed_axes();
      patches();
    }
    if (shape_.type == ShapeType::torus) {
      below("minor_radius", *shape_.minor_radius, "major_radius", *shape_.major_radius);
    }
    if (shape_.type == ShapeType::annulus) {
      below("inner_radius", *shape_.inner_radius, "outer_radius", *shape_.outer_radius);
    }
    if (shape_.type == ShapeType::sphere_sector) latitudes();
    if (image_size(shape_)->vertices() > most_vertices) {
      fail("resolution", "too many vertices", "expected at most " + std::to_string(most_vertices));
    }
  }

 private:
  [[noreturn]] void fail(const std::string& key, const std::string& message,
                         const std::string& hint) const {
    throw CaseError(locations_.value(join_path(path_, key)), message, hint);
  }

  void size() const {
    const bool is_box = shape_.type == ShapeType::box;
    if (shape_.size.size() == (is_box ? 3U : 2U)) return;
    fail("size", "\"size\" is an array of " + std::to_string(shape_.size.size()),
         is_box ? "expected [x, y, z]" : "expected [x, y]");
  }

  void resolution() const {
    const ResolutionEntries entries = resolution_entries(shape_);
    if (shape_.resolution.size() == entries.count) return;
    fail("resolution", "\"resolution\" is an array of " + std::to_string(shape_.resolution.size()),
         entries.hint);
  }

  void closed_axes() const {
    if (shape_.type == ShapeType::torus && shape_.resolution[0] < 3) {
      fail(join_path("resolution", 0), "a torus of " + counted(shape_.resolution[0], "row", "rows"),
           "expected at least 3: rows go around the axis");
    }
    if (closes_around(shape_) && shape_.resolution[1] < 3) {
      fail(join_path("resolution", 1),
           type_with_article() + " of " + counted(shape_.resolution[1], "column", "columns"),
           "expected at least 3: columns go around");
    }
  }

  void patches() const {
    for (std::size_t axis = 0; axis < shape_.patches.size(); ++axis) {
      const std::int64_t quads = quads_along(shape_, static_cast<int>(axis));
      if (quads % shape_.patches[axis] == 0) continue;
      fail(join_path("patches", axis),
           std::to_string(quads) + (axis == 0 ? " rows" : " columns") +
               " of quads do not divide into " + std::to_string(shape_.patches[axis]) + " patches",
           "expected a divisor of " + std::to_string(quads));
    }
  }

  std::string type_with_article() const {
    switch (shape_.type) {
      case ShapeType::annulus:
        return "an annulus";
      case ShapeType::cylinder:
        return "a cylinder";
      case ShapeType::cone:
        return "a cone";
      case ShapeType::sphere_sector:
        return "a sphere_sector";
      default:
        return "a torus";
    }
  }

  void below(const std::string& smaller, double value, const std::string& larger,
             double limit) const {
    if (value < limit) return;
    fail(smaller, smaller + " is " + number_text(value) + " m",
         "expected less than " + larger + ", " + number_text(limit) + " m");
  }

  void latitudes() const {
    const double south = shape_.latitude_deg[0], north = shape_.latitude_deg[1];
    if (south < north) return;
    fail(join_path("latitude_deg", 1), "latitude_deg ends at " + number_text(north) + " degrees",
         "expected [south, north], north of " + number_text(south) + " degrees");
  }

  const ShapeCase& shape_;
  const std::string& path_;
  const Locations& locations_;
};

// Checks a range of rows or columns. `size` is the number of rows or columns of the image, or empty
// if it is unknown.
class RangeChecker {
 public:
  RangeChecker(std::string key, const std::vector<int>& range, std::optional<std::int64_t> size,
               const std::string& path, const Locations& locations)
      : key_(std::move(key)), range_(range), size_(size), path_(path), locations_(locations) {}

  void check() const {
    if (range_.empty()) return;
    if (size_) bounds(*size_);
    order();
  }

 private:
  [[noreturn]] void fail(const std::string& key, const std::string& message,
                         const std::string& hint) const {
    throw CaseError(locations_.value(join_path(path_, key)), message, hint);
  }

  std::string name_of_item() const {
    if (key_ == "rows") return "row";
    return key_ == "cols" ? "column" : "vertex";
  }

  void bounds(std::int64_t size) const {
    for (std::size_t i = 0; i < range_.size(); ++i) {
      if (range_[i] >= -size && range_[i] < size) continue;
      fail(join_path(key_, i), "no " + name_of_item() + ' ' + std::to_string(range_[i]),
           "expected " + std::to_string(-size) + " to " + std::to_string(size - 1));
    }
  }

  // Refuses an empty range. If the size is unknown, a negative index cannot be compared with one
  // that is not negative, and the range passes.
  void order() const {
    std::int64_t first = range_[0];
    std::int64_t last = range_[1];
    if (size_) {
      if (first < 0) first += *size_;
      if (last < 0) last += *size_;
    } else if ((first < 0) != (last < 0)) {
      return;
    }
    if (first > last)
      fail(key_, "an empty range of " + key_, "expected [first, last], first <= last");
  }

  std::string key_;
  const std::vector<int>& range_;
  std::optional<std::int64_t> size_;
  const std::string& path_;
  const Locations& locations_;
};

class SelectionChecker {
 public:
  SelectionChecker(const VertexSelection& vertices, const std::string& owner,
                   const ShapeCase& shape, const std::string& path, const Locations& locations)
      : vertices_(vertices),
        owner_(owner),
        shape_(shape),
        size_(image_size(shape)),
        path_(path),
        locations_(locations) {}

  void check() const {
    const bool in_image = !vertices_.corners.empty() || !vertices_.edges.empty() ||
                          !vertices_.rows.empty() || !vertices_.cols.empty();
    if (!in_image && !vertices_.region_min && !vertices_.region_max) {
      throw CaseError(locations_.value(path_), "the " + owner_ + " selects nothing",
                      "expected corners, edges, rows, cols, or region_min and region_max");
    }
    repeats("corners", vertices_.corners);
    repeats("edges", vertices_.edges);
    if (size_) patch();
    check_rows_and_cols(shape_, vertices_.rows, vertices_.cols, path_, locations_);
    region();
    if (!in_image && vertices_.patch != 0) {
      fail("patch", "\"patch\" does not go with a region alone",
           "expected corners, edges, rows or cols with it");
    }
  }

 private:
  [[noreturn]] void fail(const std::string& key, const std::string& message,
                         const std::string& hint) const {
    throw CaseError(locations_.value(join_path(path_, key)), message, hint);
  }

  void repeats(const std::string& key, const std::vector<std::string>& names) const {
    for (std::size_t i = 0; i < names.size(); ++i) {
      const bool again = std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(i),
                                   names[i]) != names.begin() + static_cast<std::ptrdiff_t>(i);
      const bool beside_all = names[i] == "all" && names.size() > 1;
      if (again || beside_all) {
        fail(join_path(key, i), in_quotes(names[i]) + (again ? " again" : " beside other corners"),
             again ? "expected each name once" : "expected \"all\" alone");
      }
    }
  }

  void patch() const {
    if (vertices_.patch < size_->patches) return;
    fail("patch",
         "patch " + std::to_string(vertices_.patch) + " of " + std::to_string(size_->patches),
         "expected 0" +
             (size_->patches > 1 ? " to " + std::to_string(size_->patches - 1) : std::string()));
  }

  void region() const {
    if (vertices_.region_min && !vertices_.region_max) {
      fail("region_min", "region_min without region_max", "expected both corners of the box");
    }
    if (vertices_.region_max && !vertices_.region_min) {
      fail("region_max", "region_max without region_min", "expected both corners of the box");
    }
    if (!vertices_.region_min) return;
    for (int axis = 0; axis < 3; ++axis) {
      if ((*vertices_.region_min)[axis] <= (*vertices_.region_max)[axis]) continue;
      fail(join_path("region_max", static_cast<std::size_t>(axis)), "an empty region",
           "expected region_min <= region_max along each axis");
    }
  }

  const VertexSelection& vertices_;
  const std::string& owner_;
  const ShapeCase& shape_;
  std::optional<ImageSize> size_;
  const std::string& path_;
  const Locations& locations_;
};

}  // namespace

void check_shape(const ShapeCase& shape, const std::string& path, const std::string& case_path,
                 const Locations& locations) {
  if (shape.type == ShapeType::file) {
    const auto file = std::filesystem::path(case_path).parent_path() / shape.path;
    std::error_code ignored;  // a path that cannot be accessed counts as no file
    if (std::filesystem::is_regular_file(file, ignored)) return;
    throw CaseError(locations.value(join_path(path, "path")), "no file " + in_quotes(shape.path),
                    "expected an HDF5 file, here " + file.string());
  }
  ShapeChecker(shape, path, locations).check();
}

std::optional<double> vertices_of(const ShapeCase& shape) {
  const auto size = image_size(shape);
  return size ? std::optional(size->vertices()) : std::nullopt;
}

void check_start(const StartCase& start, const ShapeCase& rest, const std::string& path,
                 const std::string& case_path, const Locations& locations) {
  if (!start.shape && !start.bend_radius) {
    throw CaseError(locations.value(path), "the start has no shape",
                    "expected \"shape\" or \"bend_radius\"");
  }
  if (start.bend_radius && *start.bend_radius == 0) {
    throw CaseError(locations.value(join_path(path, "bend_radius")), "a bend of radius 0",
                    "expected a number > 0, or < 0 to bend the borders downwards");
  }
  const std::string direction = join_path(path, "bend_direction_deg");
  if (!start.bend_radius && start.bend_direction_deg) {
    throw CaseError(locations.value(direction), "\"bend_direction_deg\" without a bend",
                    "expected \"bend_radius\" with it");
  }
  if (!start.shape) return;
  const std::string shape_path = join_path(path, "shape");
  check_shape(*start.shape, shape_path, case_path, locations);
  const auto of_rest = image_size(rest), of_start = image_size(*start.shape);
  if (!of_rest || !of_start || *of_rest == *of_start) return;
  throw CaseError(locations.value(shape_path),
                  "the start has " + of_start->text() + ", the rest shape " + of_rest->text(),
                  "expected a shape with as many rows, columns and patches as body.shape has");
}

void check_selection(const VertexSelection& vertices, const std::string& owner,
                     const ShapeCase& shape, const std::string& path, const Locations& locations) {
  SelectionChecker(vertices, owner, shape, path, locations).check();
}

void check_edge_range(const ShapeCase& shape, ImageEdge edge, const std::vector<int>& range,
                      const std::string& path, const std::string& key, const Locations& locations) {
  const std::optional<ImageSize> size = image_size(shape);
  const bool is_row = edge == ImageEdge::first_row || edge == ImageEdge::last_row;
  RangeChecker(key, range, size ? std::optional(is_row ? size->cols : size->rows) : std::nullopt,
               path, locations)
      .check();
}

void check_rows_and_cols(const ShapeCase& shape, const std::vector<int>& rows,
                         const std::vector<int>& cols, const std::string& path,
                         const Locations& locations) {
  const std::optional<ImageSize> size = image_size(shape);
  RangeChecker("rows", rows, size ? std::optional(size->rows) : std::nullopt, path, locations)
      .check();
  RangeChecker("cols", cols, size ? std::optional(size->cols) : std::nullopt, path, locations)
      .check();
}

}  // namespace weft::sim
