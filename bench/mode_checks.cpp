#include "bench/mode_checks.h"

#include <numbers>
#include <stdexcept>

#include "sim/modes/buckling_modes.h"
#include "sim/modes/case_equilibrium.h"
#include "sim/modes/vibration_modes.h"

namespace weft::bench {

namespace {

using std::numbers::pi;

// The lowest modes of a case that are no rigid motions.
std::vector<sim::VibrationMode> vibrations(const sim::Case& source, int count) {
  sim::CaseEquilibrium about(source, {});
  if (const auto failure = about.find()) throw std::runtime_error(failure->text);
  sim::VibrationModes found =
      sim::find_vibration_modes(about.dynamics(), about.time(), about.state(), count + 6);
  if (found.failure) throw std::runtime_error(found.failure->text);
  std::erase_if(found.modes, [](const sim::VibrationMode& mode) {
    return mode.kind != sim::VibrationMode::Kind::vibration;
  });
  return found.modes;
}

CaseCheck plate_modes(const std::string& edges) {
  const auto measure = [edges](const sim::Case& source) {
    const std::vector<sim::VibrationMode> modes = vibrations(source, 6);
    std::vector<Measured> all;
    for (int i = 0; i < 6; ++i) {
      const std::string number = std::to_string(i + 1);
      all.push_back(by_name("mode " + number, modes.at(i).angular_frequency(),
                            "square_plate_" + edges + "_" + number));
    }
    return all;
  };
  return {.name = "square plate, " + edges + ", six modes",
          .case_name = "plate_modes_" + edges,
          .images = squares({{8, 0}, {16, 5e-4}, {32, 0}}),
          .measure_case = measure};
}

std::vector<Measured> measure_buckling(const sim::Case& source, ReferenceFigure critical) {
  sim::CaseEquilibrium about(source, {.load_factor = 0, .progress = {}});
  if (const auto failure = about.find()) throw std::runtime_error(failure->text);
  const sim::BucklingModes found =
      sim::find_buckling_modes(about.dynamics(), about.time(), about.state(), 0, 1);
  if (found.failure) throw std::runtime_error(found.failure->text);
  return {relative("factor", found.modes.at(0).load_factor, std::move(critical))};
}

CaseCheck buckling(std::string name, std::string case_name, std::vector<CheckedImage> images,
                   const ReferenceFigure& critical) {
  return {.name = std::move(name),
          .case_name = std::move(case_name),
          .images = std::move(images),
          .measure_case = [critical](const sim::Case& source) {
            return measure_buckling(source, critical);
          }};
}

}  // namespace

std::vector<CaseCheck> mode_checks() {
  const ReferenceFigure own_weight = reference_figure("self_weight_column");
  return {
      plate_modes("ssss"),
      plate_modes("cccc"),
      plate_modes("cscs"),
      plate_modes("ffff"),
      buckling("square plate, buckling", "plate_buckling", squares({{8, 0}, {16, 1e-3}, {32, 0}}),
               {4 * pi * pi, "4 pi^2 D / b^2"}),
      buckling("Euler column", "euler_column", strips({{11, 0}, {19, 1e-3}}),
               {1e-3 * pi * pi / 4, "pi^2 E I / (4 L^2)"}),
      buckling("column under its weight", "column_under_weight", strips({{11, 0}, {19, 1e-3}}),
               {own_weight.value * 1e-2 / 0.981, own_weight.source}),
  };
}

}  // namespace weft::bench
