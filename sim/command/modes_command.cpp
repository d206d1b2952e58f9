#include "sim/command/modes_command.h"

#include <array>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <vector>

#include "sim/base/stopwatch.h"
#include "sim/case/case_reader.h"
#include "sim/case/case_text.h"
#include "sim/command/command_json.h"
#include "sim/command/guarded_command.h"
#include "sim/command/progress_bar.h"
#include "sim/modes/buckling_modes.h"
#include "sim/modes/case_equilibrium.h"
#include "sim/modes/left_out.h"
#include "sim/modes/mode_trajectory.h"
#include "sim/modes/vibration_modes.h"
#include "sim/motion/dynamics.h"
#include "sim/run/input_files.h"
#include "sim/run/restart.h"
#include "sim/trajectory/xdmf_file.h"

namespace weft::sim {

namespace {

std::string formatted(const char* format, auto... values) {
  std::array<char, 200> text;
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

// The steps that `weft modes` and `weft buckling` share.
class Analysis {
 public:
  // Reads the case. Throws CaseError as read_case() does, and FileError if the trajectory exists
  // and may not be overwritten.
  Analysis(const ModesCommand& command, const std::string& suffix,
           std::optional<std::string>& title)
      : command_(command), source_(read_case(command.run.case_path, command.run.overrides)) {
    read_restart(source_);
    title = report_.title = source_.title;
    if (!command.writes) return;
    const auto name = std::filesystem::path(command.run.case_path).stem().string() + suffix;
    path_ = (std::filesystem::path(command.run.directory) / (name + ".h5")).string();
    const auto sidecar = std::filesystem::path(path_).replace_extension(".xdmf");
    for (const std::string& written : {path_, sidecar.string()})
      refuse_input_file(written, source_, "Weft");
    TrajectoryWriter::refuse_existing(path_, command.run.force);
  }

  const Case& source() const { return source_; }
  CaseEquilibrium& equilibrium() { return *equilibrium_; }
  ModesReport& report() { return report_; }

  // Finds the state about which modes are computed, and warns of forces that they leave out.
  // Returns false if no state is found; report() then has the failure.
  bool find_state(std::optional<double> load_factor) {
    ProgressBar bar(source_.time.duration, !command_.run.quiet);
    equilibrium_.emplace(source_, EquilibriumOptions{.start_shape = command_.start_shape,
                                                     .load_factor = load_factor,
                                                     .progress = [&](double t) { bar.show(t); }});
    report_.about = command_.start_shape ? "start_shape" : "equilibrium";
    report_.load_factor = load_factor.value_or(1);
    report_.failure = equilibrium_->find();
    bar.clear();
    report_.time = equilibrium_->time();
    if (report_.failure) return false;
    report_.imbalance = equilibrium_->imbalance();
    warn(load_factor);
    return true;
  }

  void write(const std::vector<RecordedMode>& modes,
             const std::vector<TrajectoryWriter::Series>& series) {
    if (path_.empty() || report_.failure) return;
    if (const std::string notice = no_sidecar_notice(path_); !notice.empty())
      complain("weft: " + notice);
    Bill bill;
    bill.total = bill.run = command_.run.started.elapsed();
    write_modes(*equilibrium_, modes, {path_, command_.run.force, command_.frames_per_mode, series},
                bill);
    report_.trajectory = path_;
  }

  // Returns the table followed by the number of unknowns, the CPU time and, if a trajectory was
  // written, its path.
  std::string with_footer(std::string table, int unknowns) const {
    table += formatted("%s, %.3g s of CPU\n", counted(unknowns, "unknown", "unknowns").c_str(),
                       command_.run.started.elapsed().cpu);
    if (!report_.trajectory.empty()) table += "trajectory " + report_.trajectory + '\n';
    return table;
  }
  // With --json, prints the results as a JSON object. Otherwise prints the table, unless there is a
  // failure. Then prints a message about the failure, if there is one. Returns the exit code.
  int finish(const auto& modes, const std::string& table) {
    const int code = report_.failure ? exit_code::numerical_failure : exit_code::done;
    report_.cost = command_.run.started.elapsed();
    if (command_.run.json)
      std::cout << modes_json(command_.run, report_, modes, code) << '\n';
    else if (!report_.failure)
      std::cout << printable(table, true);
    if (report_.failure) complain("weft: " + report_.failure->text);
    return code;
  }

 private:
  // Warns of forces that modes leave out. Buckling is sought at multiples of the loads: they are
  // judged at the factor 1, since there may be none at `load_factor`.
  void warn(std::optional<double> load_factor) {
    Dynamics& dynamics = equilibrium_->dynamics();
    if (load_factor) dynamics.set_load_factor(1);
    report_.warnings = left_out_forces(dynamics, report_.time, equilibrium_->state());
    if (load_factor) dynamics.set_load_factor(*load_factor);
    for (const std::string& text : report_.warnings) complain("weft: " + text);
  }

  const ModesCommand& command_;
  Case source_;
  std::string path_;  // path of the trajectory; empty: no trajectory is written
  std::optional<CaseEquilibrium> equilibrium_;
  ModesReport report_;
};

std::string line_of(int number, const VibrationMode& mode) {
  if (mode.kind == VibrationMode::Kind::vibration)
    return formatted("%4d  %12.6g  %12.6g\n", number, mode.frequency(), mode.angular_frequency());
  if (mode.kind == VibrationMode::Kind::growth)
    return formatted("%4d  %12s  %12s  unstable: grows as exp(%.6g /s t)\n", number, "-", "-",
                     mode.growth_rate());
  return formatted(
      "%4d  %12d  %12d  %s\n", number, 0, 0,
      mode.kind == VibrationMode::Kind::rigid ? "rigid motion" : "slack: nothing resists it");
}

std::string table_of(const VibrationModes& found, const ModesReport& report) {
  std::string table =
      report.about == "start_shape"
          ? formatted("Modes about the start shape; forces out of balance by %.2g of the loads\n",
                      report.imbalance)
          : formatted("Modes about the equilibrium at t = %.6g s\n", report.time);
  table += formatted("mode  %12s  %12s\n", "frequency Hz", "omega rad/s");
  for (std::size_t i = 0; i < found.modes.size(); ++i)
    table += line_of(static_cast<int>(i + 1), found.modes[i]);
  return table;
}

std::string table_of(const BucklingModes& found, const ModesReport& report) {
  std::string table = formatted("Buckling from the equilibrium at load factor %.6g, t = %.6g s\n",
                                report.load_factor, report.time);
  table += formatted("mode  %20s\n", "critical load factor");
  for (std::size_t i = 0; i < found.modes.size(); ++i)
    table += formatted("%4d  %20.6g\n", static_cast<int>(i + 1), found.modes[i].load_factor);
  return table;
}

void write(Analysis& analysis, const VibrationModes& found) {
  std::vector<RecordedMode> modes;
  for (const VibrationMode& mode : found.modes)
    modes.push_back({mode.shape, {mode.eigenvalue, mode.frequency(), mode.growth_rate()}});
  analysis.write(modes, {{"eigenvalue", "1/s^2"}, {"frequency", "Hz"}, {"growth_rate", "1/s"}});
}

void write(Analysis& analysis, const BucklingModes& found) {
  std::vector<RecordedMode> modes;
  for (const BucklingMode& mode : found.modes) modes.push_back({mode.shape, {mode.load_factor}});
  analysis.write(modes, {{"load_factor", "1"}});
}

// Writes the found modes to the trajectory, if one is wanted and nothing has failed, and prints the
// results. Returns the exit code.
int deliver_modes(Analysis& analysis, const auto& found) {
  if (!analysis.report().failure) analysis.report().failure = found.failure;
  write(analysis, found);
  const std::string table = table_of(found, analysis.report());
  return analysis.finish(found, analysis.with_footer(table, found.unknowns));
}

}  // namespace

int show_modes(const ModesCommand& command) {
  return report_faults(command.run, [&](std::optional<std::string>& title) {
    Analysis analysis(command, "_modes", title);
    VibrationModes found;
    if (analysis.find_state(std::nullopt)) {
      CaseEquilibrium& about = analysis.equilibrium();
      found = find_vibration_modes(about.dynamics(), about.time(), about.state(), command.count);
    }
    return deliver_modes(analysis, found);
  });
}

int show_buckling(const ModesCommand& command) {
  return report_faults(command.run, [&](std::optional<std::string>& title) {
    Analysis analysis(command, "_buckling", title);
    require_load(analysis.source());
    BucklingModes found;
    if (analysis.find_state(command.load_factor)) {
      CaseEquilibrium& about = analysis.equilibrium();
      found = find_buckling_modes(about.dynamics(), about.time(), about.state(),
                                  command.load_factor, command.count);
    }
    return deliver_modes(analysis, found);
  });
}

}  // namespace weft::sim
