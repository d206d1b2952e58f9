#include "sim/run/restart.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/base/file_error.h"
#include "sim/case/case_error.h"
#include "sim/case/case_reader.h"
#include "sim/case/case_text.h"
#include "sim/case/case_tree.h"
#include "sim/case/case_writer.h"
#include "sim/motion/dynamics.h"
#include "sim/run/run_checkpoint.h"
#include "sim/scene/scene.h"
#include "sim/scene/spline_surface.h"
#include "sim/scene/start_states.h"
#include "sim/simulation/simulation.h"
#include "sim/trajectory/frame_copy.h"
#include "sim/trajectory/trajectory.h"

namespace weft::sim {

namespace {

// Smallest gap of a frame as a multiple of the rounding of its positions. Below, the rounding would
// change the forces of contact by more than about a hundredth.
constexpr double least_gap_per_rounding = 100;
// Times are equal if they differ by less than this share.
constexpr double same_time_share = 1e-9;

bool is_same_time(double a, double b) {
  return std::abs(a - b) <= same_time_share * std::max(std::abs(a), std::abs(b));
}

// Returns the values of particles by texel.
std::vector<Vec3> by_texel(const bsi::Atlas& atlas, std::span<const Vec3> by_particle) {
  std::vector<Vec3> texels;
  texels.reserve(atlas.texel_count());
  for (int t = 0; t < atlas.texel_count(); ++t)
    texels.push_back(by_particle[atlas.particle_of_texel(t)]);
  return texels;
}

// Adds the paths of the files that a resolved case reads.
void collect_paths(const toml::node& node, std::vector<std::string>& paths) {
  if (const auto* array = node.as_array()) {
    for (const toml::node& entry : *array) collect_paths(entry, paths);
  } else if (const auto* table = node.as_table()) {
    for (auto&& [key, value] : *table) {
      if (const auto text = value.value<std::string>(); text && key.str() == "path") {
        paths.push_back(*text);
      } else if (key.str() != "outputs") {  // whose keys are names of the user's
        collect_paths(value, paths);
      }
    }
  }
}

// Returns the first file that cannot be read from the folder, or nothing.
std::optional<std::string> missing_file(const std::vector<std::string>& paths,
                                        const std::filesystem::path& folder) {
  for (const std::string& path : paths) {
    std::error_code ignored;  // a path that cannot be accessed counts as no file
    if (!std::filesystem::is_regular_file(folder / path, ignored)) return path;
  }
  return std::nullopt;
}

// Returns the place of restart.path: in the file of the case, or in the override that gave it.
SourceLocation place_of_path(const Case& source) {
  const std::string& path = source.restart->path;
  try {
    const FileText file = read_text(source.path);
    if (!file.fault.empty()) return source.restart->location;
    const toml::table tree = parse_toml(file.text, source.path);
    const toml::node* const node = tree.at_path("restart.path").node();
    if (node != nullptr && node->value<std::string>() == path)
      return sim::location_of(node->source());
  } catch (const CaseError&) {
    return source.restart->location;
  }
  return {"--set restart.path=" + toml_string(path), 0, 0};
}

void read_restart_of(Case& source, int depth);

class RestartReader {
 public:
  // `depth` is the number of runs that start in the state that is read.
  RestartReader(Case& source, int depth)
      : depth_(depth),
        source_(source),
        restart_(*source.restart),
        path_((std::filesystem::path(source.path).parent_path() / restart_.path).string()),
        reader_(readable(path_)),
        checkpoint_(find_checkpoint()) {}

  void read() {
    refuse_creases();
    StartStates states;
    if (checkpoint_ && is_same_time(checkpoint_->reached, restart_.time)) {
      states = states_of_checkpoint();
    } else {
      states = states_of_frame(find_frame());
    }
    check(states);
    restart_.states = std::make_shared<const StartStates>(std::move(states));
  }

