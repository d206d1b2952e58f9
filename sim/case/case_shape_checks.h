// The rules of shapes, and of pins, which choose from a shape's vertices.
#pragma once

#include <optional>
#include <string>

#include "sim/case/case.h"
#include "sim/case/case_locations.h"

namespace weft::sim {

// Throw CaseError at the value that breaks a rule; at the pin's header where it chooses nothing.
// `path` is the place of the shape or pin in the case (case_schema.h), `case_path` the file that a
// shape's own path is relative to.
void check_shape(const ShapeCase& shape, const std::string& path, const std::string& case_path,
                 const Locations& locations);
void check_pin(const PinCase& pin, const ShapeCase& shape, const std::string& path,
               const Locations& locations);

// Vertices that a shape asks for, counting those along seams once for each patch; nothing for a
// file, whose size is known once it is opened.
std::optional<double> vertices_of(const ShapeCase& shape);

}  // namespace weft::sim
