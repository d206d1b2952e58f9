#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string_view>
#include <thread>

#include "sim/base/hdf5_handle.h"
#include "sim/case/channels.h"
#include "sim/scene/spline_axis.h"
#include "sim/trajectory/frame_views.h"
#include "sim/trajectory/trajectory.h"

namespace weft::sim {
namespace {

using hdf5::Access;
using hdf5::Handle;
using hdf5::make_space;

// Time during which a read that a running writer may have disturbed is repeated, and the first
// pause between two attempts. A piece of metadata that a running writer replaces during the read
// has a wrong checksum, but a later read succeeds. Metadata that it adds during the read lies
// beyond the end that the file had when it was opened. If the error stays, the file is damaged.
// Pauses double to limit the number of attempts, because HDF5 1.10 leaks a kilobyte of memory with
// every failed read.
constexpr std::chrono::milliseconds patience(250), first_pause(1);

// True if the file has changed within the last ten seconds, so that a run may be writing it.
bool has_changed_lately(const std::string& path) {
  std::error_code error;
  const auto changed = std::filesystem::last_write_time(path, error);
  return !error &&
         std::filesystem::file_time_type::clock::now() - changed < std::chrono::seconds(10);
}

template <class Read>
auto read_whole(const std::string& path, const Read& read) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  for (auto pause = first_pause;; pause *= 2) {
    try {
      return read();
    } catch (const FileError& error) {
      const std::string_view reason = error.what();
      const bool is_torn = reason.find("checksum") != std::string_view::npos ||
                           reason.find("past end of allocation") != std::string_view::npos;
      const bool is_late = std::chrono::steady_clock::now() > deadline;
      if (!is_torn || is_late || !has_changed_lately(path)) throw;
    }
    std::this_thread::sleep_for(pause);
  }
}

// Opens the file, returns its number of complete frames and closes it again. HDF5 refuses addresses
// beyond the end that the file had when it was opened. If a run is adding frames, all counted
// frames are therefore readable only after the file is opened anew.
hsize_t count_frames(const Access& access) {
  const Handle file = access.open_for_reading();
  if (H5Lexists(file.get(), "time", H5P_DEFAULT) <= 0) return 0;
  const std::vector<hsize_t> shape =
      access.dimensions(access.open_dataset(file.get(), "time").get());
  return shape.empty() ? 0 : shape[0];
}

bool has(hid_t group, const std::string& name) {
  return H5Lexists(group, name.c_str(), H5P_DEFAULT) > 0;
}

// Largest number of pairs of sewn particles. Four numbers per pair can then be counted by an int.
constexpr hsize_t most_pairs = std::numeric_limits<int>::max() / 4;

std::vector<Vec3> to_vectors(const std::vector<double>& values) {
  std::vector<Vec3> result(values.size() / 3);
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i] = Vec3(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
  }
  return result;
}

}  // namespace

struct TrajectoryReader::Implementation {
  explicit Implementation(const std::string& path) : access(path) {}

  void read_header();
  void read_end();
  TrajectoryBody read_body(const std::string& name) const;
  TrajectoryBody read_spheres(const std::string& name) const;
  void read_spline(hid_t group, TrajectoryBody& body) const;
  std::vector<TrajectoryField> read_fields(hid_t group, std::size_t axes) const;
  void read_step_series();
  void find_records(const std::string& group, const std::string& channel);
  std::vector<int> read_particles(hid_t group, std::size_t texels) const;
  void read_sewn();
  std::vector<double> read_list(const std::string& name, hsize_t count, int components = 1) const;
  std::vector<double> read_image(int body, int frame, const std::string& name,
                                 int components) const;

  Access access;
  Handle file;
  std::vector<double> times;
  std::string title, time_units = "s", weft_version, case_text, case_folder;
  bool says_its_end = false;
  std::optional<RunEnd> end;
  std::vector<TrajectoryBody> bodies;
  std::vector<TrajectoryRecord> records;
  std::vector<SewnParticles> sewn;
  std::vector<TrajectoryWriter::Series> series;
  std::vector<TrajectoryWriter::Series> step_series;
  hsize_t steps = 0;  // number of steps that all series of steps have
};

