#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>

#include "sim/base/file_status.h"
#include "sim/base/hdf5_handle.h"
#include "sim/trajectory/commit_driver.h"
#include "sim/trajectory/creation_properties.h"
#include "sim/trajectory/file_lock.h"
#include "sim/trajectory/frame_batch.h"
#include "sim/trajectory/frame_views.h"
#include "sim/trajectory/leftover_files.h"
#include "sim/trajectory/list_dataset.h"
#include "sim/trajectory/trajectory.h"
#include "sim/trajectory/xdmf_file.h"

namespace weft::sim {
namespace {

std::string sidecar_of(const std::string& path) {
  return std::filesystem::path(path).replace_extension(".xdmf").string();
}

using hdf5::Handle;
using hdf5::make_space;

// A commit is due if the waiting frames occupy at least this memory (bytes).
constexpr std::size_t largest_batch = std::size_t{64} << 20;

std::vector<int> triangle_texels(const bsi::Atlas& atlas) {
  std::vector<int> result;
  for (int p = 0; p < static_cast<int>(atlas.patches().size()); ++p) {
    const bsi::Patch& patch = atlas.patches()[p];
    const auto texel = [&](int row, int col) {
      return atlas.first_texel(p) + (row % patch.rows) * patch.cols + col % patch.cols;
    };
    for (int row = 0; row < patch.quad_rows(); ++row) {
      for (int col = 0; col < patch.quad_cols(); ++col) {
        for (const auto& triangle :
             bsi::quad_triangles({texel(row, col), texel(row, col + 1), texel(row + 1, col),
                                  texel(row + 1, col + 1)})) {
          result.insert(result.end(), triangle.begin(), triangle.end());
        }
      }
    }
  }
  return result;
}

[[maybe_unused]] bool same_size(const bsi::Atlas& atlas) {
  for (const bsi::Patch& patch : atlas.patches()) {
    if (patch.rows != atlas.patches().front().rows || patch.cols != atlas.patches().front().cols) {
      return false;
    }
  }
  return !atlas.patches().empty();
}

[[noreturn]] void refuse_running(const std::string& path) {
  throw FileError(path +
                  ": is being written by a run that has not ended; wait for it, or write to "
                  "another folder (-o)");
}

}  // namespace

struct TrajectoryWriter::Implementation {
  struct BodyDatasets {
    Handle position;
    std::vector<Handle> fields;
  };

