#include "sim/run/input_files.h"

#include <filesystem>
#include <vector>

#include "sim/case/case_error.h"

namespace weft::sim {

namespace {

std::vector<std::filesystem::path> input_files(const Case& source) {
  const auto folder = std::filesystem::path(source.path).parent_path();
  std::vector<std::filesystem::path> files{source.path};
  const auto add = [&](const std::string& path) {
    if (!path.empty()) files.push_back(folder / path);
  };
  for (const BodyCase& body : source.body) {
    add(body.shape.path);
    if (body.start && body.start->shape) add(body.start->shape->path);
  }
  for (const ObstacleCase& obstacle : source.obstacle) add(obstacle.shape.path);
  for (const ParticlesCase& group : source.particles) add(group.positions.path);
  if (source.restart) add(source.restart->path);
  return files;
}

}  // namespace

void refuse_input_file(const std::string& path, const Case& source, const std::string& writer) {
  std::error_code error;
  for (const std::filesystem::path& file : input_files(source)) {
    if (!std::filesystem::equivalent(path, file, error)) continue;
    throw CaseError({path}, "the case reads this file, which " + writer + " never changes",
                    "expected the name of a new file");
  }
}

}  // namespace weft::sim
