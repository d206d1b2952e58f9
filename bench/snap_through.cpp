#include "bench/snap_through.h"

#include "bench/roof_paths.h"

namespace weft::bench {

namespace {

std::vector<Measured> measure_limit(const sim::Case& source) {
  return {by_name("load factor", follow_by_arc_length(source).first_limit(),
                  "hinged_roof_limit_factor")};
}

// Compares the points of the roof that is pushed with the path by arc length of the same image. The
// error is their distance in ranges of that path.
std::vector<Measured> measure_distance(const sim::Case& source) {
  const CheckedImage same{source.body.at(0).shape.resolution};
  const RoofPath path =
      follow_by_arc_length(case_of({.case_name = "hinged_roof_arc_length"}, same));
  const RoofPath points = follow_by_displacement(source);
  return {{"distance",
           largest_distance(points, path),
           {0, "the path by arc length; in its ranges of deflection and load"},
           1}};
}

}  // namespace

std::vector<CaseCheck> snap_through_checks() {
  return {
      {.name = "hinged roof, limit load",
       .case_name = "hinged_roof_arc_length",
       .images = squares({{5, 0}, {9, 1e-2}, {17, 0}}),
       .measure_case = measure_limit},
      {.name = "hinged roof, pushed against arc length",
       .case_name = "hinged_roof_displacement",
       .overrides = {"time.frames_per_second=2"},
       .images = squares({{5, 5e-3}, {9, 5e-3}}),
       .measure_case = measure_distance},
  };
}

}  // namespace weft::bench
