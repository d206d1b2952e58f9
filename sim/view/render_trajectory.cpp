#include "sim/view/render_trajectory.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <vector>

#include "gpu/renderer.h"
#include "sim/base/file_status.h"
#include "sim/base/output_folder.h"
#include "sim/case/case_error.h"
#include "sim/case/case_tree.h"
#include "sim/trajectory/leftover_files.h"
#include "sim/trajectory/trajectory.h"
#include "sim/view/movie_file.h"
#include "sim/view/painted_field.h"
#include "sim/view/rendered_body.h"

namespace weft::sim {
namespace {

// The extent of a set of balls and points: its bounding box, and its farthest point in each of 128
// directions. A camera that shows these 128 points shows the whole set: other points lie beyond
// them by at most 2 % of the set's size, which is less than the camera's margin.
class Extent {
 public:
  Extent() : directions_(count, 3), points_(count, Vec3::Zero()) {
    const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));
    for (int i = 0; i < count; ++i) {
      const double height = 1 - 2 * (i + 0.5) / count;
      const double radius = std::sqrt(1 - height * height);
      directions_.row(i) << radius * std::cos(golden_angle * i),
          radius * std::sin(golden_angle * i), height;
    }
  }

  // Adds a ball (m), or a point if the radius is 0.
  void add(const Vec3& centre, double radius = 0) {
    const Eigen::Matrix<double, count, 1> distances = directions_ * centre;
    for (int i = 0; i < count; ++i) {
      if (distances[i] + radius > distances_[i]) {
        distances_[i] = distances[i] + radius;
        points_[i] = centre + radius * directions_.row(i).transpose();
      }
    }
    lowest_ = lowest_.cwiseMin(Vec3(centre.array() - radius));
    highest_ = highest_.cwiseMax(Vec3(centre.array() + radius));
  }

  bool empty() const { return lowest_.x() > highest_.x(); }
  const std::vector<Vec3>& points() const { return points_; }
  const Vec3& lowest() const { return lowest_; }
  const Vec3& highest() const { return highest_; }

 private:
  static constexpr int count = 128;
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  Eigen::Matrix<double, count, 3> directions_;
  Eigen::Matrix<double, count, 1> distances_ = Eigen::Matrix<double, count, 1>::Constant(-infinity);
  std::vector<Vec3> points_;
  Vec3 lowest_ = Vec3::Constant(infinity);
  Vec3 highest_ = Vec3::Constant(-infinity);
};

// The camera shows a whole obstacle if it is at most `whole_obstacle` times as large as the
// simulated bodies. Otherwise it shows the part of the obstacle inside the bounding box of these
// bodies, enlarged on each side by `seen_beyond` of their size.
constexpr double whole_obstacle = 2, seen_beyond = 1.0 / 6;

double size_of(const std::vector<Vec3>& points) {
  Vec3 lowest = points.front(), highest = points.front();
  for (const Vec3& point : points) {
    lowest = lowest.cwiseMin(point);
    highest = highest.cwiseMax(point);
  }
  return (highest - lowest).norm();
}

// Adds the body to the extent, as it is drawn in the frame: its surface or, if a level is given,
// the spheres of that level. Precondition: the frame's positions were read last.
void add_drawn(const TrajectoryReader& reader, int frame, std::optional<int> spheres_of_level,
               RenderedBody& body, Extent& extent) {
  if (!body.radii.empty()) {
    for (std::size_t i = 0; i < body.radii.size(); ++i)
      extent.add(body.positions[i], body.radii[i]);
    return;
  }
  if (!spheres_of_level) {
    for (const Vec3& position : body.positions) extent.add(position);
    return;
  }
  for (const bsi::Sphere& sphere : drawn_spheres(reader, frame, *spheres_of_level, body))
    extent.add(Vec3(sphere.x, sphere.y, sphere.z), sphere.radius);
}

// Returns the extent that the camera must show: all simulated bodies in all frames, and obstacles.
// If an obstacle is too large (see whole_obstacle), only its part near the simulated bodies is
// included. Without simulated bodies, every obstacle is included as a whole.
Extent extent_to_see(const TrajectoryReader& reader, const std::vector<int>& frames,
                     std::optional<int> spheres_of_level, std::vector<RenderedBody>& bodies) {
  Extent simulated;
  for (const int frame : frames) {
    for (RenderedBody& body : bodies) {
      if (body.is_obstacle || (!body.moves && frame != frames.front())) continue;
      read_positions(reader, frame, body);
      add_drawn(reader, frame, spheres_of_level, body, simulated);
    }
  }
  const double size = simulated.empty() ? std::numeric_limits<double>::infinity()
                                        : (simulated.highest() - simulated.lowest()).norm();
  const Vec3 beyond = Vec3::Constant(seen_beyond * size);
  const Vec3 lowest = simulated.lowest() - beyond, highest = simulated.highest() + beyond;
  Extent extent = simulated;
  for (const int frame : frames) {
    for (RenderedBody& body : bodies) {
      if (!body.is_obstacle || (!body.moves && frame != frames.front())) continue;
      read_positions(reader, frame, body);
      if (size_of(body.positions) <= whole_obstacle * size) {
        add_drawn(reader, frame, spheres_of_level, body, extent);
        continue;
      }
      for (const Vec3& position : body.positions)
        extent.add(position.cwiseMax(lowest).cwiseMin(highest));
    }
  }
  return extent;
}

