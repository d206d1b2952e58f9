#include "bench/material_checks.h"

#include <algorithm>
#include <utility>

#include "bench/cloth_runs.h"
#include "bench/medians.h"
#include "bench/membrane_measures.h"
#include "bench/triangle_springs.h"
#include "sim/run/make_simulation.h"

namespace weft::bench {

namespace {

using Pulls = std::function<std::vector<FabricPull>(const sim::Case&)>;

std::vector<Measured> measure_pulls(const std::vector<FabricPull>& pulls,
                                    const std::string& source) {
  std::vector<Measured> all;
  for (const FabricPull& each : pulls)
    all.push_back(relative(each.stretch, each.force, {each.published, source}));
  return all;
}

CaseCheck stretched_fabric(const std::string& stretch, const MeasuredFabric& fabric, Pulls pulls,
                           const std::string& case_name = "stretched_fabric",
                           const std::vector<int>& resolution = {6, 11}) {
  int negative = 0;
  for (const auto& row : fabric.stretch)
    negative += static_cast<int>(std::ranges::count_if(row, [](double each) { return each < 0; }));
  const std::string source =
      "Wang, O'Brien and Ramamoorthi 2011: fitted coefficients, not readings, evaluated as ARCSim "
      "0.2 does; " +
      std::to_string(negative) + " negative ones count as 0 (weft info --materials lists them)";
  return {.name = stretch + ", " + fabric.name,
          .case_name = case_name,
          .overrides = {"material.fabric.preset=\"" + fabric.name + '"'},
          .images = {{resolution, 5e-3}},
          .measure_case = [pulls = std::move(pulls), source](const sim::Case& sheet) {
            return measure_pulls(pulls(sheet), source);
          }};
}

// Pulls with free sides along warp and weft. At 6 % the energy of three knits is no longer convex:
// their sheets widen or take zigzags.
std::vector<FabricPull> free_pulls(const sim::Case& sheet, const MeasuredFabric& fabric) {
  const bool is_convex = fabric.name != "ivory-rib-knit" && fabric.name != "camel-ponte-roma" &&
                         fabric.name != "tango-red-jet-set";
  std::vector<FabricPull> all;
  for (const bool along_warp : {true, false}) {
    all.push_back(free_pull(sheet, fabric, along_warp, 1.02));
    if (is_convex) all.push_back(free_pull(sheet, fabric, along_warp, 1.06));
  }
  return all;
}

// The pull of the whole sheet along its warp, at 45 degrees to it and along its weft, with the
// width held; that along warp and weft with free sides; and that of equal stretch.
std::vector<CaseCheck> fabric_checks() {
  std::vector<CaseCheck> checks;
  for (const MeasuredFabric& fabric : measured_fabrics()) {
    checks.push_back(stretched_fabric("uniaxial stretch", fabric, [fabric](const sim::Case& sheet) {
      std::vector<FabricPull> all;
      for (const double degrees : {0.0, 45.0, 90.0}) {
        const std::vector<FabricPull> pulls = uniaxial_pulls(sheet, fabric, degrees);
        all.insert(all.end(), pulls.begin(), pulls.end());
      }
      return all;
    }));
    checks.push_back(
        stretched_fabric("uniaxial pull, free sides", fabric,
                         [fabric](const sim::Case& sheet) { return free_pulls(sheet, fabric); },
                         "pulled_fabric", {3, 5}));
    checks.push_back(stretched_fabric("biaxial stretch", fabric, [fabric](const sim::Case& sheet) {
      return biaxial_pulls(sheet, fabric);
    }));
  }
  return checks;
}

std::vector<Measured> compare_moduli(const sim::Case& source, const LatticeModuli& moduli) {
  const double stiffness = source.material.at(0).membrane_stiffness, third = 1.0 / 3;
  const std::string origin = "isotropic membrane with Poisson's ratio 1/3";
  return {relative("E h", moduli.stretch_stiffness(), {stiffness, origin}),
          relative("nu", moduli.poisson_ratio(), {third, origin}),
          relative("G h", moduli.c66, {stiffness / (2 * (1 + third)), origin})};
}
int cells_of(const sim::Case& source) { return source.body.at(0).shape.resolution.at(0) - 1; }

CaseCheck strain_limit(const std::string& method, std::vector<std::string> overrides = {}) {
  overrides.push_back("time.method=\"" + method + '"');
  return {.name = "strain limit under 10 x weight, " + method,
          .case_name = "strain_limit",
          .overrides = std::move(overrides),
          .images = {{{9, 9}}, {{17, 17}}},
          .bound = Bound::at_most,
          .measure_case = [](const sim::Case& source) {
            const RunStrain strain = largest_strains(source);
            return std::vector{
                relative("largest strain", std::max(strain.at_ends, strain.within),
                         {source.material.at(0).strain_limit.value(), "strain_limit of the case"})};
          }};
}

CaseCheck loss_factor(const std::string& name, const std::string& case_name, int axis,
                      std::vector<int> resolution, std::vector<std::string> overrides = {}) {
  return {.name = "loss factor from a ring-down, " + name,
          .case_name = case_name,
          .overrides = std::move(overrides),
          .images = {{std::move(resolution), 2e-2}},
          .measure_case = [axis](const sim::Case& source) {
            return std::vector{
                relative("loss factor", ring_down(source, axis).loss_factor,
                         {source.material.at(0).loss_factor.value(),
                          "loss_factor of the case; decrement pi eta / sqrt(1 - eta^2 / 4)"})};
          }};
}

std::vector<Measured> measure_crease(const sim::Case& source) {
  sim::Simulation strip = sim::make_simulation(source);
  const sim::MaterialCase& paper = source.material.at(0);
  const sim::BodyCase& body = source.body.at(0);
  advance_to(strip, source.time.duration);
  const double curvature = 1 / *body.start->bend_radius;
  const double angle = (1 - paper.hardening.value()) * (curvature - paper.yield_curvature.value()) *
                       body.shape.size.at(0);
  return {relative("angle, rad", turning_angle(strip.scene(), strip.position(body.name)),
                   {angle, "(1 - hardening) (curvature - yield_curvature) length"})};
}

}  // namespace

std::vector<CaseCheck> lattice_checks() {
  return {
      {.name = "spring lattice",
       .case_name = "spring_lattice",
       .images = squares({{9, 0}, {17, 0}, {33, 0}, {65, 0}}),
       .measure_case =
           [](const sim::Case& source) {
             return compare_moduli(source, lattice_moduli(source, cells_of(source)));
           }},
      {.name = "spring lattice, extrapolated",
       .case_name = "spring_lattice",
       .images = squares({{9, 0}, {33, 1e-3}}),
       .measure_case =
           [](const sim::Case& source) {
             return compare_moduli(source, refined_moduli(source, cells_of(source)));
           }},
  };
}

std::vector<CaseCheck> material_checks() {
  std::vector<CaseCheck> checks = fabric_checks();
  const CaseCheck others[] = {
      strain_limit("cvode"),
      strain_limit("arkode"),
      strain_limit("euler", {"time.step=0.005"}),
      strain_limit("implicit_midpoint", {"time.step=0.001"}),
      strain_limit("verlet"),
      strain_limit("static", {"time.frames_per_second=30"}),
      loss_factor("bending", "ring_down_bending", 2, {2, 17}),
      loss_factor("bending of a shell", "ring_down_bending", 2, {4, 17},
                  {"body.strip.material=\"shell\""}),
      loss_factor("membrane", "ring_down_membrane", 0, {2, 26}),
      {.name = "crease angle after unloading",
       .case_name = "crease",
       .images = {{{5, 21}, 2e-2}, {{9, 41}, 2e-2}},
       .measure_case = measure_crease},
  };
  checks.insert(checks.end(), std::begin(others), std::end(others));
  return checks;
}

TablePart triangle_springs_part() {
  const std::string name = "Delingette springs against St. Venant-Kirchhoff";
  return {.checks = {name}, .case_name = "triangle_springs", .run = [name](const RowSink& done) {
            constexpr int count = 2000;
            CheckRow row{.check = name,
                         .bound = Bound::error,
                         .limit = 1e-12,
                         .source = "energy by the Green strain in the plane of the rest triangle"};
            row.cpu_s = cpu_time_of([&] {
              for (const TriangleEnergies& each : random_triangle_energies(count)) {
                const double error = std::abs(each.springs / each.green_strain - 1);
                if (!row.quantity.empty() && error <= row.error()) continue;
                row.quantity = "worst of " + std::to_string(count);
                row.value = each.springs;
                row.reference = row.scale = each.green_strain;
              }
            });
            done(row);
          }};
}

}  // namespace weft::bench
