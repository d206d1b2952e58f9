#include "sim/scene/shape_builder.h"

#include <filesystem>
#include <stdexcept>

#include "sim/base/file_error.h"
#include "sim/case/case_error.h"
#include "sim/case/case_shape_checks.h"
#include "sim/case/memory_estimate.h"
#include "sim/scene/texel_file.h"

namespace weft::sim {

namespace {

bsi::Surface read_shape(const ShapeCase& shape, const Case& source) {
  const auto path = std::filesystem::path(source.path).parent_path() / shape.path;
  const TexelFile file = read_texels(path.string(), shape.dataset, memory_limit(source));
  return bsi::make_from_texels(file.patches, file.rows, file.cols, file.texels, shape.wrap_u,
                               shape.wrap_v);
}

bsi::Surface make_cone(const ShapeCase& shape) {
  if (has_apex(shape)) return bsi::make_cone(*shape.radius, *shape.length, shape.resolution[0]);
  return bsi::make_frustum(*shape.radius, shape.top_radius, *shape.length, shape.resolution[0],
                           shape.resolution[1]);
}

bsi::Surface make_sphere_sector(const ShapeCase& shape) {
  return bsi::make_sphere_sector(*shape.radius, shape.latitude_deg[0], shape.latitude_deg[1],
                                 shape.resolution[0], shape.resolution[1], shape.angle_deg);
}

bsi::Surface make_shape(const ShapeCase& shape, const Case& source) {
  const std::vector<int>& n = shape.resolution;
  const std::vector<double>& size = shape.size;
  switch (shape.type) {
    case ShapeType::rectangle:
      return bsi::make_rectangle(size[0], size[1], n[0], n[1]);
    case ShapeType::plane:
      return bsi::make_rectangle(size[0], size[1], plane_vertices, plane_vertices);
    case ShapeType::disc:
      return bsi::make_disc(*shape.radius, n[0]);
    case ShapeType::annulus:
      return bsi::make_annulus(*shape.inner_radius, *shape.outer_radius, n[0], n[1],
                               shape.angle_deg);
    case ShapeType::box:
      return bsi::make_box({size[0], size[1], size[2]}, {n[0], n[1], n[2]});
    case ShapeType::cylinder:
      return bsi::make_cylinder(*shape.radius, *shape.length, n[0], n[1], shape.angle_deg);
    case ShapeType::capsule:
      return bsi::make_capsule(*shape.radius, *shape.length, n[0], n[1]);
    case ShapeType::cone:
      return make_cone(shape);
    case ShapeType::torus:
      return bsi::make_torus(*shape.major_radius, *shape.minor_radius, n[0], n[1]);
    case ShapeType::sphere:
      return bsi::make_sphere(*shape.radius, n[0]);
    case ShapeType::sphere_sector:
      return make_sphere_sector(shape);
    case ShapeType::blob:
      return bsi::make_blob(*shape.radius, n[0]);
    case ShapeType::file:
      return read_shape(shape, source);
  }
  throw CaseError(shape.location, "shape type without a builder");
}

}  // namespace

bsi::Surface build_shape(const ShapeCase& shape, const Case& source) {
  try {
    bsi::Surface surface = make_shape(shape, source);
    if (shape.patches.empty()) return surface;
    return bsi::cut_into_patches(surface, shape.patches[0], shape.patches[1]);
  } catch (const std::invalid_argument& error) {
    throw CaseError(shape.location, error.what());
  } catch (const FileError& error) {
    throw CaseError(shape.location, error.what());
  }
}

}  // namespace weft::sim
