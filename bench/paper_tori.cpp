// The paper's two tori: timed at a fixed pose, and approaching each other from many directions.
#include <cstdio>
#include <sstream>

#include "bench/approach.h"
#include "bench/experiments.h"
#include "bench/paper_measurement.h"
#include "sim/view/plot.h"

namespace weft::bench {

namespace {

// Measures growth with the number of triangles, against brute force.
bool run_fixed_pose(const PaperOptions& options) {
  PaperFigure figure("two linked tori of n x n vertices each", "n,triangles", options.passes);
  for (const int n : options.sizes) {
    const long triangles = 4L * n * n;
    figure.add(make_scene("tori", n), std::to_string(n) + ',' + std::to_string(triangles),
               static_cast<double>(triangles));
  }
  return figure.write(options.directory, "paper_tori", "Two tori in contact",
                      "both rebuilt every pass; one thread", "triangles of both");
}

// Compares first contacts with those of the smooth surfaces.
bool run_approach(const PaperOptions& options) {
  const std::vector<Approach> approaches =
      approach_from_all_sides(make_paper_torus(options.approach_size), options.directions);
  std::ostringstream csv;
  csv << "# a torus of " << options.approach_size << " x " << options.approach_size
      << " vertices comes near another; distances of the centres at first contact, m; leaf: the "
         "longest edge of a quad\n"
      << "direction_x,direction_y,direction_z,found,expected,difference,leaf,steps,hits\n";
  sim::PlotSeries differences{"a direction", {}, {}, false};
  bool right = true;
  for (const Approach& a : approaches) {
    const double difference = a.found - a.expected;
    right = right && a.touched && std::abs(difference) <= a.leaf;
    csv << a.direction.x() << ',' << a.direction.y() << ',' << a.direction.z() << ',' << a.found
        << ',' << a.expected << ',' << difference << ',' << a.leaf << ',' << a.steps << ','
        << a.hits << '\n';
    differences.x.push_back(1e3 * a.expected);
    differences.y.push_back(1e3 * difference);
  }
  const sim::Plot plot{
      "First contact of two tori from " + std::to_string(options.directions) + " directions",
      "a leaf is " + std::to_string(std::lround(1e3 * approaches.front().leaf)) +
          " mm; the meshes are inscribed, and touch later",
      {"distance of the centres at first contact, mm", false},
      {"found - expected, mm", false},
      {differences}};
  sim::write_text(csv.str(), options.directory / "paper_tori_approach.csv");
  sim::write_svg(plot, options.directory / "paper_tori_approach.svg");
  double worst = 0;
  for (const Approach& a : approaches) worst = std::max(worst, std::abs(a.found - a.expected));
  std::printf("%zu approaches; first contacts off by %.3g mm at most, a leaf is %.3g mm\n",
              approaches.size(), 1e3 * worst, 1e3 * approaches.front().leaf);
  if (!right) std::fputs("paper-tori: a first contact is not within a leaf\n", stderr);
  return right;
}

}  // namespace

int run_paper_tori(const PaperOptions& options) {
  const bool timed = run_fixed_pose(options);
  return run_approach(options) && timed ? 0 : 1;
}

}  // namespace weft::bench
