#include "sim/run/restart.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <stdexcept>

#include "sim/base/file_error.h"
#include "sim/case/case_error.h"
#include "sim/case/case_reader.h"
#include "sim/case/case_text.h"
#include "sim/case/case_tree.h"
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
  for (int t = 0; t < atlas.texel_count(); ++t)
    texels.push_back(by_particle[atlas.particle_of_texel(t)]);
  return texels;
}

class RestartReader {
 public:
  explicit RestartReader(Case& source)
      : source_(source),
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

  StartStates states_of_checkpoint() const {
    Case before = parse_case(reader_.case_text(), source_.path);
    before.accuracy_choice = checkpoint_->accuracy_choice;
    const auto scene = build_scene(before);
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

  Case& source_;
  RestartCase& restart_;
  std::string path_;
  TrajectoryReader reader_;
  std::optional<RunCheckpoint> checkpoint_;
};

}  // namespace

void read_restart(Case& source) {
  if (!source.restart || source.restart->states) return;
  RestartReader(source).read();
}

}  // namespace weft::sim
