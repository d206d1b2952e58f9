#include <cstdio>
#include <cstdlib>

#include "sim/base/file_error.h"
#include "sim/scene/texel_file.h"
#include "tests/fuzz/described_hdf5.h"
#include "tests/fuzz/fuzz_readers.h"
#include "tests/fuzz/input_files.h"

namespace weft::sim {

void fuzz_shape(std::string_view input) {
  constexpr double most_bytes = 64 << 20;
  const std::size_t end = std::min(input.find('\n'), input.size());
  const std::string dataset(input.substr(0, end));
  const std::string_view rest = input.substr(std::min(end + 1, input.size()));
  const InputFolder& folder = empty_input_folder();
  const std::string path = folder.path("shape.h5");
  const bool are_bytes = rest.starts_with("\x89HDF");
  if (are_bytes) {
    folder.write("shape.h5", rest);
  } else {
    write_described_file(path, lines_of(rest));
  }
  try {
    const TexelFile file = are_bytes ? read_texels(path, dataset, most_bytes)
                                     : read_texels_unguarded(path, dataset, most_bytes);
    const auto texels = static_cast<double>(file.patches) * file.rows * file.cols;
    if (texels > 0 && texels == static_cast<double>(file.texels.size())) return;
    std::fprintf(stderr, "a shape of other sizes than its texels\n");
    std::abort();
  } catch (const FileError&) {
  }
}

}  // namespace weft::sim
