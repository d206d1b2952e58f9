#include "sim/run/start_shapes.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "sim/base/file_error.h"
#include "sim/base/file_status.h"
#include "sim/base/hdf5_handle.h"
#include "sim/base/output_folder.h"
#include "sim/case/case_error.h"
#include "sim/run/input_files.h"

namespace weft::sim {

namespace {

using hdf5::Access;
using hdf5::Handle;
using hdf5::QuietErrors;

const BodyCase& case_of(const Scene& scene, int index) {
  return scene.source.body[scene.case_index(index)];
}

void write_shape(const Access& access, const Handle& file, const Scene& scene, int index,
                 std::span<const Vec3> position) {
  const SceneBody& body = scene.bodies[index];
  const BodyCase& from = case_of(scene, index);
  const std::vector<bsi::Patch>& patches = body.atlas.patches();
  const bsi::Patch& first = patches.front();
  for (const bsi::Patch& patch : patches) {
    if (patch.rows == first.rows && patch.cols == first.cols) continue;
    throw CaseError(from.location,
                    "the start of \"" + body.name + "\" cannot be written as a shape",
                    "expected patches of one size");
  }
  const Eigen::Matrix3d placing = from.stretch.cwiseInverse().asDiagonal() *
                                  rotation_from_degrees(from.rotation_deg).transpose();
  std::vector<double> values;
  for (int t = 0; t < body.atlas.texel_count(); ++t) {
    const int particle = body.first_particle + body.atlas.particle_of_texel(t);
    const Vec3 point = placing * (position[particle] - from.position);
    values.insert(values.end(), {point.x(), point.y(), point.z()});
  }
  std::vector<hsize_t> shape;
  if (patches.size() > 1) shape.push_back(patches.size());
  shape.insert(shape.end(),
               {static_cast<hsize_t>(first.rows), static_cast<hsize_t>(first.cols), 3});
  const Handle space = hdf5::make_space(shape);
  const Handle dataset =
      access.handle(H5Dcreate2(file.get(), body.name.c_str(), H5T_IEEE_F64LE, space.get(),
                               H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                    "make dataset " + body.name);
  access.check(
      H5Dwrite(dataset.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
      "write dataset " + body.name);
  access.write_attribute(dataset.get(), "units", "m");
}

}  // namespace

void refuse_shape_file(const std::string& path, const Case& source, bool force) {
  const auto status = link_status_of(path);
  refuse_special_file(path, status);
  refuse_input_file(path, source, "--fix-initial");
  if (!force && std::filesystem::exists(status))
    throw FileError(path + ": exists already, and is only overwritten by force (--force)");
}

std::string write_start_shapes(const std::string& path, const Scene& scene,
                               std::span<const int> bodies, std::span<const Vec3> position) {
  std::string temporary = in_output_folder(path) + "." + std::to_string(getpid()) + ".tmp";
  const QuietErrors quiet;
  const Access access(temporary);
  const Handle file = access.handle(
      H5Fcreate(temporary.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), "create the file");
  try {
    for (const int body : bodies) write_shape(access, file, scene, body, position);
    access.check(H5Fflush(file.get(), H5F_SCOPE_GLOBAL), "write the file");
  } catch (...) {
    std::filesystem::remove(temporary);
    throw;
  }
  return temporary;
}

StartCase start_from_file(const std::string& path, const SceneBody& body) {
  ShapeCase shape;
  shape.type = ShapeType::file;
  shape.path = std::filesystem::absolute(path).string();
  shape.dataset = "/" + body.name;
  shape.wrap_u = body.atlas.patches().front().wrap_u;
  shape.wrap_v = body.atlas.patches().front().wrap_v;
  shape.location = {path};
  StartCase start;
  start.shape = shape;
  return start;
}

}  // namespace weft::sim