std::string picture_name(int frame) {
  std::array<char, 32> name{};
  std::snprintf(name.data(), name.size(), "frame_%05d.png", frame);
  return name.data();
}

std::string picture_path(const std::string& directory, int frame) {
  return (std::filesystem::path(directory) / picture_name(frame)).string();
}

// Returns frames 0, every, 2 every, ... and the last one.
std::vector<int> frames_to_draw(int count, int every) {
  std::vector<int> frames;
  for (int frame = 0; frame < count - 1; frame += every) frames.push_back(frame);
  if (count > 0) frames.push_back(count - 1);
  return frames;
}

// Returns the number of the frame in a name like "frame_00012.png", or nothing for other names.
std::optional<int> frame_of_name(const std::string& name) {
  int frame = 0, length = 0;
  if (std::sscanf(name.c_str(), "frame_%9d.png%n", &frame, &length) != 1) return {};
  if (length != static_cast<int>(name.size()) || frame < 0) return {};
  return frame;
}

bool is_same_file(const std::string& path, const std::string& other) {
  std::error_code unknown;
  return std::filesystem::equivalent(path, other, unknown);
}

// Removes the pictures of earlier renderings except those of `frames`, and the unfinished pictures
// and movies that killed renderings left. Pictures that no rendering made stay, and the trajectory
// by whatever name.
void remove_older_pictures(const std::string& trajectory, const std::string& directory,
                           const std::vector<int>& frames) {
  std::vector<std::filesystem::path> older;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    if (is_same_file(entry.path().string(), trajectory)) continue;
    const std::string name = entry.path().filename().string();
    const std::string finished = file_of_leftover(name);
    if (finished == movie_name || frame_of_name(finished)) older.push_back(entry.path());
    const std::optional<int> frame = frame_of_name(name);
    if (frame && !std::binary_search(frames.begin(), frames.end(), *frame) &&
        gpu::is_own_png(entry.path().string()))
      older.push_back(entry.path());
  }
  for (const std::filesystem::path& path : older) std::filesystem::remove(path);
}

bool is_in_the_way(const std::string& path, bool is_own) {
  return !is_own && std::filesystem::exists(link_status_of(path));
}

// Throws std::runtime_error if a picture of `frames` or the movie would overwrite a file that no
// rendering made.
void refuse_foreign_files(const std::string& directory, const std::string& movie,
                          const std::vector<int>& frames) {
  const auto refuse = [](const std::string& path) {
    throw std::runtime_error(path +
                             ": was not made by weft render, and is only overwritten by force "
                             "(--force)");
  };
  for (const int frame : frames) {
    const std::string path = picture_path(directory, frame);
    if (is_in_the_way(path, gpu::is_own_png(path))) refuse(path);
  }
  if (is_in_the_way(movie, is_own_movie(movie))) refuse(movie);
}

// Throws RenderUsageError if a picture of `frames` or the movie would replace the trajectory.
void refuse_to_replace(const std::string& trajectory, const std::string& directory,
                       const std::string& movie, const std::vector<int>& frames) {
  const bool is_replaced =
      is_same_file(movie, trajectory) || std::ranges::any_of(frames, [&](int frame) {
        return is_same_file(picture_path(directory, frame), trajectory);
      });
  if (!is_replaced) return;
  throw RenderUsageError(
      "has the name of a picture or the movie, which would replace it; name another folder (-o)");
}

// Returns time.scale of the resolved case, or 1 if the case cannot be read. Nothing else of the
// case is looked at: files that it names may be elsewhere by now.
double time_scale(const TrajectoryReader& reader) {
  try {
    return parse_toml(reader.case_text(), "case").at_path("time.scale").value_or(1.0);
  } catch (const CaseError&) {
    return 1;
  }
}

double movie_rate(const TrajectoryReader& reader, const std::vector<int>& frames,
                  const RenderOptions& options) {
  if (options.frames_per_second) return *options.frames_per_second;
  const double duration = reader.time(frames.back()) - reader.time(frames.front());
  if (!(duration > 0)) return 25;
  const double rate = time_scale(reader) * static_cast<double>(frames.size() - 1) / duration;
  return std::clamp(rate, 1.0, 120.0);
}

