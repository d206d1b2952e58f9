// Writes HDF5 files from descriptions, so that readers meet any structure, whole files as well as
// files that no program of ours would write. Mutations of a description reach what mutations of a
// file's bytes hardly do: those mostly end in HDF5 itself.
#pragma once

#include <string>
#include <vector>

namespace weft::sim {

// Writes the file `path` as the lines say. The words of a line are separated by spaces:
//   group PATH
//   dataset PATH TYPE SHAPE [OPTION ...] [= VALUE ...]
//   attribute PATH NAME TYPE SHAPE [= VALUE ...]
//   link PATH soft|external|hard TARGET
// TYPE is f32, f64, i8, i32, i64, u64, text (of variable length), chars (of 8 bytes) or pair (two
// numbers). SHAPE is `3,4,3`, `-` for a single value or `null` for none. The values are repeated
// until the shape is full. A text has a single value, the rest of the line, in which \n ends a
// line. Options of datasets:
//   chunk=SHAPE   in chunks of this shape, and able to grow along all axes
//   deflate shuffle checksum   filters of the chunks
//   compact       stored in the header
//   external=NAME virtual=NAME   numbers of another file, or of the dataset /source of it
//   empty         without values
//   raw=COUNT     a first chunk of this many zero bytes, whatever the filters say
// Lines of other kinds and lines that HDF5 refuses do nothing. At most 4096 values are written of a
// dataset, those nearest its origin, and none into chunks or datasets of more than a megabyte.
void write_described_file(const std::string& path, const std::vector<std::string>& lines);

}  // namespace weft::sim
