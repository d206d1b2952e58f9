#include "sim/case/case_shape_checks.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>

#include "sim/case/case_error.h"
#include "sim/case/case_schema.h"
#include "sim/case/case_text.h"

namespace weft::sim {

namespace {

// Upper limit of a body's vertices; it keeps every index well within an int.
constexpr int most_vertices = 100'000'000;

// Size of a shape's image; 64 bits hold any resolution that an int can express.
struct ImageSize {
  std::int64_t patches;
  std::int64_t rows;
  std::int64_t cols;

  // Number of vertices. The product of three sizes may exceed 64 bits, so it is a double.
  double vertices() const {
    return static_cast<double>(patches) * static_cast<double>(rows) * static_cast<double>(cols);
  }
};

// Returns the size of a shape's image; nothing for a shape from a file, whose size is known only
// once it is opened. Precondition: the resolution is checked.
std::optional<ImageSize> image_size(const ShapeCase& shape) {
  if (shape.type == ShapeType::file) return std::nullopt;
  const std::int64_t n = shape.resolution[0];
  if (shape.type == ShapeType::sphere) return ImageSize{6, n, n};
  if (shape.type == ShapeType::blob) return ImageSize{48, 2 * n - 1, n};
  return ImageSize{1, n, shape.resolution[1]};
}

void check_resolution(const ShapeCase& shape, const std::string& path, const Locations& locations) {
  const std::string place = join_path(path, "resolution");
  const bool has_square_faces = shape.type == ShapeType::sphere || shape.type == ShapeType::blob;
  if (shape.resolution.size() != (has_square_faces ? 1U : 2U)) {
    throw CaseError(locations.value(place),
                    "\"resolution\" is an array of " + std::to_string(shape.resolution.size()),
                    has_square_faces ? "expected [n], the vertices along an edge of each patch"
                                     : "expected [rows, cols]");
  }
  const bool is_torus = shape.type == ShapeType::torus;
  const bool is_cylinder = shape.type == ShapeType::cylinder;
  if (is_torus && shape.resolution[0] < 3) {
    throw CaseError(locations.value(join_path(place, 0)),
                    "a torus of " + std::to_string(shape.resolution[0]) + " rows",
                    "expected at least 3: rows go around the axis");
  }
  if ((is_torus || is_cylinder) && shape.resolution[1] < 3) {
    throw CaseError(locations.value(join_path(place, 1)),
                    std::string(is_torus ? "a torus" : "a cylinder") + " of " +
                        std::to_string(shape.resolution[1]) + " columns",
                    "expected at least 3: columns go around");
  }
  if (image_size(shape)->vertices() > most_vertices) {
    throw CaseError(locations.value(place), "too many vertices",
                    "expected at most " + std::to_string(most_vertices));
  }
}

class PinChecker {
 public:
  PinChecker(const PinCase& pin, const ShapeCase& shape, const std::string& path,
             const Locations& locations)
      : pin_(pin), size_(image_size(shape)), path_(path), locations_(locations) {}

  void check() const {
    const bool in_image =
        !pin_.corners.empty() || !pin_.edges.empty() || !pin_.rows.empty() || !pin_.cols.empty();
    if (!in_image && !pin_.region_min && !pin_.region_max) {
      throw CaseError(locations_.value(path_), "the pin holds nothing",
                      "expected corners, edges, rows, cols, or region_min and region_max");
    }
    repeats("corners", pin_.corners);
    repeats("edges", pin_.edges);
    if (size_) {
      patch();
      block("rows", pin_.rows, size_->rows);
      block("cols", pin_.cols, size_->cols);
    }
    order("rows", pin_.rows);
    order("cols", pin_.cols);
    region();
    if (!in_image && pin_.patch != 0) {
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
    if (pin_.patch < size_->patches) return;
    fail("patch", "patch " + std::to_string(pin_.patch) + " of " + std::to_string(size_->patches),
         "expected 0" +
             (size_->patches > 1 ? " to " + std::to_string(size_->patches - 1) : std::string()));
  }

  void block(const std::string& key, const std::vector<int>& range, std::int64_t size) const {
    for (std::size_t i = 0; i < range.size(); ++i) {
      if (range[i] >= -size && range[i] < size) continue;
      fail(join_path(key, i),
           "no " + std::string(key == "rows" ? "row " : "column ") + std::to_string(range[i]),
           "expected " + std::to_string(-size) + " to " + std::to_string(size - 1));
    }
  }

  // Refuses an empty range. A negative index compares with a positive one only if the size is
  // known.
  void order(const std::string& key, const std::vector<int>& range) const {
    if (range.empty()) return;
    std::int64_t first = range[0];
    std::int64_t last = range[1];
    if (size_) {
      const std::int64_t size = key == "rows" ? size_->rows : size_->cols;
      if (first < 0) first += size;
      if (last < 0) last += size;
    } else if ((first < 0) != (last < 0)) {
      return;
    }
    if (first > last)
      fail(key, "an empty range of " + key, "expected [first, last], first <= last");
  }

  void region() const {
    if (pin_.region_min && !pin_.region_max) {
      fail("region_min", "region_min without region_max", "expected both corners of the box");
    }
    if (pin_.region_max && !pin_.region_min) {
      fail("region_max", "region_max without region_min", "expected both corners of the box");
    }
    if (!pin_.region_min) return;
    for (int axis = 0; axis < 3; ++axis) {
      if ((*pin_.region_min)[axis] <= (*pin_.region_max)[axis]) continue;
      fail(join_path("region_max", static_cast<std::size_t>(axis)), "an empty region",
           "expected region_min <= region_max along each axis");
    }
  }

  const PinCase& pin_;
  std::optional<ImageSize> size_;
  const std::string& path_;
  const Locations& locations_;
};

}  // namespace

void check_shape(const ShapeCase& shape, const std::string& path, const std::string& case_path,
                 const Locations& locations) {
  if (shape.type == ShapeType::file) {
    const auto file = std::filesystem::path(case_path).parent_path() / shape.path;
    std::error_code ignored;  // an inaccessible path is no usable file either
    if (std::filesystem::is_regular_file(file, ignored)) return;
    throw CaseError(locations.value(join_path(path, "path")), "no file " + in_quotes(shape.path),
                    "expected an HDF5 file, here " + file.string());
  }
  check_resolution(shape, path, locations);
  if (shape.type == ShapeType::torus && *shape.minor_radius >= *shape.major_radius) {
    throw CaseError(locations.value(join_path(path, "minor_radius")),
                    "minor_radius is " + number_text(*shape.minor_radius) + " m",
                    "expected less than major_radius, " + number_text(*shape.major_radius) + " m");
  }
}

std::optional<double> vertices_of(const ShapeCase& shape) {
  const auto size = image_size(shape);
  return size ? std::optional(size->vertices()) : std::nullopt;
}

void check_pin(const PinCase& pin, const ShapeCase& shape, const std::string& path,
               const Locations& locations) {
  PinChecker(pin, shape, path, locations).check();
}

}  // namespace weft::sim