  Implementation(const std::string& path, std::vector<TrajectoryBody> body_list,
                 std::vector<Series> series_list, Options option_list)
      : access(path),
        bodies(std::move(body_list)),
        series(std::move(series_list)),
        options(std::move(option_list)),
        batch(bodies, options.precision, rounding()) {}
  ~Implementation() {
    const hdf5::QuietErrors quiet;
    close_objects();
    file.close();
    if (!temporary.empty()) unlink(temporary.c_str());
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  void create_file();
  void create_root();
  void write_sewn();
  void create_body(const TrajectoryBody& body, std::span<const Vec3> initial_positions);
  void create_spheres(const TrajectoryBody& body);
  BodyDatasets create_moving(hid_t group, const TrajectoryBody& body);
  Handle make_group(hid_t parent, const std::string& name, const Handle& properties) const;
  Handle create_frames(hid_t group, const std::string& name, hid_t type,
                       const std::vector<hsize_t>& frame, const std::string& units);
  void write_positions(hid_t group, const bsi::Atlas& atlas, std::span<const Vec3> positions);
  void create_record(const TrajectoryRecord& record);
  void write_whole(hid_t group, const std::string& name, hid_t file_type, hid_t memory_type,
                   const std::vector<hsize_t>& shape, const void* data, const std::string& units);
  void publish();
  bool replace_old_file();
  void flush(const std::string& action) const;
  void close_objects();

  bool is_due(double pause) const;
  void commit();
  void write_batch();
  void append_images(hid_t dataset, const std::vector<hsize_t>& frame, hid_t memory_type,
                     const void* images);
  Rounding rounding() const {
    return options.compression == Compression::bounded ? Rounding(options.compression_error)
                                                       : Rounding();
  }
  void append_values(hid_t dataset, hsize_t start, std::span<const double> values,
                     int components = 1);
  void append_records();
  void append_steps();
  std::string action() const;
  void write_end(const RunEnd& end);

  hdf5::Access access;
  std::vector<TrajectoryBody> bodies;
  std::vector<Series> series;
  Options options;
  std::string temporary;  // temporary path of the file; empty once the file has its final name
  Handle file, run_group, body_group, sphere_group, series_group, step_group, time;
  std::vector<BodyDatasets> body_datasets;
  std::vector<Handle> series_datasets, step_datasets, record_datasets;
  std::optional<FrameViews> views;
  XdmfFile sidecar;
  std::string waiting_sidecar;  // text of frames that are committed before publish()
  FrameBatch batch;
  int committed_frames = 0;
  hsize_t committed_steps = 0;
  std::chrono::steady_clock::time_point last_commit = std::chrono::steady_clock::now();
  bool failed = false;
};

void TrajectoryWriter::refuse_existing(const std::string& path, bool force) {
  const std::string sidecar = sidecar_of(path);
  if (sidecar == path) throw FileError(path + ": a trajectory cannot be named .xdmf");
  for (const std::string& name : {path, sidecar}) {
    const auto status = link_status_of(name);
    refuse_special_file(name, status);
    if (!force && std::filesystem::exists(status)) {
      throw FileError(name + ": exists already, and is only overwritten by force (--force)");
    }
  }
  refuse_long_name(temporary_path(sidecar));  // the longest name that the writer needs
  if (is_locked(path)) refuse_running(path);
}

void TrajectoryWriter::refuse_foreign_sidecar(const std::string& path) {
  const std::string sidecar = sidecar_of(path);
  if (!std::filesystem::exists(link_status_of(sidecar)) || is_own_sidecar(sidecar)) return;
  throw FileError(sidecar +
                  ": was not written by Weft, and is only overwritten by force (--force)");
}

void TrajectoryWriter::Implementation::create_file() {
  temporary = temporary_path(access.path());
  unlink(temporary.c_str());  // left by a dead process with this id, if any
  remove_leftovers(access.path());
  const Handle creation(H5Pcreate(H5P_FILE_CREATE));
  const Handle file_access(H5Pcreate(H5P_FILE_ACCESS));
  access.check(set_commit_driver(file_access.get()), "set up HDF5");
  access.check(set_commit_allocation(creation.get()), "set up HDF5");
  H5Pset_obj_track_times(creation.get(), false);
  H5Pset_link_creation_order(creation.get(), H5P_CRT_ORDER_TRACKED);
  const DefaultGroupsWithoutTimes without_times;
  file = access.handle(
      H5Fcreate(temporary.c_str(), H5F_ACC_EXCL, creation.get(), file_access.get()), "create");
  lock_open_file(commit_descriptor(file.get()));
}

void TrajectoryWriter::Implementation::create_root() {
  access.write_attribute(file.get(), "format", std::string("weft-trajectory"));
  access.write_attribute(file.get(), "version", std::vector<int>{1});
  access.write_attribute(file.get(), "weft_version", std::string(WEFT_VERSION));
  access.write_attribute(file.get(), "title", options.title);
  access.write_attribute(file.get(), "compute", options.compute);
  if (!options.case_folder.empty())
    access.write_attribute(file.get(), "case_folder", options.case_folder);

  const Handle text_type(H5Tcopy(H5T_C_S1));
  H5Tset_size(text_type.get(), H5T_VARIABLE);
  H5Tset_cset(text_type.get(), H5T_CSET_UTF8);
  const Handle scalar(H5Screate(H5S_SCALAR));
  const Handle properties = dataset_properties();
  const Handle text = access.handle(H5Dcreate2(file.get(), "case", text_type.get(), scalar.get(),
                                               H5P_DEFAULT, properties.get(), H5P_DEFAULT),
                                    "write the case");
  const char* contents = options.case_text.c_str();
  access.check(H5Dwrite(text.get(), text_type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, &contents),
               "write the case");

  const Handle ordered = ordered_group();
  run_group = make_group(file.get(), "run", end_properties());
  body_group = make_group(file.get(), "body", ordered);
  if (std::ranges::any_of(bodies, &TrajectoryBody::is_of_spheres))
    sphere_group = make_group(file.get(), "particles", ordered);
  series_group = make_group(file.get(), "series", ordered);
  step_group = make_group(file.get(), "steps", ordered);
  views.emplace(access, file.get(), bodies, options.precision);
  sidecar.begin(std::filesystem::path(access.path()).filename().string(),
                views->surfaces_at_rest());
  write_sewn();
}

void TrajectoryWriter::Implementation::write_sewn() {
  if (options.sewn.empty()) return;
  std::vector<int> numbers;
  for (const auto& [body, particle, other_body, other_particle] : options.sewn)
    numbers.insert(numbers.end(), {body, particle, other_body, other_particle});
  write_whole(file.get(), "sewn", H5T_STD_I32LE, H5T_NATIVE_INT, {options.sewn.size(), 4},
              numbers.data(), "");
}

Handle TrajectoryWriter::Implementation::make_group(hid_t parent, const std::string& name,
                                                    const Handle& properties) const {
  return access.handle(H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, properties.get(), H5P_DEFAULT),
                       "create group " + name);
}

void TrajectoryWriter::Implementation::write_whole(hid_t group, const std::string& name,
                                                   hid_t file_type, hid_t memory_type,
                                                   const std::vector<hsize_t>& shape,
                                                   const void* data, const std::string& units) {
  const std::string action = "write dataset " + name;
  const Handle space = make_space(shape);
  const Handle properties = dataset_properties();
  const Handle dataset = access.handle(H5Dcreate2(group, name.c_str(), file_type, space.get(),
                                                  H5P_DEFAULT, properties.get(), H5P_DEFAULT),
                                       action);
  access.check(H5Dwrite(dataset.get(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), action);
  if (!units.empty()) access.write_attribute(dataset.get(), "units", units);
}

// Creates an empty dataset with one chunk per frame. HDF5's chunk cache is off, because the batch
// already collects frames.
Handle TrajectoryWriter::Implementation::create_frames(hid_t group, const std::string& name,
                                                       hid_t type,
                                                       const std::vector<hsize_t>& frame,
                                                       const std::string& units) {
  std::vector<hsize_t> shape = frame;
  shape.insert(shape.begin(), 1);
  const Handle properties = dataset_properties();
  H5Pset_chunk(properties.get(), static_cast<int>(shape.size()), shape.data());
  set_filters(properties.get(), options.compression);
  const Handle dataset_access(H5Pcreate(H5P_DATASET_ACCESS));
  H5Pset_chunk_cache(dataset_access.get(), 0, 0, 0);
  std::vector<hsize_t> maximum = shape;
  shape[0] = 0;
  maximum[0] = H5S_UNLIMITED;
  Handle dataset =
      access.handle(H5Dcreate2(group, name.c_str(), type, make_space(shape, maximum).get(),
                               H5P_DEFAULT, properties.get(), dataset_access.get()),
                    "create dataset " + name);
  access.write_attribute(dataset.get(), "units", units);
  return dataset;
}

void TrajectoryWriter::Implementation::create_record(const TrajectoryRecord& record) {
  create_groups_above(access, file.get(), record.path);
  record_datasets.push_back(create_list(access, file.get(), record.path, record.components));
  access.write_attribute(record_datasets.back().get(), "units", record.units);
  access.write_attribute(record_datasets.back().get(), "channel", record.channel);
}

// Writes the positions of a body that does not move, rounded like those of bodies that move.
void TrajectoryWriter::Implementation::write_positions(hid_t group, const bsi::Atlas& atlas,
                                                       std::span<const Vec3> positions) {
  const auto write = [&](auto texels, hid_t memory_type) {
    append_positions(atlas, positions, rounding(), texels);
    write_whole(group, "position", file_type(options.precision), memory_type, frame_shape(atlas),
                texels.data(), "m");
  };
  if (options.precision == Precision::float64) {
    write(std::vector<double>(), H5T_NATIVE_DOUBLE);
  } else {
    write(std::vector<float>(), H5T_NATIVE_FLOAT);
  }
}

void TrajectoryWriter::Implementation::create_body(const TrajectoryBody& body,
                                                   std::span<const Vec3> initial_positions) {
  if (body.is_of_spheres()) return create_spheres(body);
  assert(same_size(body.atlas));
  const bsi::Atlas& atlas = body.atlas;
  const Handle group = make_group(body_group.get(), body.name, ordered_group());
  std::vector<int> wrap_u, wrap_v;
  for (const bsi::Patch& patch : atlas.patches()) {
    wrap_u.push_back(patch.wrap_u);
    wrap_v.push_back(patch.wrap_v);
  }
  access.write_attribute(group.get(), "moves", std::vector<int>{body.moves});
  access.write_attribute(group.get(), "obstacle", std::vector<int>{body.is_obstacle});
  access.write_attribute(group.get(), "thickness_m", body.thickness);
  access.write_attribute(group.get(), "wrap_u", wrap_u);
  access.write_attribute(group.get(), "wrap_v", wrap_v);
  if (body.spline_degree > 0)
    access.write_attribute(group.get(), "spline_degree", std::vector<int>{body.spline_degree});
  if (body.is_part()) {
    access.write_attribute(group.get(), "part_rows", body.part_rows);
    access.write_attribute(group.get(), "part_cols", body.part_cols);
  }

  const std::vector<int> triangles = triangle_texels(atlas);
  write_whole(group.get(), "triangles", H5T_STD_I32LE, H5T_NATIVE_INT, {triangles.size() / 3, 3},
              triangles.data(), "");
  if (!atlas.is_identity()) {
    std::vector<int> particles;
    particles.reserve(static_cast<std::size_t>(atlas.texel_count()));
    for (int t = 0; t < atlas.texel_count(); ++t) particles.push_back(atlas.particle_of_texel(t));
    const auto rows = static_cast<hsize_t>(atlas.patches().front().rows);
    const auto cols = static_cast<hsize_t>(atlas.patches().front().cols);
    write_whole(group.get(), "particle", H5T_STD_I32LE, H5T_NATIVE_INT,
                {atlas.patches().size(), rows, cols}, particles.data(), "");
  }
  if (!body.moves) write_positions(group.get(), atlas, initial_positions);
  body_datasets.push_back(body.moves ? create_moving(group.get(), body) : BodyDatasets());
}

// Creates the datasets of a body that moves, which have one entry per frame.
TrajectoryWriter::Implementation::BodyDatasets TrajectoryWriter::Implementation::create_moving(
    hid_t group, const TrajectoryBody& body) {
  BodyDatasets datasets;
  datasets.position =
      create_frames(group, "position", file_type(options.precision), frame_shape(body.atlas), "m");
  for (const TrajectoryField& field : body.fields) {
    datasets.fields.push_back(create_frames(
        group, field.name, H5T_IEEE_F32LE, frame_shape(body.atlas, field.components), field.units));
    access.write_attribute(datasets.fields.back().get(), "channel", field.channel);
  }
  return datasets;
}

void TrajectoryWriter::Implementation::create_spheres(const TrajectoryBody& body) {
  const Handle group = make_group(sphere_group.get(), body.name, ordered_group());
  access.write_attribute(group.get(), "moves", std::vector<int>{body.moves});
  write_whole(group.get(), "radius", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {body.radii.size()},
              body.radii.data(), "m");
  body_datasets.push_back(create_moving(group.get(), body));
}

void TrajectoryWriter::Implementation::publish() {
  flush("create");
  while (!replace_old_file()) {
  }
  temporary.clear();
  sidecar.create(sidecar_of(access.path()));
  if (!waiting_sidecar.empty()) sidecar.append(waiting_sidecar);
  waiting_sidecar.clear();
}

// Renames the new file, which is locked, to its final name. Before it replaces an old file, it
// takes that file's lock and fails if another writer holds it. If two runs write to the same path
// at a time, the second one therefore fails, even with `force`. Returns false if yet another file
// has taken the old file's name meanwhile.
bool TrajectoryWriter::Implementation::replace_old_file() {
  const std::string& path = access.path();
  const auto fail = [&](int error) {
    throw FileError(path + ": cannot create: " + std::strerror(error));
  };
  if (renameat2(AT_FDCWD, temporary.c_str(), AT_FDCWD, path.c_str(), RENAME_NOREPLACE) == 0) {
    return true;
  }
  // File systems without RENAME_NOREPLACE report EINVAL or ENOSYS.
  if (errno != EEXIST && errno != EINVAL && errno != ENOSYS) fail(errno);
  refuse_existing(path, options.force);
  const LockedFile old(path);
  if (old.state() == LockedFile::State::held_by_another) refuse_running(path);
  std::error_code error;
  const bool is_link = std::filesystem::is_symlink(path, error);
  const bool is_old = old.state() == LockedFile::State::absent || is_link || old.is_at(path);
  if (!is_old) return false;
  if (std::rename(temporary.c_str(), path.c_str()) != 0) fail(errno);
  return true;
}

void TrajectoryWriter::Implementation::flush(const std::string& action) const {
  access.check(H5Fflush(file.get(), H5F_SCOPE_GLOBAL), action);
  const std::string failure = commit_failure(file.get());
  if (!failure.empty()) access.reject("cannot " + action + ": " + failure);
}

// Closes every object in the file. If the file were closed first, the handles of its objects would
// become invalid.
void TrajectoryWriter::Implementation::close_objects() {
  body_datasets.clear();
  series_datasets.clear();
  step_datasets.clear();
  record_datasets.clear();
  if (views) views->close();
  for (Handle* handle :
       {&time, &step_group, &series_group, &sphere_group, &body_group, &run_group}) {
    handle->close();
  }
}

// Returns a description of writing the batch for error messages, such as "write frames 3 to 7".
std::string TrajectoryWriter::Implementation::action() const {
  const std::string first = std::to_string(committed_frames);
  if (batch.frames() == 1) return "write frame " + first;
  return "write frames " + first + " to " + std::to_string(committed_frames + batch.frames() - 1);
}

void TrajectoryWriter::Implementation::append_images(hid_t dataset,
                                                     const std::vector<hsize_t>& frame,
                                                     hid_t memory_type, const void* images) {
  const std::string action = this->action();
  const auto count = static_cast<hsize_t>(batch.frames());
  std::vector<hsize_t> shape = frame;
  shape.insert(shape.begin(), static_cast<hsize_t>(committed_frames) + count);
  access.check(H5Dset_extent(dataset, shape.data()), action);
  const Handle target(H5Dget_space(dataset));
  std::vector<hsize_t> start(shape.size(), 0);
  start[0] = static_cast<hsize_t>(committed_frames);
  shape[0] = count;
  access.check(H5Sselect_hyperslab(target.get(), H5S_SELECT_SET, start.data(), nullptr,
                                   shape.data(), nullptr),
               action);
  access.check(
      H5Dwrite(dataset, memory_type, make_space(shape).get(), target.get(), H5P_DEFAULT, images),
      action);
}

void TrajectoryWriter::Implementation::append_values(hid_t dataset, hsize_t start,
                                                     std::span<const double> values,
                                                     int components) {
  append_to_list(access, dataset, start, values, components, action());
}

void TrajectoryWriter::Implementation::append_records() {
  std::size_t columns = 0, first = 0;
  for (const TrajectoryRecord& record : options.records)
    columns += static_cast<std::size_t>(record.components);
  for (std::size_t r = 0; r < record_datasets.size(); ++r) {
    const int components = options.records[r].components;
    const auto width = static_cast<std::size_t>(components);
    append_values(record_datasets[r].get(), static_cast<hsize_t>(committed_frames),
                  batch.records(first, width, columns), components);
    first += width;
  }
}

void TrajectoryWriter::Implementation::append_steps() {
  const std::size_t columns = step_datasets.size();
  hsize_t steps = 0;
  for (std::size_t c = 0; c < columns; ++c) {
    const std::vector<double> column = batch.steps(c, columns);
    steps = column.size();
    if (steps == 0) return;
    append_values(step_datasets[c].get(), committed_steps, column);
  }
  committed_steps += steps;
}

void TrajectoryWriter::Implementation::write_batch() {
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (!bodies[b].moves) continue;
    const bsi::Atlas& atlas = bodies[b].atlas;
    const hid_t position = body_datasets[b].position.get();
    if (options.precision == Precision::float64) {
      append_images(position, frame_shape(atlas), H5T_NATIVE_DOUBLE,
                    batch.exact_positions(b).data());
    } else {
      append_images(position, frame_shape(atlas), H5T_NATIVE_FLOAT, batch.positions(b).data());
    }
    for (std::size_t f = 0; f < bodies[b].fields.size(); ++f) {
      append_images(body_datasets[b].fields[f].get(),
                    frame_shape(atlas, bodies[b].fields[f].components), H5T_NATIVE_FLOAT,
                    batch.field(b, f).data());
    }
  }
  const auto start = static_cast<hsize_t>(committed_frames);
  for (std::size_t s = 0; s < series.size(); ++s) {
    append_values(series_datasets[s].get(), start, batch.series(s, series.size()));
  }
  append_steps();
  append_records();
  std::string sidecar_text;
  for (const double frame_time : batch.times()) {
    sidecar_text += sidecar.describe(frame_time, views->add_frame());
  }
  append_values(time.get(), start, batch.times());
  flush(action());
  if (temporary.empty()) {
    sidecar.append(sidecar_text);
  } else {
    waiting_sidecar += sidecar_text;
  }
}

void TrajectoryWriter::Implementation::commit() {
  if (failed) access.reject("no frame can follow one that could not be written");
  if (batch.frames() == 0) return;
  const hdf5::QuietErrors quiet;
  failed = true;  // stays true if a write throws
  write_batch();
  committed_frames += batch.frames();
  batch.clear();
  last_commit = std::chrono::steady_clock::now();
  failed = false;
}

// Writes status, reason and bill, and then, by a second flush, the attribute `complete`, without
// which readers ignore the other attributes. Two flushes are needed because HDF5 stores the text of
// a string attribute apart from the attribute.
void TrajectoryWriter::Implementation::write_end(const RunEnd& end) {
  access.write_attribute(run_group.get(), "status", end.status);
  access.write_attribute(run_group.get(), "reason", end.reason);
  for (const BillPart& part : bill_parts) {
    const Cost& cost = end.bill.*part.cost;
    access.write_attribute(run_group.get(), std::string(part.prefix) + "wall_s", cost.wall);
    access.write_attribute(run_group.get(), std::string(part.prefix) + "cpu_s", cost.cpu);
  }
  flush("write the end");
  access.write_attribute(run_group.get(), "complete", std::vector<int>{1});
  flush("write the end");
}

bool TrajectoryWriter::Implementation::is_due(double pause) const {
  if (batch.frames() == 0) return false;
  if (batch.bytes() >= largest_batch) return true;
  const std::chrono::duration<double> age = std::chrono::steady_clock::now() - last_commit;
  return age.count() + pause >= options.commit_interval;
}

TrajectoryWriter::TrajectoryWriter(const std::string& path, std::vector<TrajectoryBody> bodies,
                                   std::vector<Series> series, Options options,
                                   const std::vector<std::span<const Vec3>>& initial_positions)
    : implementation_(std::make_unique<Implementation>(path, std::move(bodies), std::move(series),
                                                       std::move(options))) {
  Implementation& self = *implementation_;
  assert(initial_positions.size() == self.bodies.size());
  const hdf5::QuietErrors quiet;
  refuse_existing(path, self.options.force);
  self.create_file();
  self.create_root();
  for (std::size_t b = 0; b < self.bodies.size(); ++b) {
    self.create_body(self.bodies[b], initial_positions[b]);
  }
  const auto create_lists = [&](const Handle& group, const std::vector<Series>& list,
                                std::vector<Handle>& datasets) {
    for (const Series& entry : list) {
      datasets.push_back(create_list(self.access, group.get(), entry.name));
      self.access.write_attribute(datasets.back().get(), "units", entry.units);
    }
  };
  create_lists(self.series_group, self.series, self.series_datasets);
  create_lists(self.step_group, self.options.step_series, self.step_datasets);
  for (const TrajectoryRecord& record : self.options.records) self.create_record(record);
  // The dataset /time is created last. It has no attributes, so its header is a single piece and
  // can be the commit mark.
  self.time = create_list(self.access, self.file.get(), "time");
  self.access.write_attribute(self.file.get(), "time_units", self.options.time_units);
  self.access.check(set_commit_mark(self.file.get(), self.time.get()), "set up HDF5");
  if (!self.options.publish_later) self.publish();
}

TrajectoryWriter::~TrajectoryWriter() {
  if (implementation_->failed) return;
  try {
    implementation_->commit();
  } catch (const std::exception&) {
    // Committed frames remain. A caller that needs to know of errors calls commit() itself.
  }
}

void TrajectoryWriter::publish() {
  const hdf5::QuietErrors quiet;
  implementation_->commit();
  implementation_->publish();
}

int TrajectoryWriter::frames() const {
  return implementation_->committed_frames + implementation_->batch.frames();
}

void TrajectoryWriter::check_in_place() const {
  const hdf5::Access& access = implementation_->access;
  if (names_open_file(access.path(), commit_descriptor(implementation_->file.get()))) return;
  access.reject("is no longer the file of this run: it was moved, removed or replaced meanwhile");
}

void TrajectoryWriter::write_frame(double time, const std::vector<std::span<const Vec3>>& positions,
                                   const FrameChannels& channels, std::span<const double> series,
                                   std::span<const double> step_rows) {
  Implementation& self = *implementation_;
  assert(series.size() == self.series.size());
  assert(step_rows.empty() || !self.step_datasets.empty());
  if (self.failed) self.commit();  // throws
  self.failed = true;              // stays true if add() throws
  self.batch.add(time, positions, channels, series, step_rows);
  self.failed = false;
  if (is_due(0)) commit();
}

bool TrajectoryWriter::is_due(double pause) const { return implementation_->is_due(pause); }

void TrajectoryWriter::commit() { implementation_->commit(); }

void TrajectoryWriter::finish(const RunEnd& end) {
  commit();
  const hdf5::QuietErrors quiet;
  implementation_->failed = true;  // refuses further frames
  implementation_->write_end(end);
}

}  // namespace weft::sim