void TrajectoryReader::Implementation::read_header() {
  const hsize_t frames = count_frames(access);
  file = access.open_for_reading();
  if (H5Aexists(file.get(), "format") <= 0 ||
      access.read_string(file.get(), "format") != "weft-trajectory") {
    access.reject("is an HDF5 file, but not a Weft trajectory");
  }
  const std::vector<int> version = access.read_integers(file.get(), "version");
  if (version != std::vector<int>{1}) access.reject("is of a newer format than this Weft reads");
  title = access.read_string(file.get(), "title");
  if (H5Aexists(file.get(), "time_units") > 0)
    time_units = access.read_string(file.get(), "time_units");
  weft_version = access.read_string(file.get(), "weft_version");
  if (H5Aexists(file.get(), "case_folder") > 0)
    case_folder = access.read_string(file.get(), "case_folder");

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

  read_end();
  if (frames > static_cast<hsize_t>(std::numeric_limits<int>::max())) {
    access.reject("dataset time claims more frames than can be numbered");
  }
  times = read_list("time", frames);
  const Handle body_group = access.open_group(file.get(), "body");
  for (const std::string& name : access.members(body_group.get())) {
    bodies.push_back(read_body(name));
  }
  if (has(file.get(), "particles")) {
    const Handle sphere_group = access.open_group(file.get(), "particles");
    for (const std::string& name : access.members(sphere_group.get()))
      bodies.push_back(read_spheres(name));
  }
  read_sewn();
  const Handle series_group = access.open_group(file.get(), "series");
  for (const std::string& name : access.members(series_group.get())) {
    const Handle dataset = access.open_dataset(series_group.get(), name);
    series.push_back({name, access.read_string(dataset.get(), "units")});
  }
  read_step_series();
  for (const Channel& channel : all_channels()) {
    if (channel.home != Channel::Home::texels && has(file.get(), channel.name))
      find_records(channel.name, channel.name);
  }
}

void TrajectoryReader::Implementation::read_step_series() {
  if (!has(file.get(), "steps")) return;
  const Handle group = access.open_group(file.get(), "steps");
  for (const std::string& name : access.members(group.get())) {
    const Handle dataset = access.open_dataset(group.get(), name);
    const std::vector<hsize_t> shape = access.dimensions(dataset.get());
    if (shape.size() != 1) access.reject("dataset steps/" + name + " is not a list of numbers");
    steps = step_series.empty() ? shape[0] : std::min(steps, shape[0]);
    step_series.push_back({name, access.read_string(dataset.get(), "units")});
  }
}

void TrajectoryReader::Implementation::read_sewn() {
  if (!has(file.get(), "sewn")) return;
  const Handle dataset = access.open_dataset(file.get(), "sewn");
  const std::vector<hsize_t> shape = access.dimensions(dataset.get());
  if (shape.size() != 2 || shape[1] != 4 || !hdf5::holds_numbers(dataset.get()))
    access.reject("dataset sewn is not a list of pairs");
  access.require_stored(dataset.get(), "sewn", 4 * static_cast<double>(shape[0]));
  if (shape[0] > most_pairs) access.reject("dataset sewn claims more pairs than can be numbered");
  std::vector<int> numbers(4 * shape[0]);
  access.check(
      H5Dread(dataset.get(), H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()),
      "read sewn");
  const auto is_there = [&](int body, int particle) {
    return body >= 0 && body < static_cast<int>(bodies.size()) && particle >= 0 &&
           particle < bodies[body].atlas.particle_count();
  };
  for (std::size_t i = 0; i < numbers.size(); i += 4) {
    if (!is_there(numbers[i], numbers[i + 1]) || !is_there(numbers[i + 2], numbers[i + 3]))
      access.reject("dataset sewn names a particle that is not there");
    sewn.push_back({numbers[i], numbers[i + 1], numbers[i + 2], numbers[i + 3]});
  }
}

// Adds the records of a channel in `group` and its subgroups to `records`. Rejects subgroups more
// than two levels below the channel's group.
void TrajectoryReader::Implementation::find_records(const std::string& group,
                                                    const std::string& channel) {
  const Handle parent = access.open_group(file.get(), group);
  for (const std::string& name : access.members(parent.get())) {
    std::string path = group + "/";
    path += name;
    H5O_info_t info;
    access.check(H5Oget_info_by_name(file.get(), path.c_str(), &info, hdf5::own_datasets()),
                 "read " + path);
    if (info.type == H5O_TYPE_GROUP) {
      if (std::ranges::count(path, '/') > 2) access.reject("group " + path + " is too deep");
      find_records(path, channel);
      continue;
    }
    const Handle dataset = access.open_dataset(file.get(), path);
    const std::vector<hsize_t> shape = access.dimensions(dataset.get());
    const int components = shape.size() == 2 && shape[1] == 3 ? 3 : 1;
    records.push_back({path, access.read_string(dataset.get(), "units"), channel, components});
  }
}

