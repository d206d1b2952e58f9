// Replays the inputs that fuzzers found worth keeping: each reader must take each of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/fuzz/fuzz_readers.h"

namespace weft::sim::fuzz_corpus_test {
namespace {

struct Reader {
  const char* name;
  void (*read)(std::string_view);
};
std::ostream& operator<<(std::ostream& stream, const Reader& reader) {
  return stream << reader.name;
}

class FuzzCorpus : public testing::TestWithParam<Reader> {
 protected:
  static std::vector<std::filesystem::path> inputs() {
    std::vector<std::filesystem::path> paths;
    const std::string folder = WEFT_SOURCE_DIR "/tests/fuzz/corpus/";
    for (const auto& entry : std::filesystem::directory_iterator(folder + GetParam().name))
      paths.push_back(entry.path());
    std::ranges::sort(paths);
    return paths;
  }
  static std::string bytes_of(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
};

TEST_P(FuzzCorpus, IsReadToItsEnd) {
  EXPECT_GE(inputs().size(), 4);
  for (const std::filesystem::path& path : inputs()) {
    SCOPED_TRACE(path.filename());
    EXPECT_NO_THROW(GetParam().read(bytes_of(path)));
  }
}

// Inputs that are cut off, as a file on a full disk is.
TEST_P(FuzzCorpus, IsReadToAnyByte) {
  const std::string whole = bytes_of(inputs().front());
  for (std::size_t part = 0; part < 16; ++part)
    EXPECT_NO_THROW(GetParam().read(std::string_view(whole).substr(0, part * whole.size() / 16)));
}

std::string name_of(const testing::TestParamInfo<Reader>& info) { return info.param.name; }

INSTANTIATE_TEST_SUITE_P(Readers, FuzzCorpus,
                         testing::Values(Reader{"case", fuzz_case}, Reader{"sweep", fuzz_sweep},
                                         Reader{"shape", fuzz_shape},
                                         Reader{"trajectory", fuzz_trajectory}),
                         name_of);

}  // namespace
}  // namespace weft::sim::fuzz_corpus_test
