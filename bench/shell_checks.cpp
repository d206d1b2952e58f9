#include "bench/shell_checks.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "bench/end_load_elastica.h"
#include "sim/integrator/integrator.h"
#include "sim/run/make_simulation.h"

namespace weft::bench {

namespace {

using std::numbers::pi;

// The strip of length 10 ends at x = 5. Displacements of the tip, in lengths, at all 20 loads.
std::vector<Measured> measure_end_shear(const FramedBody& strip, int frame) {
  if (frame == 0) return {};
  const ElasticaTip exact = end_load_elastica(0.2 * frame);
  const sim::Vec3 way = strip.way(0, -1) / 10;
  const std::string source =
      "inextensible elastica, elliptic integrals (Bisshopp and Drucker 1945)";
  return {relative("inward", -way.x(), {exact.inward, source}),
          relative("across", way.z(), {exact.across, source})};
}

// A strip of length 12 under a moment that bends it to the angle t 2 pi. Errors are in lengths.
std::vector<Measured> measure_end_moment(const FramedBody& strip, int frame) {
  if (frame == 0) return {};
  const double angle = 2 * pi * frame / 8;
  const sim::Vec3 way = strip.way(0, -1) / 12;
  const std::string source = "circle of the angle M L / (E I)";
  return {{"inward", -way.x(), {1 - std::sin(angle) / angle, source}, 1},
          {"across", way.z(), {(1 - std::cos(angle)) / angle, source}, 1}};
}

std::vector<Measured> measure_sag(const FramedBody& sheet, int frame, const std::string& gamma) {
  if (frame != 10) return {};
  const sim::Vec3& tip = sheet.now(0, -1);
  return {by_name("drop", -tip.z(), "heavy_elastica_" + gamma + "_drop"),
          by_name("reach", tip.x() - sheet.start(0, 0).x(), "heavy_elastica_" + gamma + "_reach")};
}

CaseCheck heavy_elastica(const std::string& gamma,
                         const std::vector<std::pair<int, double>>& columns) {
  // Gamma = rho h g L^3 / D is 12 times g.
  const std::string gravity = std::to_string(-std::stod(gamma) / 12);
  return {.name = "heavy elastica, Gamma = " + gamma,
          .case_name = "heavy_elastica",
          .overrides = {"world.gravity={ times = [0, 1], values = [[0, 0, 0], [0, 0, " + gravity +
                        "]] }"},
          .images = strips(columns),
          .measure = [gamma](const FramedBody& sheet, int frame) {
            return measure_sag(sheet, frame, gamma);
          }};
}

// A strip that stands exactly upright stays in its plane until it is unstable. The value is the
// middle of the step in which it becomes so, in critical weights.
std::vector<Measured> measure_upright_strip(const sim::Case& source) {
  sim::Simulation strip = sim::make_simulation(source);
  while (strip.time() < source.time.duration) {
    const double before = strip.time();
    if (const auto failure = strip.step()) throw std::runtime_error(failure->text);
    if (strip.integrator().path_point()->negative_directions > 0)
      return {relative("critical weight", 0.5 * (before + strip.time()),
                       {1, "Timoshenko and Gere 1961, section 6.3: q L^3 = 12.85 sqrt(E I G J)"})};
  }
  throw std::runtime_error("the strip is stable up to the end");
}

std::vector<Measured> measure_slit_plate(const FramedBody& plate, int frame) {
  if (frame != 20) return {};
  return {by_name("inner corner", plate.way(-1, 0).z(), "slit_annular_plate_inner"),
          by_name("outer corner", plate.way(0, 0).z(), "slit_annular_plate_outer")};
}

std::vector<Measured> measure_open_cylinder(const FramedBody& octant, int frame) {
  if (frame != 40) return {};
  return {by_name("loaded", octant.way(-1, 0).x(), "open_cylinder_loaded"),
          by_name("side", -octant.way(-1, -1).y(), "open_cylinder_side"),
          by_name("free end", -octant.way(0, -1).y(), "open_cylinder_free_end")};
}

std::vector<Measured> measure_full_hemisphere(const FramedBody& quarter, int frame) {
  if (frame != 8) return {};
  return {by_name("outward", quarter.way(0, 0).x(), "hemisphere_full_load_outward"),
          by_name("inward", -quarter.way(0, -1).y(), "hemisphere_full_load_inward")};
}

std::vector<Measured> measure_small_hemisphere(const FramedBody& quarter, int frame) {
  if (frame == 0) return {};
  constexpr double load = 1e-3;
  return {by_name("outward", quarter.way(0, 0).x() / load, "hemisphere_with_hole_linear"),
          by_name("inward", -quarter.way(0, -1).y() / load, "hemisphere_with_hole_linear")};
}

// The displacement of the loaded point at the end of the first row.
double pulled(const sim::Case& source) {
  sim::Simulation hemisphere = sim::make_simulation(source);
  const double start = hemisphere.position("hemisphere")[0].x();
  advance_to(hemisphere, 1);
  return hemisphere.position("hemisphere")[0].x() - start;
}
std::vector<Measured> measure_patches(const sim::Case& source) {
  CheckedImage whole{source.body.at(0).shape.resolution};
  const double one = pulled(case_of({.case_name = "hemisphere_linear"}, whole));
  return {relative("outward", pulled(source) / 1e-3, {one / 1e-3, "the same image as one patch"})};
}

std::vector<Measured> measure_scordelis_lo(const FramedBody& roof, int frame) {
  if (frame == 0) return {};
  constexpr double load = 1e-4;
  return {by_name("deflection", -roof.way(-1, -1).x() / load, "scordelis_lo_thin_shell")};
}

std::vector<Measured> measure_pinched_cylinder(const FramedBody& octant, int frame) {
  if (frame == 0) return {};
  return {by_name("deflection", -octant.way(-1, 0).x(), "pinched_cylinder")};
}

}  // namespace

std::vector<CaseCheck> strip_checks() {
  return {
      {.name = "cantilever, end shear",
       .case_name = "cantilever_end_shear",
       .images = strips({{7, 0}, {11, 3e-3}, {19, 1e-4}, {35, 0}}),
       .measure = measure_end_shear},
      {.name = "cantilever, end moment",
       .case_name = "cantilever_end_moment",
       .images = strips({{16, 0}, {32, 6e-4}, {64, 0}}),
       .measure = measure_end_moment},
      heavy_elastica("1", {{19, 0}, {35, 5e-4}}),
      heavy_elastica("10", {{19, 0}, {35, 5e-4}}),
      heavy_elastica("100", {{19, 0}, {35, 5e-4}, {67, 0}}),
      heavy_elastica("1000", {{35, 0}, {67, 2e-3}}),
      // Thin and very narrow, as the closed form has it: it neglects that the clamp holds the
      // twist, and that the strip sags in its plane.
      {.name = "narrow strip buckling sideways",
       .case_name = "narrow_strip",
       .overrides = {"body.0.rotation_deg=[90,0,0]", "body.0.shape.size=[1,0.01]",
                     "material.strip.shell_thickness=1e-4",
                     "world.gravity={ times = [0, 2], values = [[0, 0, 0], "
                     "[0, 0, -0.030287740462380686]] }",
                     "time.duration=1.1", "time.frames_per_second=200"},
       .images = strips({{33, 0}, {65, 1e-2}}),
       .measure_case = measure_upright_strip},
  };
}

std::vector<CaseCheck> shell_checks() {
  return {
      {.name = "slit annular plate",
       .case_name = "slit_annular_plate",
       .images = {{{6, 33}, 1e-2}, {{9, 49}, 1e-2}},
       .measure = measure_slit_plate},
      {.name = "open cylinder pulled apart",
       .case_name = "open_cylinder",
       .images = {{{9, 13}, 5e-2}, {{17, 25}, 3e-2}},
       .measure = measure_open_cylinder},
      {.name = "hemisphere with hole, full load",
       .case_name = "hemisphere_full_load",
       .images = squares({{8, 0}, {16, 3e-2}, {32, 6e-3}}),
       .measure = measure_full_hemisphere},
      {.name = "hemisphere with hole, linear",
       .case_name = "hemisphere_linear",
       .images = squares({{9, 0}, {17, 3e-3}, {33, 0}}),
       .measure = measure_small_hemisphere},
      {.name = "hemisphere of 2 x 2 patches",
       .case_name = "hemisphere_patches",
       .images = squares({{17, 0}, {25, 1e-3}}),
       .measure_case = measure_patches},
      {.name = "Scordelis-Lo roof",
       .case_name = "scordelis_lo",
       .images = squares({{5, 0}, {9, 1e-3}, {17, 2e-4}, {33, 0}}),
       .measure = measure_scordelis_lo},
      {.name = "pinched cylinder",
       .case_name = "pinched_cylinder",
       .images = squares({{9, 0}, {17, 2e-2}, {33, 3e-3}, {65, 0}}),
       .measure = measure_pinched_cylinder},
  };
}

}  // namespace weft::bench
