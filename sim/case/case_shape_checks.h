// Checks of shapes and of selections of their vertices.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/case/case.h"
#include "sim/case/case_locations.h"

namespace weft::sim {

// Number of vertices along each side of a shape of type plane.
constexpr int plane_vertices = 17;

// True if the shape is a cone that ends in a point instead of an opening.
inline bool has_apex(const ShapeCase& shape) {
  return shape.type == ShapeType::cone && shape.top_radius == 0;
}

// Checks a shape. Throws CaseError, placed at the value that breaks a rule. `path` is the shape's
// path in the case (case_schema.h). `case_path` is the path of the case file, to which the path of
// a file with a shape is relative.
void check_shape(const ShapeCase& shape, const std::string& path, const std::string& case_path,
                 const Locations& locations);
// Checks a start, like check_shape(). If the start has no shape, the error is placed at the header
// of its table. `rest` is the rest shape of the same body. `path` is the path of the start in the
// case.
void check_start(const StartCase& start, const ShapeCase& rest, const std::string& path,
                 const std::string& case_path, const Locations& locations);
// Checks a selection of vertices of a body with this shape. Throws CaseError, placed at the value
// that breaks a rule or, if nothing is selected, at the header of the table. `owner` is "pin",
// "tie" or "load"; `path` is the path of its table in the case.
void check_selection(const VertexSelection& vertices, const std::string& owner,
                     const ShapeCase& shape, const std::string& path, const Locations& locations);

// Checks the ranges [first, last] of rows and columns in the image of a shape. Throws CaseError,
// placed at the value that breaks a rule. Negative indices count from the end. An empty vector is
// not checked. `path` is the path of the table with the keys `rows` and `cols`.
void check_rows_and_cols(const ShapeCase& shape, const std::vector<int>& rows,
                         const std::vector<int>& cols, const std::string& path,
                         const Locations& locations);

// Checks a range [first, last] of vertices along an edge of a shape's image, negative from the end;
// an empty range passes. The range is the value of `key` in the table at `path`.
void check_edge_range(const ShapeCase& shape, ImageEdge edge, const std::vector<int>& range,
                      const std::string& path, const std::string& key, const Locations& locations);

// Returns the number of vertices of a shape. Vertices on a seam count once per patch. Returns
// nothing for a shape from a file, whose size is unknown before the file is opened.
std::optional<double> vertices_of(const ShapeCase& shape);

}  // namespace weft::sim
