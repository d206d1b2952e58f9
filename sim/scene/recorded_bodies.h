// The bodies of a scene that its trajectory records, as a whole or in part.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// A part of a body: some rows and columns of each of its patches. An axis stays closed if the part
// contains both ends of it. Texels that share a particle in the body also share one in the part.
struct ImagePart {
  bsi::Atlas atlas;
  std::vector<int> rows, cols;  // by row or column of the part: index in the body's patches
  std::vector<int> particles;   // by particle of the part: local index in the body
};

// Returns a part of an image. Throws CaseError at the part if its rows or columns lie outside the
// image or are too few. Along an open axis a surface needs two rows or columns, along a closed axis
// three. O(texels of the part + particles of the body).
ImagePart make_part(const bsi::Atlas& whole, const OutputPartCase& part);

struct RecordedBody {
  int body = 0;                   // index into Scene::bodies
  int order = 0;                  // index into Scene::case_order
  std::optional<ImagePart> part;  // empty if the whole body is recorded

  // Returns the entries of the recorded particles. `values` has `width` entries for each particle
  // of the body. For a part, the entries are copied to `memory`, and the result is a view of
  // `memory`.
  template <class Entry>
  std::span<const Entry> of_recorded(std::span<const Entry> values, int width,
                                     std::vector<Entry>& memory) const {
    if (!part) return values;
    memory.clear();
    for (const int particle : part->particles) {
      for (int k = 0; k < width; ++k)
        memory.push_back(values[static_cast<std::size_t>(width) * particle + k]);
    }
    return memory;
  }
};

// Returns the bodies and obstacles that the case records, in the order of the case. Throws
// CaseError as make_part().
std::vector<RecordedBody> recorded_bodies(const Scene& scene);

// Returns a notice if the initial positions lie so far from the origin that surfaces of bodies may
// cross in frames only because float32 rounds them. Returns an empty string if they do not.
std::string rounding_notice(const Scene& scene);

}  // namespace weft::sim
