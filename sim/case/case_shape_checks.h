// Checks the rules of shapes and of selections of their vertices.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/case/case.h"
#include "sim/case/case_locations.h"

namespace weft::sim {

// Number of vertices along each side of a plane.
constexpr int plane_vertices = 17;

// True for a cone that ends in a point instead of an opening.
inline bool has_apex(const ShapeCase& shape) {
  return shape.type == ShapeType::cone && shape.top_radius == 0;
}

// The check functions below throw CaseError, placed at the value that breaks a rule. For a pin, tie
// or load that selects nothing, the place is its header. `path` is the path of the table in the
// case (case_schema.h). The path of a file shape is relative to the case file `case_path`.
void check_shape(const ShapeCase& shape, const std::string& path, const std::string& case_path,
                 const Locations& locations);
// `rest` is the rest shape of the body with this start.
void check_start(const StartCase& start, const ShapeCase& rest, const std::string& path,
                 const std::string& case_path, const Locations& locations);
// `owner` is "pin", "tie" or "load". `shape` is the shape of the body whose vertices are selected.
void check_selection(const VertexSelection& vertices, const std::string& owner,
                     const ShapeCase& shape, const std::string& path, const Locations& locations);

// Checks ranges [first, last] of rows and columns in the image of a shape. Negative indices count
// from the end. A range without entries passes. `path` is the path of the table with the keys
// `rows` and `cols`.
void check_rows_and_cols(const ShapeCase& shape, const std::vector<int>& rows,
                         const std::vector<int>& cols, const std::string& path,
                         const Locations& locations);

// Returns the number of vertices of a shape. Vertices on a seam count once per patch. Empty for a
// shape from a file, whose size is unknown before the file is opened.
std::optional<double> vertices_of(const ShapeCase& shape);

}  // namespace weft::sim