// Returns the fields among the datasets of a body. Datasets of vectors have `axes` axes, and those
// of numbers have one axis less.
std::vector<TrajectoryField> TrajectoryReader::Implementation::read_fields(hid_t group,
                                                                           std::size_t axes) const {
  std::vector<TrajectoryField> fields;
  for (const std::string& name : access.members(group)) {
    const Handle dataset = access.open_dataset(group, name);
    // Files of earlier versions have velocities without the attribute channel.
    const bool has_channel = H5Aexists(dataset.get(), "channel") > 0;
    if (!has_channel && name != "velocity") continue;
    const std::string channel =
        has_channel ? access.read_string(dataset.get(), "channel") : "velocity";
    std::vector<hsize_t> shape = access.dimensions(dataset.get());
    const int components = shape.size() == axes ? 3 : 1;
    double entries = 1;  // of the complete frames
    if (!shape.empty()) shape[0] = std::min<hsize_t>(shape[0], times.size());
    for (const hsize_t size : shape) entries *= static_cast<double>(size);
    access.require_stored(dataset.get(), name, entries);
    fields.push_back({name, access.read_string(dataset.get(), "units"), channel, components});
  }
  return fields;
}

void TrajectoryReader::Implementation::read_end() {
  says_its_end = has(file.get(), "run");
  if (!says_its_end) return;
  const Handle group = access.open_group(file.get(), "run");
  if (H5Aexists(group.get(), "complete") <= 0) return;
  end.emplace();
  end->status = access.read_string(group.get(), "status");
  end->reason = access.read_string(group.get(), "reason");
  for (const BillPart& part : bill_parts) {
    Cost& cost = end->bill.*part.cost;
    cost.wall = access.read_double(group.get(), std::string(part.prefix) + "wall_s");
    cost.cpu = access.read_double(group.get(), std::string(part.prefix) + "cpu_s");
  }
}

