#include <algorithm>
#include <cassert>
#include <chrono>
#include <filesystem>
#include <string_view>
#include <thread>

#include "sim/trajectory/hdf5_handle.h"
#include "sim/trajectory/trajectory.h"

namespace weft::sim {
namespace {

using hdf5::Access;
using hdf5::Handle;
using hdf5::make_space;

// Without locks, which a writer does not set either and some network file systems refuse.
Handle open_for_reading(const Access& access) {
  std::error_code error;
  const auto status = std::filesystem::status(access.path(), error);
  if (!std::filesystem::exists(status)) access.reject("no such file");
  if (std::filesystem::is_directory(status)) access.reject("is a directory");
  const Handle file_access(H5Pcreate(H5P_FILE_ACCESS));
#if H5_VERSION_GE(1, 10, 7)
  H5Pset_file_locking(file_access.get(), false, true);
#endif
  // HDF5 asks for the file's size first and reads what it should be at least after that: a file
  // that grows in between looks truncated. One that has grown is worth another try.
  for (;;) {
    const auto size = std::filesystem::file_size(access.path(), error);
    const hid_t file = H5Fopen(access.path().c_str(), H5F_ACC_RDONLY, file_access.get());
    if (file >= 0) return Handle(file);
    if (std::filesystem::file_size(access.path(), error) == size) {
      access.fail("open as an HDF5 file");
    }
  }
}

// A piece of metadata that a running writer replaces just as it is read has a wrong checksum, and
// is whole a moment later. One that stays wrong is broken. The pauses double, since HDF5 1.10 loses
// a kilobyte of memory with every attempt that fails.
constexpr std::chrono::milliseconds patience(250), first_pause(1);

template <class Read>
auto read_whole(const Read& read) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  for (auto pause = first_pause;; pause *= 2) {
    try {
      return read();
    } catch (const TrajectoryError& error) {
      const bool is_torn = std::string_view(error.what()).find("checksum") != std::string::npos;
      if (!is_torn || std::chrono::steady_clock::now() > deadline) throw;
    }
    std::this_thread::sleep_for(pause);
  }
}

// Frames that are complete. HDF5 takes addresses beyond the end that the file had when it was
// opened for errors, so the frames of a run that goes on are counted first, and the file is then
// opened again to read them.
hsize_t count_frames(const Access& access) {
  const Handle file = open_for_reading(access);
  if (H5Lexists(file.get(), "time", H5P_DEFAULT) <= 0) return 0;
  const std::vector<hsize_t> shape =
      access.dimensions(access.open_dataset(file.get(), "time").get());
  return shape.empty() ? 0 : shape[0];
}

std::vector<Vec3> to_vectors(const std::vector<double>& values) {
  std::vector<Vec3> result(values.size() / 3);
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i] = Vec3(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
  }
  return result;
}

// Rows, columns and patches are indices of a texel, so their product must be an int; the file may
// say anything.
constexpr hsize_t largest_texel_count = 1 << 30;

bool is_image(const std::vector<hsize_t>& shape) {
  if (shape.size() < 3 || shape.size() > 4 || shape.back() != 3) return false;
  hsize_t count = 1;
  for (std::size_t i = 0; i + 1 < shape.size(); ++i) {
    if (shape[i] == 0 || shape[i] > largest_texel_count) return false;
    count *= shape[i];
    if (count > largest_texel_count) return false;
  }
  return true;
}

bool holds_numbers(hid_t dataset) {
  const Handle type(H5Dget_type(dataset));
  const H5T_class_t kind = H5Tget_class(type.get());
  return kind == H5T_FLOAT || kind == H5T_INTEGER;
}

}  // namespace

struct TrajectoryReader::Implementation {
  explicit Implementation(const std::string& path) : access(path) {}

  void read_header();
  TrajectoryBody read_body(const std::string& name) const;
  std::vector<int> read_particles(hid_t group, std::size_t texels) const;
  std::vector<double> read_list(const std::string& name, hsize_t count) const;
  std::vector<Vec3> read_image(int body, int frame, const std::string& name) const;

  Access access;
  Handle file;
  std::vector<double> times;
  std::string title, weft_version, case_text;
  std::vector<TrajectoryBody> bodies;
  std::vector<TrajectoryWriter::Series> series;
};

