// The bodies of a scene that its trajectory holds, whole or in part.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// A part of a body: some rows and columns of each of its patches. An axis stays closed if the part
// has it from end to end. Texels that shared a particle still do.
struct ImagePart {
  bsi::Atlas atlas;
  std::vector<int> rows, cols;  // of the body's patches, by row and column of the part
  std::vector<int> particles;   // of the body, by particle of the part
};

// Throws CaseError, placed at the part, if its rows and columns lie outside the image or are too
// few for a surface: two along an open axis, three along a closed one. O(texels of the part).
ImagePart make_part(const bsi::Atlas& whole, const OutputPartCase& part);

struct RecordedBody {
  int body = 0;                   // index into Scene::bodies
  int order = 0;                  // index into Scene::case_order
  std::optional<ImagePart> part;  // empty: the whole body

  // Returns the entries of recorded particles. `values` has `width` entries for each particle of
  // the body. For a part, `memory` holds the result.
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

// The bodies and obstacles that the case records, in its order. Throws CaseError as make_part().
std::vector<RecordedBody> recorded_bodies(const Scene& scene);

}  // namespace weft::sim
