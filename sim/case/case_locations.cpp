#include "sim/case/case_locations.h"

namespace weft::sim {

const Locations::Place* Locations::nearest(std::string path) const {
  while (true) {
    if (const auto found = places_.find(path); found != places_.end()) return &found->second;
    const std::size_t end = path.find_last_of(".[");
    if (end == std::string::npos) return nullptr;
    path.erase(end);
  }
}

SourceLocation Locations::key(const std::string& path) const {
  const Place* place = nearest(path);
  return place != nullptr ? place->key : SourceLocation{file_, 1, 1};
}

SourceLocation Locations::value(const std::string& path) const {
  const Place* place = nearest(path);
  return place != nullptr ? place->value : SourceLocation{file_, 1, 1};
}

}  // namespace weft::sim
