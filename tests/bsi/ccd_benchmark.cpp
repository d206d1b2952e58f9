#include "tests/bsi/ccd_benchmark.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace weft::bsi {

std::vector<BenchmarkQuery> read_ccd_benchmark(const std::string& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".csv") files.push_back(entry.path());
  std::ranges::sort(files);
  std::vector<BenchmarkQuery> queries;
  for (const std::filesystem::path& path : files) {
    std::ifstream file(path);
    std::string line;
    for (int row = 0; std::getline(file, line); ++row) {
      if (line.empty()) continue;
      if (row % 8 == 0) {
        queries.emplace_back();
        queries.back().place = path.string() + ", query " + std::to_string(row / 8);
        if (path.parent_path().filename() == "edge-edge")
          queries.back().kind = FeatureKind::edge_edge;
      }
      std::array<std::string, 7> cell;
      std::istringstream cells(line);
      for (std::string& text : cell) std::getline(cells, text, ',');
      BenchmarkQuery& query = queries.back();
      Vec3& point = (row % 8 < 4 ? query.start : query.end)[row % 4];
      for (int axis = 0; axis < 3; ++axis) {
        const long double value = std::strtold(cell[2 * axis].c_str(), nullptr) /
                                  std::strtold(cell[2 * axis + 1].c_str(), nullptr);
        point[axis] = static_cast<double>(value);
        EXPECT_EQ(static_cast<long double>(point[axis]), value) << path << ":" << row + 1;
      }
      query.collides = cell[6][0] == '1';
    }
  }
  return queries;
}

}  // namespace weft::bsi