void TrajectoryReader::Implementation::read_header() {
  const hsize_t frames = count_frames(access);
  file = open_for_reading(access);
  if (H5Aexists(file.get(), "format") <= 0 ||
      access.read_string(file.get(), "format") != "weft-trajectory") {
    access.reject("is an HDF5 file, but not a Weft trajectory");
  }
  const std::vector<int> version = access.read_integers(file.get(), "version");
  if (version != std::vector<int>{1}) access.reject("is of a newer format than this Weft reads");
  title = access.read_string(file.get(), "title");
  weft_version = access.read_string(file.get(), "weft_version");

  const Handle text = access.open_dataset(file.get(), "case");
  const Handle type(H5Dget_type(text.get()));
  const Handle space(H5Dget_space(text.get()));
  if (H5Tis_variable_str(type.get()) <= 0 || H5Sget_simple_extent_npoints(space.get()) != 1) {
    access.reject("dataset case is not a string");
  }
  char* contents = nullptr;
  access.check(H5Dread(text.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, &contents),
               "read the case");
  case_text = contents == nullptr ? "" : contents;
  H5free_memory(contents);

  times = read_list("time", frames);
  const Handle body_group = access.open_group(file.get(), "body");
  for (const std::string& name : access.members(body_group.get())) {
    bodies.push_back(read_body(name));
  }
  const Handle series_group = access.open_group(file.get(), "series");
  for (const std::string& name : access.members(series_group.get())) {
    const Handle dataset = access.open_dataset(series_group.get(), name);
    series.push_back({name, access.read_string(dataset.get(), "units")});
  }
}

std::vector<int> TrajectoryReader::Implementation::read_particles(hid_t group,
                                                                  std::size_t texels) const {
  if (H5Lexists(group, "particle", H5P_DEFAULT) <= 0) return {};
  const Handle dataset = access.open_dataset(group, "particle");
  const Handle space(H5Dget_space(dataset.get()));
  if (H5Sget_simple_extent_npoints(space.get()) != static_cast<hssize_t>(texels)) {
    access.reject("particle and position have different sizes");
  }
  std::vector<int> particles(texels);
  access.check(
      H5Dread(dataset.get(), H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, particles.data()),
      "read particle");
  return particles;
}

TrajectoryBody TrajectoryReader::Implementation::read_body(const std::string& name) const {
  const Handle group = access.open_group(file.get(), "body/" + name);
  TrajectoryBody body;
  body.name = name;
  body.moves = access.read_integers(group.get(), "moves") != std::vector<int>{0};
  body.is_obstacle = access.read_integers(group.get(), "obstacle") != std::vector<int>{0};
  body.thickness = access.read_double(group.get(), "thickness_m");
  const std::vector<int> wrap_u = access.read_integers(group.get(), "wrap_u");
  const std::vector<int> wrap_v = access.read_integers(group.get(), "wrap_v");

  const Handle position = access.open_dataset(group.get(), "position");
  std::vector<hsize_t> shape = access.dimensions(position.get());
  if (body.moves && !shape.empty()) {
    if (shape[0] < times.size()) access.reject("body " + name + " lacks frames");
    shape.erase(shape.begin());
  }
  if (!is_image(shape)) access.reject("body " + name + " is not an image of positions");
  const std::size_t patch_count = shape.size() == 4 ? shape[0] : 1;
  if (wrap_u.size() != patch_count || wrap_v.size() != patch_count) {
    access.reject("body " + name + " has wraps for another number of patches");
  }
  bsi::Patch patch;
  patch.rows = static_cast<int>(shape[shape.size() - 3]);
  patch.cols = static_cast<int>(shape[shape.size() - 2]);
  std::vector<bsi::Patch> patches(patch_count, patch);
  for (std::size_t p = 0; p < patch_count; ++p) {
    patches[p].wrap_u = wrap_u[p] != 0;
    patches[p].wrap_v = wrap_v[p] != 0;
  }
  const std::size_t texels = patch_count * static_cast<std::size_t>(patch.texel_count());
  try {
    body.atlas = bsi::Atlas(std::move(patches), read_particles(group.get(), texels));
  } catch (const std::invalid_argument& error) {
    access.reject("body " + name + ": " + error.what());
  }
  return body;
}

// The first `count` of what may have become more.
std::vector<double> TrajectoryReader::Implementation::read_list(const std::string& name,
                                                                hsize_t count) const {
  const Handle dataset = access.open_dataset(file.get(), name);
  const std::vector<hsize_t> shape = access.dimensions(dataset.get());
  if (shape.size() != 1 || !holds_numbers(dataset.get())) {
    access.reject("dataset " + name + " is not a list of numbers");
  }
  if (shape[0] < count) access.reject("dataset " + name + " lacks frames");
  std::vector<double> values(count);
  if (values.empty()) return values;
  const std::string action = "read dataset " + name;
  const Handle source = access.handle(H5Dget_space(dataset.get()), action);
  const hsize_t start = 0;
  access.check(H5Sselect_hyperslab(source.get(), H5S_SELECT_SET, &start, nullptr, &count, nullptr),
               action);
  access.check(H5Dread(dataset.get(), H5T_NATIVE_DOUBLE, make_space({count}).get(), source.get(),
                       H5P_DEFAULT, values.data()),
               action);
  return values;
}

