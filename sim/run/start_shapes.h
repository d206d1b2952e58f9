// Writes the places of bodies at t = 0 to a file from which a case can start them.
#pragma once

#include <span>
#include <string>

#include "sim/scene/scene.h"

namespace weft::sim {

// Throws FileError if `path` exists and `force` is false, or if it is a folder. Throws CaseError if
// the file is the case or one that the case reads: these are never overwritten.
void refuse_shape_file(const std::string& path, const Case& source, bool force);

// Writes a dataset /NAME [rows, cols, 3] or [patches, rows, cols, 3] of float64 (m) for each body
// of `bodies` (indices into Scene::bodies): a shape for the key body.start.shape that puts the
// particles at `position` (m, by particle of the scene). Stretch, rotation and position of the body
// are taken out. Throws CaseError for a body whose patches have different sizes, and FileError if
// the file cannot be written. The file is written under another name beside `path` that the
// function returns, so that it can be tested before it is renamed.
std::string write_start_shapes(const std::string& path, const Scene& scene,
                               std::span<const int> bodies, std::span<const Vec3> position);

// Returns the start of a body that write_start_shapes() wrote.
StartCase start_from_file(const std::string& path, const SceneBody& body);

}  // namespace weft::sim
