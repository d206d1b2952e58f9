#include "sim/run/input_files.h"

#include <filesystem>

#include "sim/case/case_error.h"

namespace weft::sim {

void for_each_input_file(Case& source, const std::function<void(std::string&)>& use) {
  const auto visit = [&](ShapeCase& shape) {
    if (shape.type == ShapeType::file) use(shape.path);
  };
  for (BodyCase& body : source.body) {
    visit(body.shape);
    if (body.start && body.start->shape) visit(*body.start->shape);
  }
  for (ObstacleCase& obstacle : source.obstacle) visit(obstacle.shape);
  for (ParticlesCase& particles : source.particles) {
    if (particles.positions.type == PositionsType::file) use(particles.positions.path);
  }
  if (source.restart) use(source.restart->path);
}

void refuse_input_file(const std::string& path, const Case& source, const std::string& writer) {
  const auto refuse = [&](const std::filesystem::path& file) {
    std::error_code error;
    if (!std::filesystem::equivalent(path, file, error)) return;
    throw CaseError({path}, "the case reads this file, which " + writer + " never changes",
                    "expected the name of a new file");
  };
  refuse(source.path);
  for (const std::string& file : source.included) refuse(file);
  const auto folder = std::filesystem::path(source.path).parent_path();
  Case copy = source;
  for_each_input_file(copy, [&](const std::string& file) { refuse(folder / file); });
}

}  // namespace weft::sim
