// Quantities of a frame that expressions call like functions: position('cloth', 0, -1).z
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim/expression/expression_tokens.h"
#include "sim/trajectory/trajectory.h"

namespace weft::sim {

// A number of each frame, computed from what a trajectory holds.
//
//   position('BODY', ROW, COLUMN)          m, vector: place of a texel
//   displacement('BODY', ROW, COLUMN)      m, vector: from its place in the first frame
//   field('FIELD', 'BODY', ROW, COLUMN)    value of a recorded field at a texel
//   largest('FIELD', 'BODY'), smallest     extremes of a field over a body, vectors by magnitude
//   lower('BODY'), upper, size             m, vector: corners of the bounding box and its edges
//   shadow('BODY')                         m^2, by axis: area of the shadow along x, y or z
//   area('BODY')                           m^2: area of the surface
//   record('PATH')                         value of a record, such as reactions/cloth/pin_1/force
//
// A texel of a body of several patches has its patch before its row. Rows and columns count from 0
// in the whole image, or from -1 backwards from the last recorded one. .x, .y, .z or .length
// follows a vector.
struct RecordedQuantity {
  enum class Kind {
    position,
    displacement,
    field,
    largest,
    smallest,
    lower,
    upper,
    size,
    shadow,
    area,
    record
  };
  // Part of a vector, or the number itself.
  enum class Part { x, y, z, length, number };

  Kind kind = Kind::position;
  int body = -1;      // index into TrajectoryContents::bodies; -1 for records
  int particle = -1;  // particle of a texel, or -1
  std::string name;   // name of a field or path of a record
  int components = 1;
  Part part = Part::number;
};

// A quantity and the first token behind its call.
struct QuantityCall {
  RecordedQuantity quantity;
  std::size_t end = 0;
};

// Returns the names of the functions for quantities.
std::vector<std::string> quantity_names();

// Reads the call that starts with the name at `first` and whose bracket closes at `close`. Throws
// CaseError for arguments that are wrong in number or kind, for a body, field, record or texel that
// is not in `contents`, and for a part that the quantity does not have.
QuantityCall read_quantity(const LocatedText& expression, std::span<const Token> tokens,
                           std::size_t first, std::size_t close,
                           const TrajectoryContents& contents);

}  // namespace weft::sim
