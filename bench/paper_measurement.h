// The shared part of the paper's two timed experiments.
#pragma once

#include <array>
#include <filesystem>
#include <sstream>
#include <string>

#include "bench/scenes.h"
#include "sim/view/plot.h"

namespace weft::bench {

// Measures scenes one after the other: rebuild of the pyramids of all bodies except particles,
// query (candidate pairs) and exact test (hits among them). Each bound of the traversals is checked
// against brute force, which tests every pair of boxes and makes the same exact test. Times are
// medians over the passes, ms of one thread. Brute force is repeated for about a second, at least
// once; it is left out if one pass would take some seconds.
class PaperFigure {
 public:
  // `scenes` describes the scenes; `columns` are the table's headings for the values that
  // distinguish them.
  PaperFigure(const std::string& scenes, const std::string& columns, int passes);

  // Measures a scene. `columns` are its values under those headings, `x` its place in the chart.
  void add(const CollisionScene& scene, const std::string& columns, double x);

  // Writes NAME.csv and NAME.svg, and the table to standard output. Returns false if two methods
  // found different candidates or hits, which it reports on standard error. Throws FileError as
  // write_text().
  bool write(const std::filesystem::path& directory, const std::string& name,
             const std::string& title, const std::string& note, const std::string& x_title) const;

 private:
  int passes_;
  std::ostringstream csv_;
  std::array<sim::PlotSeries, 3> by_bound_{sim::PlotSeries{"by spheres", {}, {}},
                                           sim::PlotSeries{"by boxes", {}, {}},
                                           sim::PlotSeries{"by spheres, then boxes", {}, {}}};
  sim::PlotSeries brute_{"brute force", {}, {}};
  bool right_ = true;
};

}  // namespace weft::bench