 private:
  [[noreturn]] void fail(const std::string& message, const std::string& hint) const {
    throw CaseError(restart_.location, message, hint);
  }
  // Returns the path of a trajectory whose frames do not crash HDF5.
  static const std::string& readable(const std::string& path) {
    require_readable(path, std::numeric_limits<int>::max());
    return path;
  }
  // Returns the checkpoint of the trajectory. Frames serve even if the checkpoint cannot be read.
  std::optional<RunCheckpoint> find_checkpoint() const {
    try {
      return read_checkpoint(path_);
    } catch (const FileError&) {
      return std::nullopt;
    }
  }
  // Returns a hint that names the time of the checkpoint, or `otherwise` without one.
  std::string checkpoint_hint(const std::string& otherwise) const {
    if (!checkpoint_)
      return "expected " + otherwise + "; it has no checkpoint of this version of Weft";
    return "expected time = " + number_text(checkpoint_->reached) + ", the checkpoint of " + path_ +
           ", or " + otherwise;
  }

  void refuse_creases() const {
    for (const BodyCase& body : source_.body) {
      const auto material = std::ranges::find(source_.material, body.material, &MaterialCase::name);
      if (material == source_.material.end() || !material->yields()) continue;
      fail("the creases of \"" + body.name + "\" are not part of a restart",
           "expected a material without yield_curvature");
    }
  }

  int find_frame() const {
    const double time = restart_.time;
    int nearest = -1;
    for (int frame = 0; frame < reader_.frames(); ++frame) {
      if (is_same_time(reader_.time(frame), time)) return frame;
      if (nearest < 0 ||
          std::abs(reader_.time(frame) - time) < std::abs(reader_.time(nearest) - time))
        nearest = frame;
    }
    if (nearest < 0) fail(path_ + " has no frames", checkpoint_hint("another trajectory"));
    fail(path_ + " has no frame at t = " + number_text(time) + " s",
         checkpoint_hint("the time of a frame; the nearest is " +
                         number_text(reader_.time(nearest))));
  }

  StartStates states_of_frame(int frame) const {
    StartStates states;
    double largest = 0;  // largest coordinate of a body that starts here (m)
    for (int b = 0; b < static_cast<int>(reader_.bodies().size()); ++b) {
      const TrajectoryBody& body = reader_.bodies()[b];
      if (std::ranges::find(source_.body, body.name, &BodyCase::name) == source_.body.end())
        continue;
      if (body.is_part())
        fail("body \"" + body.name + "\" is recorded in part", "expected a whole image");
      const std::vector<Vec3> position = reader_.positions(b, frame);
      std::vector<Vec3> velocity(position.size(), Vec3::Zero());
      if (body.moves) velocity = reader_.velocities(b, frame);
      if (velocity.empty()) {
        fail("the frames of body \"" + body.name + "\" have no velocities",
             checkpoint_hint("a trajectory with output.velocity = true"));
      }
      for (const Vec3& point : position) largest = std::max(largest, point.cwiseAbs().maxCoeff());
      states.bodies.push_back(
          {body.name, body.atlas, by_texel(body.atlas, position), by_texel(body.atlas, velocity)});
    }
    refuse_small_gap(frame, largest);
    return states;
  }

  // Refuses a frame whose smallest gap is not much larger than the rounding of its positions.
  void refuse_small_gap(int frame, double largest) const {
    // No more of that case is read: its files may be elsewhere by now.
    const toml::table before = parse_toml(reader_.case_text(), path_);
    const auto text_of = [&](const char* key) {
      return before.at_path(key).value_or(std::string());
    };
    const double gap = reader_.series_values("smallest_gap")[frame];
    double rounding = text_of("output.precision") == "float64"
                          ? 0
                          : largest * std::numeric_limits<float>::epsilon();
    if (text_of("output.compression") == "bounded")
      rounding +=
          before.at_path("output.compression_error").value_or(OutputCase{}.compression_error);
    // Without a pair in reach the gap is no number, and the comparison fails.
    if (!(gap < least_gap_per_rounding * rounding)) return;
    fail("the frame at t = " + number_text(reader_.time(frame)) + " s has a smallest gap of " +
             rounded_text(gap) + " m, and positions rounded by up to " + rounded_text(rounding) +
             " m",
         checkpoint_hint("a trajectory with output.precision = \"float64\""));
  }

