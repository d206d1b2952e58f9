#include "sim/command/check_command.h"

#include <filesystem>
#include <iostream>
#include <memory>
#include <vector>

#include "sim/accuracy/accuracy_choice.h"
#include "sim/base/file_error.h"
#include "sim/case/case_error.h"
#include "sim/case/case_reader.h"
#include "sim/case/case_text.h"
#include "sim/case/case_writer.h"
#include "sim/command/guarded_command.h"
#include "sim/run/initial_state.h"
#include "sim/run/input_files.h"
#include "sim/run/output_check.h"
#include "sim/run/restart.h"
#include "sim/run/start_repair.h"
#include "sim/run/start_shapes.h"
#include "sim/view/scene_description.h"
#include "sim/view/start_picture.h"

namespace weft::sim {

namespace {

void draw(const Scene& scene, const CheckCommand& command) {
  std::vector<Crossing> crossings;
  if (scene.source.contact.enabled) {
    std::vector<Vec3> room;
    crossings = forbidden_crossings(
        scene, scene.surface_map.points_of(scene.initial_position, scene.point_count, room));
  }
  const int overlapping = draw_start(scene, crossings, command.picture, command.run.force);
  std::cout << "picture " << printable(command.picture) << ": "
            << counted(std::ssize(crossings), "intersecting pair of triangles",
                       "intersecting pairs of triangles")
            << (crossings.empty() ? "" : ", in red");
  if (overlapping > 0)
    std::cout << "; " << counted(overlapping, "overlapping particle", "overlapping particles")
              << ", in red";
  std::cout << '\n';
}

// Returns the path by which a case names a file: relative to the folder of the case, where it can.
std::string path_in_case(const std::string& path, const Case& source) {
  namespace fs = std::filesystem;
  // Symbolic links are resolved, because a link and ".." after it do not cancel each other.
  return fs::proximate(fs::absolute(path), fs::absolute(source.path).parent_path()).string();
}

void print_repair(const Scene& scene, const StartRepair& repair, const std::string& path) {
  std::cout << "repaired " << counted(repair.crossings, "intersecting pair", "intersecting pairs")
            << " of triangles\n";
  for (const RepairedBody& body : repair.bodies) {
    std::cout << "  " << scene.bodies[body.body].name << ": " << body.moved << " of "
              << counted(scene.bodies[body.body].point_count(), "vertex", "vertices")
              << " moved, by " << rounded_text(1e3 * body.farthest) << " mm at the most\n";
  }
  std::cout << "shapes in " << printable(path)
            << "; the case is unchanged. To start from them, give it\n";
  for (const RepairedBody& body : repair.bodies) {
    const SceneBody& of = scene.bodies[body.body];
    const StartCase start = start_from_file(path, of);
    std::cout << "  --set body." << of.name << ".start='{ shape = { type = \"file\", path = "
              << printable(toml_string(path_in_case(path, scene.source)))
              << ", dataset = " << toml_string(start.shape->dataset)
              << (start.shape->wrap_u ? ", wrap_u = true" : "")
              << (start.shape->wrap_v ? ", wrap_v = true" : "") << " } }'\n";
  }
}

// Throws CaseError unless the case is simulated from the shapes of the file.
void test_repair(const Scene& scene, const StartRepair& repair, const std::string& path) {
  Case repaired = scene.source;
  for (const RepairedBody& body : repair.bodies) {
    repaired.body[scene.case_index(body.body)].start =
        start_from_file(path, scene.bodies[body.body]);
  }
  const std::unique_ptr<const Scene> again = build_scene(repaired);
  if (again->pinned != scene.pinned) {
    throw CaseError(
        {scene.source.path, 0, 0},
        "the initial state is not repaired: a pin with a region would hold other points",
        "expected pins that name rows, columns, edges or corners");
  }
  check_initial_state(*again);
}

void repair(const Scene& scene, const CheckCommand& command) {
  if (!scene.source.contact.enabled && !scene.spheres_collide) {
    throw CaseError({"--fix-initial"}, "without contact, nothing has to be separated",
                    "expected a case with contact.enabled = true");
  }
  refuse_shape_file(command.new_start, scene.source, command.run.force);
  const StartRepair repaired = scene.spheres_collide ? StartRepair{} : repair_start(scene);
  if (repaired.bodies.empty()) {
    // Particles are not moved: where they overlap something, this throws.
    check_initial_state(scene);
    std::cout << "nothing to repair: " << printable(command.new_start) << " is not written\n";
    return;
  }
  std::vector<int> moved;
  for (const RepairedBody& body : repaired.bodies) moved.push_back(body.body);
  const std::string temporary =
      write_start_shapes(command.new_start, scene, moved, repaired.position);
  try {
    test_repair(scene, repaired, temporary);
  } catch (...) {
    std::filesystem::remove(temporary);
    throw;
  }
  std::error_code error;
  std::filesystem::rename(temporary, command.new_start, error);
  if (error) {
    std::filesystem::remove(temporary);
    throw FileError(command.new_start + ": cannot write: " + error.message());
  }
  print_repair(scene, repaired, command.new_start);
}

// Throws CaseError if the picture and the repaired shapes would be the same file.
void require_two_files(const CheckCommand& command) {
  const auto whole = [](const std::string& path) {
    return std::filesystem::absolute(path).lexically_normal();
  };
  if (command.picture.empty() || command.new_start.empty()) return;
  if (whole(command.picture) != whole(command.new_start)) return;
  throw CaseError({"--picture"}, command.picture + " is the file of --fix-initial, too",
                  "expected the names of two files");
}

}  // namespace

int check_case(const CheckCommand& command) {
  return report_faults(command.run, [&](std::optional<std::string>& title) {
    Case source = read_case(command.run.case_path, command.run.overrides);
    title = source.title;
    read_restart(source);
    choose_accuracy(source);
    require_two_files(command);
    if (!command.picture.empty()) refuse_input_file(command.picture, source, "--picture");
    const std::unique_ptr<const Scene> scene = build_scene(source);
    if (!command.picture.empty()) draw(*scene, command);
    if (!command.new_start.empty()) {
      repair(*scene, command);
      return exit_code::done;
    }
    check_initial_state(*scene);
    check_outputs(*scene, false);
    std::cout << printable(describe_scene(*scene), true);
    return exit_code::done;
  });
}

}  // namespace weft::sim