std::vector<int> TrajectoryReader::Implementation::read_particles(hid_t group,
                                                                  std::size_t texels) const {
  if (!has(group, "particle")) return {};
  const Handle dataset = access.open_dataset(group, "particle");
  const Handle space(H5Dget_space(dataset.get()));
  if (H5Sget_simple_extent_npoints(space.get()) != static_cast<hssize_t>(texels)) {
    access.reject("particle and position have different sizes");
  }
  if (!hdf5::holds_numbers(dataset.get())) access.reject("particle is not a list of numbers");
  access.require_stored(dataset.get(), "particle", static_cast<double>(texels));
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
  if (!hdf5::is_image(shape) || !hdf5::holds_numbers(position.get())) {
    access.reject("body " + name + " is not an image of positions");
  }
  const auto frames = body.moves ? static_cast<double>(times.size()) : 1.0;
  access.require_stored(position.get(), "position of body " + name,
                        frames * static_cast<double>(hdf5::count_of(shape)));
  if (body.moves) body.fields = read_fields(group.get(), shape.size() + 1);
  const std::size_t patch_count = shape.size() == 4 ? shape[0] : 1;
  if (wrap_u.size() != patch_count || wrap_v.size() != patch_count) {
    access.reject("body " + name + " has wraps for another number of patches");
  }
  if (H5Aexists(group.get(), "part_rows") > 0) {
    body.part_rows = access.read_integers(group.get(), "part_rows");
    body.part_cols = access.read_integers(group.get(), "part_cols");
    if (body.part_rows.size() != shape[shape.size() - 3] ||
        body.part_cols.size() != shape[shape.size() - 2]) {
      access.reject("body " + name + " is a part of another size than its image");
    }
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
  read_spline(group.get(), body);
  return body;
}

TrajectoryBody TrajectoryReader::Implementation::read_spheres(const std::string& name) const {
  const Handle group = access.open_group(file.get(), "particles/" + name);
  TrajectoryBody body;
  body.name = name;
  const Handle position = access.open_dataset(group.get(), "position");
  const std::vector<hsize_t> shape = access.dimensions(position.get());
  if (shape.size() != 3 || shape[1] == 0 || shape[1] > (hsize_t{1} << 28) || shape[2] != 3 ||
      !hdf5::holds_numbers(position.get()))
    access.reject("particles " + name + " are not a list of positions");
  if (shape[0] < times.size()) access.reject("particles " + name + " lack frames");
  access.require_stored(position.get(), "position of particles " + name,
                        static_cast<double>(3 * times.size() * shape[1]));
  const Handle radius = access.open_dataset(group.get(), "radius");
  if (access.dimensions(radius.get()) != std::vector<hsize_t>{shape[1]} ||
      !hdf5::holds_numbers(radius.get()))
    access.reject("particles " + name + " do not have one radius each");
  access.require_stored(radius.get(), "radius of particles " + name, static_cast<double>(shape[1]));
  body.radii.resize(shape[1]);
  access.check(
      H5Dread(radius.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, body.radii.data()),
      "read the radii of particles " + name);
  if (!std::ranges::all_of(body.radii, [](double each) { return each > 0 && std::isfinite(each); }))
    access.reject("particles " + name + " have a radius that is not positive");
  body.fields = read_fields(group.get(), 3);
  body.atlas = bsi::Atlas::of_points(static_cast<int>(shape[1]));
  return body;
}

// Reads the spline degree of a shell. Rejects a shell, unless recorded in part, whose image has too
// few rows or columns for a spline.
void TrajectoryReader::Implementation::read_spline(hid_t group, TrajectoryBody& body) const {
  if (H5Aexists(group, "spline_degree") <= 0) return;
  const std::vector<int> degree = access.read_integers(group, "spline_degree");
  if (degree.size() != 1 || degree[0] < 2 || degree[0] > highest_spline_degree)
    access.reject("body " + body.name + " has a spline_degree that is neither 2 nor 3");
  const bsi::Patch& patch = body.atlas.patches().front();
  if (!body.is_part() &&
      std::min(patch.rows, patch.cols) < SplineAxis::least_control_points(degree[0]))
    access.reject("body " + body.name + " is too small for a spline");
  body.spline_degree = degree[0];
}

// Reads the first `count` entries of a list. The list may be longer, because a run adds entries
// after the frames were counted.
std::vector<double> TrajectoryReader::Implementation::read_list(const std::string& name,
                                                                hsize_t count,
                                                                int components) const {
  const Handle dataset = access.open_dataset(file.get(), name);
  const std::vector<hsize_t> shape = access.dimensions(dataset.get());
  const auto width = static_cast<hsize_t>(components);
  const bool is_list = components == 1 ? shape.size() == 1 : shape.size() == 2 && shape[1] == width;
  if (!is_list || !hdf5::holds_numbers(dataset.get())) {
    access.reject("dataset " + name + " is not a list of numbers");
  }
  if (shape[0] < count) access.reject("dataset " + name + " lacks frames");
  if (count == 0) return {};
  access.require_stored(dataset.get(), name, static_cast<double>(count * width));
  std::vector<double> values(count * width);
  const std::string action = "read dataset " + name;
  const Handle source = access.handle(H5Dget_space(dataset.get()), action);
  std::vector<hsize_t> start(shape.size(), 0), size = shape;
  size[0] = count;
  access.check(H5Sselect_hyperslab(source.get(), H5S_SELECT_SET, start.data(), nullptr, size.data(),
                                   nullptr),
               action);
  access.check(H5Dread(dataset.get(), H5T_NATIVE_DOUBLE, make_space(size).get(), source.get(),
                       H5P_DEFAULT, values.data()),
               action);
  return values;
}

// Reads one frame of a dataset of a body, and returns its values by particle. If several texels
// share a particle, the last one gives its value.
std::vector<double> TrajectoryReader::Implementation::read_image(int body_index, int frame,
                                                                 const std::string& name,
                                                                 int components) const {
  assert(body_index >= 0 && body_index < static_cast<int>(bodies.size()));
  const TrajectoryBody& body = bodies[body_index];
  const std::string action = "read " + name + " of body " + body.name;
  const Handle dataset = access.open_dataset(file.get(), home_of(body) + "/" + name);
  const Handle source = access.handle(H5Dget_space(dataset.get()), action);
  std::vector<hsize_t> shape = access.dimensions(dataset.get());
  const auto width = static_cast<std::size_t>(components);
  const std::size_t numbers = width * static_cast<std::size_t>(body.atlas.texel_count());
  if (body.moves) {
    if (shape.empty() || shape[0] < times.size())
      access.reject("cannot " + action + ": it lacks frames");
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
  if (body.atlas.is_identity()) return values;
  std::vector<double> particles(width * static_cast<std::size_t>(body.atlas.particle_count()));
  for (int t = 0; t < body.atlas.texel_count(); ++t) {
    std::copy_n(&values[width * static_cast<std::size_t>(t)], width,
                &particles[width * static_cast<std::size_t>(body.atlas.particle_of_texel(t))]);
  }
  return particles;
}

TrajectoryReader::TrajectoryReader(const std::string& path)
    : implementation_(read_whole(path, [&] {
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
std::string TrajectoryReader::time_units() const { return implementation_->time_units; }

std::string TrajectoryReader::weft_version() const { return implementation_->weft_version; }

std::string TrajectoryReader::case_text() const { return implementation_->case_text; }

std::string TrajectoryReader::case_folder() const { return implementation_->case_folder; }

std::optional<RunEnd> TrajectoryReader::end() const { return implementation_->end; }

bool TrajectoryReader::says_its_end() const { return implementation_->says_its_end; }

const std::vector<TrajectoryBody>& TrajectoryReader::bodies() const {
  return implementation_->bodies;
}

std::vector<Vec3> TrajectoryReader::positions(int body, int frame) const {
  const hdf5::QuietErrors quiet;
  return read_whole(implementation_->access.path(), [&] {
    return to_vectors(implementation_->read_image(body, frame, "position", 3));
  });
}

std::vector<Vec3> TrajectoryReader::velocities(int body, int frame) const {
  const auto& fields = implementation_->bodies.at(body).fields;
  if (std::ranges::find(fields, "velocity", &TrajectoryField::name) == fields.end()) return {};
  return to_vectors(field_values(body, "velocity", frame));
}

std::vector<double> TrajectoryReader::field_values(int body, const std::string& field,
                                                   int frame) const {
  const hdf5::QuietErrors quiet;
  const TrajectoryBody& of = implementation_->bodies.at(body);
  const auto found = std::ranges::find(of.fields, field, &TrajectoryField::name);
  if (found == of.fields.end())
    implementation_->access.reject("body " + of.name + " has no field " + field);
  return read_whole(implementation_->access.path(), [&] {
    return implementation_->read_image(body, frame, field, found->components);
  });
}

const std::vector<SewnParticles>& TrajectoryReader::sewn() const { return implementation_->sewn; }

const std::vector<TrajectoryRecord>& TrajectoryReader::records() const {
  return implementation_->records;
}

std::vector<double> TrajectoryReader::record_values(const std::string& path) const {
  const hdf5::QuietErrors quiet;
  const auto& records = implementation_->records;
  const auto found = std::ranges::find(records, path, &TrajectoryRecord::path);
  if (found == records.end()) implementation_->access.reject("has no record " + path);
  return read_whole(implementation_->access.path(), [&] {
    return implementation_->read_list(path, implementation_->times.size(), found->components);
  });
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
  return read_whole(implementation_->access.path(), [&] {
    return implementation_->read_list("series/" + name, implementation_->times.size());
  });
}

std::vector<TrajectoryWriter::Series> TrajectoryReader::step_series() const {
  return implementation_->step_series;
}

std::vector<double> TrajectoryReader::step_values(const std::string& name) const {
  const hdf5::QuietErrors quiet;
  const auto& series = implementation_->step_series;
  if (std::ranges::find(series, name, &TrajectoryWriter::Series::name) == series.end())
    implementation_->access.reject("has no series of steps " + name);
  return read_whole(implementation_->access.path(), [&] {
    return implementation_->read_list("steps/" + name, implementation_->steps);
  });
}

TrajectoryContents TrajectoryReader::contents() const {
  return {bodies(), records(), series(), step_series()};
}

std::vector<double> TrajectoryReader::step_values(const std::string& name,
                                                  std::int64_t count) const {
  const hdf5::QuietErrors quiet;
  if (count < 0) implementation_->access.reject("has a negative number of steps");
  return read_whole(implementation_->access.path(), [&] {
    return implementation_->read_list("steps/" + name, static_cast<hsize_t>(count));
  });
}

}  // namespace weft::sim