// Values of one frame by particle: each particle has that of a texel that holds it.
std::vector<Vec3> TrajectoryReader::Implementation::read_image(int body_index, int frame,
                                                               const std::string& name) const {
  assert(body_index >= 0 && body_index < static_cast<int>(bodies.size()));
  const TrajectoryBody& body = bodies[body_index];
  const std::string action = "read " + name + " of body " + body.name;
  const Handle dataset = access.open_dataset(file.get(), "body/" + body.name + "/" + name);
  const Handle source = access.handle(H5Dget_space(dataset.get()), action);
  std::vector<hsize_t> shape = access.dimensions(dataset.get());
  const std::size_t numbers = 3 * static_cast<std::size_t>(body.atlas.texel_count());
  if (body.moves) {
    assert(frame >= 0 && frame < static_cast<int>(times.size()));
    std::vector<hsize_t> start(shape.size(), 0);
    start[0] = static_cast<hsize_t>(frame);
    shape[0] = 1;
    access.check(H5Sselect_hyperslab(source.get(), H5S_SELECT_SET, start.data(), nullptr,
                                     shape.data(), nullptr),
                 action);
  }
  if (H5Sget_select_npoints(source.get()) != static_cast<hssize_t>(numbers)) {
    access.reject("cannot " + action + ": it has another shape than its positions");
  }
  std::vector<double> values(numbers);
  access.check(H5Dread(dataset.get(), H5T_NATIVE_DOUBLE, make_space({numbers}).get(), source.get(),
                       H5P_DEFAULT, values.data()),
               action);
  std::vector<Vec3> texels = to_vectors(values);
  if (body.atlas.is_identity()) return texels;
  std::vector<Vec3> particles(static_cast<std::size_t>(body.atlas.particle_count()));
  for (int t = 0; t < body.atlas.texel_count(); ++t) {
    particles[body.atlas.particle_of_texel(t)] = texels[t];
  }
  return particles;
}

TrajectoryReader::TrajectoryReader(const std::string& path)
    : implementation_(read_whole([&] {
        const hdf5::QuietErrors quiet;
        auto implementation = std::make_unique<Implementation>(path);
        implementation->read_header();
        return implementation;
      })) {}

TrajectoryReader::~TrajectoryReader() = default;

int TrajectoryReader::frames() const { return static_cast<int>(implementation_->times.size()); }

double TrajectoryReader::time(int frame) const {
  assert(frame >= 0 && frame < frames());
  return implementation_->times[frame];
}

std::string TrajectoryReader::title() const { return implementation_->title; }

std::string TrajectoryReader::weft_version() const { return implementation_->weft_version; }

std::string TrajectoryReader::case_text() const { return implementation_->case_text; }

const std::vector<TrajectoryBody>& TrajectoryReader::bodies() const {
  return implementation_->bodies;
}

std::vector<Vec3> TrajectoryReader::positions(int body, int frame) const {
  const hdf5::QuietErrors quiet;
  return read_whole([&] { return implementation_->read_image(body, frame, "position"); });
}

std::vector<Vec3> TrajectoryReader::velocities(int body, int frame) const {
  const hdf5::QuietErrors quiet;
  const std::string name = "body/" + implementation_->bodies.at(body).name + "/velocity";
  if (H5Lexists(implementation_->file.get(), name.c_str(), H5P_DEFAULT) <= 0) return {};
  return read_whole([&] { return implementation_->read_image(body, frame, "velocity"); });
}

std::vector<TrajectoryWriter::Series> TrajectoryReader::series() const {
  return implementation_->series;
}

std::vector<double> TrajectoryReader::series_values(const std::string& name) const {
  const hdf5::QuietErrors quiet;
  const auto is_named = [&](const auto& entry) { return entry.name == name; };
  if (std::ranges::none_of(implementation_->series, is_named)) {
    implementation_->access.reject("has no series " + name);
  }
  return read_whole(
      [&] { return implementation_->read_list("series/" + name, implementation_->times.size()); });
}

TexelFile read_texels(const std::string& path, const std::string& dataset) {
  const hdf5::QuietErrors quiet;
  const Access access(path);
  const Handle file = open_for_reading(access);
  const Handle source = access.open_dataset(file.get(), dataset);
  const std::vector<hsize_t> shape = access.dimensions(source.get());
  if (!is_image(shape) || !holds_numbers(source.get())) {
    access.reject("dataset " + dataset +
                  " must be numbers shaped [rows, cols, 3] or [patches, rows, cols, 3]");
  }
  TexelFile result;
  result.patches = shape.size() == 4 ? static_cast<int>(shape[0]) : 1;
  result.rows = static_cast<int>(shape[shape.size() - 3]);
  result.cols = static_cast<int>(shape[shape.size() - 2]);
  std::vector<double> values(3 * static_cast<std::size_t>(result.patches) *
                             static_cast<std::size_t>(result.rows) *
                             static_cast<std::size_t>(result.cols));
  access.check(
      H5Dread(source.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
      "read dataset " + dataset);
  result.texels = to_vectors(values);
  return result;
}

}  // namespace weft::sim