// Returns the field that colours the bodies, or nothing if the options name no field.
std::optional<PaintedField> painted_field(const TrajectoryReader& reader,
                                          const std::vector<int>& frames,
                                          const RenderOptions& options) {
  if (!options.colour_field) return {};
  if (options.width < least_legend_width || options.height < least_legend_height) {
    throw RenderUsageError("pictures with a legend are at least " +
                           std::to_string(least_legend_width) + " x " +
                           std::to_string(least_legend_height) + " pixels large, not " +
                           std::to_string(options.width) + " x " + std::to_string(options.height));
  }
  return PaintedField(reader, *options.colour_field, frames, options.colour_range);
}

}  // namespace

RenderReport render_trajectory(const std::string& trajectory, const std::string& directory,
                               const RenderOptions& options) {
  assert(options.every >= 1 && options.frames_per_second.value_or(1) > 0 &&
         options.detail_pixels.value_or(1) > 0 &&
         (!options.colour_field || !options.spheres_of_level));
  const TrajectoryReader reader(trajectory);
  const std::vector<int> frames = frames_to_draw(reader.frames(), options.every);
  if (frames.empty() || reader.bodies().empty()) {
    throw std::runtime_error("'" + trajectory + "' has no complete frame to draw");
  }
  const std::filesystem::path movie_path = std::filesystem::path(directory) / movie_name;
  refuse_to_replace(trajectory, directory, movie_path.string(), frames);
  if (!options.force) {
    refuse_foreign_files(directory, movie_path.string(), frames);
  }
  const std::optional<PaintedField> field = painted_field(reader, frames, options);
  const int scene_width = options.width - (field ? legend_width(options.height) : 0);
  if (options.progress) options.progress(0, static_cast<int>(frames.size()));
  std::vector<RenderedBody> bodies = rendered_bodies(trajectory, reader);
  // The renderer is made before the positions of all frames are read for the camera. A renderer
  // that cannot be made is thus reported at once.
  gpu::Renderer renderer(scene_width, options.height);
  in_output_folder(picture_path(directory, frames.front()));
  const Extent extent = extent_to_see(reader, frames, options.spheres_of_level, bodies);
  const gpu::Camera camera =
      gpu::camera_for_points(extent.points(), static_cast<double>(scene_width) / options.height);
  const bsi::DetailTolerance tolerance =
      gpu::pixel_tolerance(camera, scene_width, options.height, options.detail_pixels.value_or(0));

  RenderReport report;
  if (field) {
    report.least = field->legend().least;
    report.most = field->legend().most;
    report.units = field->legend().units;
    report.plain_bodies = field->plain_bodies();
  }
  for (const int frame : frames) {
    std::vector<gpu::DrawnSurface> surfaces;
    for (RenderedBody& body : bodies) {
      read_positions(reader, frame, body);
      if (field) field->paint(frame, body);
    }
    if (options.spheres_of_level) {
      make_spheres(reader, frame, *options.spheres_of_level, bodies);
    }
    for (RenderedBody& body : bodies) {
      if (options.detail_pixels) {
        reduce_detail(reader, frame, tolerance, body);
      } else if (options.surface_of_level) {
        reduce_to_level(reader, frame, *options.surface_of_level, body);
      }
      add_surfaces(body, surfaces);
      // Particles have no coarser drawing.
      const auto& whole = body.radii.empty() ? body.mesh.triangles : body.spheres.triangles;
      report.all_triangles += static_cast<std::int64_t>(whole.size());
    }
    for (const gpu::DrawnSurface& surface : surfaces) {
      report.triangles += static_cast<std::int64_t>(surface.triangles.size());
    }
    gpu::Picture picture = renderer.draw(surfaces, camera);
    if (field) picture = with_legend(picture, field->legend());
    gpu::write_png(picture_path(directory, frame), picture);
    ++report.pictures;
    if (options.progress) options.progress(report.pictures, static_cast<int>(frames.size()));
  }
  remove_older_pictures(trajectory, directory, frames);
  // An older movie would not match these pictures, so it is removed. A movie that no rendering made
  // stays until a complete one replaces it.
  if (is_own_movie(movie_path.string())) std::filesystem::remove(movie_path);

  report.frames_per_second = movie_rate(reader, frames, options);
  if (!options.movie) return report;
  std::vector<std::string> pictures;
  pictures.reserve(frames.size());
  for (const int frame : frames) pictures.push_back(picture_name(frame));
  const MovieResult movie = write_movie(directory, pictures, report.frames_per_second);
  if (movie.written) report.movie = movie_path.string();
  report.why_no_movie = movie.reason;
  return report;
}

}  // namespace weft::sim
