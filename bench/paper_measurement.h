// What the two timed experiments of the paper have in common.
#pragma once

#include <array>
#include <filesystem>
#include <sstream>
#include <string>

#include "bench/plot.h"
#include "bench/scenes.h"

namespace weft::bench {

// Scenes measured one after the other: rebuild of the pyramids of all bodies but particles, query
// (candidates) and exact test (hits among them), by each bound of the traversals, against brute
// force, which tests every pair of boxes and makes the same exact test. Medians over the passes, ms
// of one thread. Brute force is repeated as often as that goes within a second, but once, and left
// out where a pass of it would take some seconds.
class PaperFigure {
 public:
  // `scenes` says what they are, `columns` names what tells them apart in the table.
  PaperFigure(const std::string& scenes, const std::string& columns, int passes);

  // Measures a scene. `columns` are its own, `x` its place in the chart.
  void add(const CollisionScene& scene, const std::string& columns, double x);

  // Writes NAME.csv and NAME.svg, and the table to standard output. False where two found other
  // candidates or hits, which is said on standard error. Throws std::runtime_error as write_text().
  bool write(const std::filesystem::path& directory, const std::string& name,
             const std::string& title, const std::string& note, const std::string& x_title) const;

 private:
  int passes_;
  std::ostringstream csv_;
  std::array<Series, 3> by_bound_{Series{"by spheres", {}, {}}, Series{"by boxes", {}, {}},
                                  Series{"by spheres, then boxes", {}, {}}};
  Series brute_{"brute force", {}, {}};
  bool right_ = true;
};

}  // namespace weft::bench