  // Returns the folder from which the case of the trajectory reads its files: the one that the
  // trajectory records or, if files were moved, that of the present case.
  std::filesystem::path folder_of_files() const {
    namespace fs = std::filesystem;
    std::vector<std::string> paths;
    collect_paths(parse_toml(reader_.case_text(), path_), paths);
    std::vector<fs::path> folders;
    std::error_code error;
    const fs::path recorded = fs::weakly_canonical(
        fs::canonical(path_, error).parent_path() / reader_.case_folder(), error);
    if (!error && !reader_.case_folder().empty()) folders.push_back(recorded);
    folders.push_back(fs::path(source_.path).parent_path());
    std::string places, missing;
    for (const fs::path& folder : folders) {
      const auto first_missing = missing_file(paths, folder);
      if (!first_missing) return folder;
      if (missing.empty()) missing = *first_missing;
      places += (places.empty() ? "" : " or ") + (folder / *first_missing).string();
    }
    fail("the run of " + path_ + " reads " + in_quotes(missing) + ", which is not there",
         "expected " + places + "; the state of a checkpoint needs the files of its case");
  }

  // Returns the scene of the run whose checkpoint is read.
  std::unique_ptr<const Scene> scene_of_checkpoint() const {
    const std::filesystem::path folder = folder_of_files();
    try {
      const auto name = std::filesystem::path(path_).filename();
      Case before =
          parse_case(without_obsolete_keys(reader_.case_text()), (folder / name).string());
      before.accuracy_choice = checkpoint_->accuracy_choice;
      read_restart_of(before, depth_ + 1);
      return build_scene(before);
    } catch (const CaseError& error) {
      fail("the run of " + path_ + " cannot be set up again: " + error.what(), "");
    }
  }

  StartStates states_of_checkpoint() const {
    const std::unique_ptr<const Scene> scene = scene_of_checkpoint();
    Simulation simulation(*scene);
    try {
      simulation.restore(checkpoint_->simulation);
    } catch (const std::invalid_argument& error) {
      throw FileError(checkpoint_path(path_) + ": " + error.what());
    }
    std::vector<Vec3> position, velocity;
    simulation.dynamics().expand_all(simulation.time(), simulation.state(), position, velocity);
    StartStates states;
    for (const SceneBody& body : scene->bodies) {
      if (body.is_obstacle) continue;
      states.bodies.push_back(
          {body.name, body.atlas, on_image(body, position), on_image(body, velocity)});
    }
    return states;
  }

  // Returns vectors of all particles at the texels of a body, or at the points of a shell's image.
  static std::vector<Vec3> on_image(const SceneBody& body, const std::vector<Vec3>& all) {
    const auto own = std::span(all).subspan(body.first_particle, body.particle_count());
    if (!body.spline) return by_texel(body.atlas, own);
    std::vector<Vec3> room;
    const SurfaceMap map = body.spline->map_to(body.atlas, body.spline->image_places(body.atlas));
    return by_texel(body.atlas, map.points_of(own, body.particle_count(), room));
  }

  void check(const StartStates& states) const {
    std::vector<std::string> names;
    for (const TrajectoryBody& body : reader_.bodies()) names.push_back(body.name);
    for (const BodyCase& body : source_.body) {
      if (states.find(body.name) == nullptr)
        fail(path_ + " has no body " + in_quotes(body.name), name_hint(body.name, names));
    }
  }

  int depth_;
  Case& source_;
  RestartCase& restart_;
  std::string path_;
  TrajectoryReader reader_;
  std::optional<RunCheckpoint> checkpoint_;
};

// Reads the state in which a case starts. Runs that start in each other's states have no end.
void read_restart_of(Case& source, int depth) {
  constexpr int most = 32;
  if (!source.restart || source.restart->states) return;
  if (depth > most) {
    throw CaseError(source.restart->location,
                    "more than " + std::to_string(most) + " runs start in the state of another");
  }
  RestartReader(source, depth).read();
}

}  // namespace

void read_restart(Case& source) {
  try {
    read_restart_of(source, 0);
  } catch (const FileError& error) {
    throw CaseError(place_of_path(source), error.what(),
                    "expected the trajectory of a run as restart.path");
  }
}

}  // namespace weft::sim
