// weft-bench: the experiments, one subcommand each.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <functional>

#include "bench/experiments.h"
#include "bench/method_ladders.h"
#include "bench/scene_measurement.h"
#include "bench/scenes.h"
#include "bench/stability_grid.h"
#include "sim/case/case_text.h"

namespace {

using namespace weft::bench;

struct Arguments {
  HierarchyOptions hierarchy;
  RebuildOptions rebuild;
  PaperOptions paper;
  int narrow_phase_size = 128;
  GpuOptions gpu;
  GpuNarrowPhaseOptions gpu_narrow_phase;
  LinearSolverOptions linear_solver;
  AccuracyOptions accuracy;
  EnergyDriftOptions energy_drift;
  PreviewOptions preview;
  ScalingOptions scaling;
  StabilityOptions stability;
  CalibrateOptions calibrate;
  SkippingOptions skipping;
  ShellsOptions shells;
  SweepsOptions sweeps;
  ParticlesOptions particles;
  ContactOptions contact;
};

CLI::Option* add_numbers(CLI::App& sub, const char* name, std::vector<int>& numbers, int least,
                         int most, const char* description) {
  return sub.add_option(name, numbers, description)
      ->delimiter(',')
      ->check(CLI::Range(least, most))
      ->capture_default_str();
}

void add_sizes(CLI::App& sub, std::vector<int>& sizes, const char* description) {
  add_numbers(sub, "--sizes", sizes, 4, 8192, description);
}

void add_repeats(CLI::App& sub, int& repeats) {
  sub.add_option("--repeats", repeats, "Passes; times are medians over them")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
}

void add_hierarchy(CLI::App& sub, Arguments& arguments) {
  HierarchyOptions& options = arguments.hierarchy;
  sub.add_flag("--json", options.json, "Print one JSON object instead of tables");
  add_sizes(sub, options.sizes, "Images of n x n vertices");
  sub.add_option("--scenes", options.scenes, "Scenes (default: all)")
      ->delimiter(',')
      ->check(CLI::IsMember(scene_names()));
  sub.add_option("--methods", options.methods, "Methods (default: all)")
      ->delimiter(',')
      ->check(CLI::IsMember(method_names()));
  add_numbers(sub, "--threads", options.threads, 1, 1024, "Threads of Weft; peers use one");
  add_numbers(sub, "--growth", options.growth, 4, 8192, "Sizes of the growth of Weft's own cost");
  add_repeats(sub, options.repeats);
}

void add_rebuild(CLI::App& sub, Arguments& arguments) {
  RebuildOptions& options = arguments.rebuild;
  add_sizes(sub, options.sizes, "Sheets of n x n vertices");
  sub.add_option("--threads", options.threads, "Threads to compare with one")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  add_repeats(sub, options.repeats);
}

void add_paper(CLI::App& sub, Arguments& arguments) {
  sub.add_option("-o,--output", arguments.paper.directory, "Folder of the CSV files and plots")
      ->capture_default_str();
  sub.add_option("--passes", arguments.paper.passes, "Passes; times are medians over them")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
}

void add_paper_tori(CLI::App& sub, Arguments& arguments) {
  PaperOptions& options = arguments.paper;
  add_paper(sub, arguments);
  add_sizes(sub, options.sizes, "Tori of n x n vertices");
  sub.add_option("--directions", options.directions, "Directions of approach")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  sub.add_option("--approach-size", options.approach_size, "Tori of n x n vertices that approach")
      ->check(CLI::Range(8, 1024))
      ->capture_default_str();
}

void add_paper_particles(CLI::App& sub, Arguments& arguments) {
  add_paper(sub, arguments);
  sub.add_option("--torus-size", arguments.paper.torus_size, "Torus of n x n vertices")
      ->check(CLI::Range(4, 8192))
      ->capture_default_str();
  add_numbers(sub, "--particles", arguments.paper.particles, 1, 10'000'000, "Numbers of particles");
}

void add_narrow_phase(CLI::App& sub, Arguments& arguments) {
  sub.add_option("--size", arguments.narrow_phase_size, "Sheets of n x n vertices")
      ->check(CLI::Range(4, 8192))
      ->capture_default_str();
}

void add_linear_solver(CLI::App& sub, Arguments& arguments) {
  LinearSolverOptions& options = arguments.linear_solver;
  sub.add_flag("--json", options.json, "Print one JSON object instead of a table");
  add_sizes(sub, options.sizes, "Sheets of n x n vertices");
  sub.add_option("--gammas", options.gammas, "Steps times the formula's coefficient, s")
      ->delimiter(',')
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  add_numbers(sub, "--threads", options.threads, 1, 1024, "Threads");
  sub.add_option("--tolerance", options.tolerance, "Relative residual")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  sub.add_option("--bending", options.bending_stiffness, "Bending stiffness, N m")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  sub.add_option("--shell", options.shell_thickness,
                 "Thickness of a steel shell in place of the sheet, m")
      ->check(CLI::PositiveNumber);
  sub.add_option("--repeats", options.repeats, "Passes; times are medians over them")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
}

void add_accuracy(CLI::App& sub, Arguments& arguments) {
  AccuracyOptions& options = arguments.accuracy;
  sub.add_option("case", options.cases, "Case files")->required()->check(CLI::ExistingFile);
  sub.add_option("--set", options.overrides, "Override a key of the cases: KEY=VALUE")
      ->allow_extra_args(false);
  sub.add_option("--methods", options.methods, "Methods (default: all)")
      ->delimiter(',')
      ->check(CLI::IsMember(accuracy_methods()));
  const auto add_positive = [&](const char* name, auto& value, const char* description) {
    sub.add_option(name, value, description)->check(CLI::PositiveNumber)->capture_default_str();
  };
  add_positive("--horizon", options.horizon, "Compare at this time, s (default: the duration)");
  add_positive("--reference-tolerance", options.reference_tolerance,
               "Tolerance of the references, m");
  add_positive("--reference-budget", options.reference_budget, "CPU time of a reference, s");
  add_positive("--certainty", options.certainty,
               "The horizon ends where the two references part by more, m");
  add_positive("--budget", options.budget, "CPU time of a run, s");
  sub.add_option("--repeats", options.repeats, "Runs; times are medians over them")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  sub.add_flag("--json", options.json, "Print JSON instead of tables");
  sub.add_option("--plot", options.plot, "SVG file of the chart");
}

void add_preview(CLI::App& sub, Arguments& arguments) {
  PreviewOptions& options = arguments.preview;
  sub.add_option("case", options.cases, "Case files")->required()->check(CLI::ExistingFile);
  sub.add_option("--set", options.overrides, "Override a key of the cases: KEY=VALUE")
      ->allow_extra_args(false);
  add_numbers(sub, "--rates", options.rates, 1, 100'000, "Steps per second");
  sub.add_flag("--json", options.json, "Print one JSON object instead of a table");
}

void add_energy_drift(CLI::App& sub, Arguments& arguments) {
  EnergyDriftOptions& options = arguments.energy_drift;
  std::vector<std::string> methods;
  for (const Ladder& ladder : method_ladders()) methods.emplace_back(ladder.name);
  sub.add_option("case", options.path, "Case file")->required()->check(CLI::ExistingFile);
  sub.add_option("--set", options.overrides, "Override a key of the case: KEY=VALUE")
      ->allow_extra_args(false);
  sub.add_option("--methods", options.methods, "Methods (default: all)")
      ->delimiter(',')
      ->check(CLI::IsMember(methods));
  sub.add_option("--budget", options.budget, "CPU time of a run, s")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  sub.add_flag("--json", options.json, "Print one JSON object instead of a table");
  sub.add_option("--plot", options.plot, "SVG file of the chart");
}

void add_scaling(CLI::App& sub, Arguments& arguments) {
  ScalingOptions& options = arguments.scaling;
  sub.add_option("case", options.path, "Case file")->required()->check(CLI::ExistingFile);
  sub.add_option("--set", options.overrides, "Override a key of the case: KEY=VALUE")
      ->allow_extra_args(false);
  add_sizes(sub, options.sizes, "Images of the first body: n x n vertices");
  sub.add_option("--steps", options.steps, "Steps of each run")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  sub.add_flag("--json", options.json, "Print one JSON object instead of a table");
}

// Returns the fault of a slice's name; empty if there is none.
std::string is_slice(const std::string& name) {
  const std::vector<std::string> names = slice_names();
  if (std::find(names.begin(), names.end(), name) != names.end()) return "";
  return weft::sim::in_quotes(name) + " is no slice; " + weft::sim::name_hint(name, names);
}

void add_stability(CLI::App& sub, Arguments& arguments) {
  StabilityOptions& options = arguments.stability;
  sub.add_flag("--quick", options.quick, "A small grid whose cells should all finish");
  sub.add_option("--slice", options.slices, "Slices (default: all)")
      ->delimiter(',')
      ->check(is_slice);
  sub.add_option("--every", options.every, "Only every n-th cell: a sample of the grid")
      ->check(CLI::Range(1, 10'000))
      ->capture_default_str();
  sub.add_option("--limit", options.limit,
                 "CPU time at which a run of 81 vertices ends, s (default: 45 times the median, "
                 "measured)")
      ->check(CLI::PositiveNumber);
  sub.add_option("--jobs", options.jobs, "Runs at a time")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  sub.add_flag("--json", options.json, "Print JSON instead of a table");
  sub.add_option("--csv", options.csv, "CSV file of all runs");
  sub.add_option("--plot", options.plot, "SVG file of the heat map");
}

void add_calibrate(CLI::App& sub, Arguments& arguments) {
  CalibrateOptions& options = arguments.calibrate;
  sub.add_flag("--verify", options.verify, "Verify the built-in table on other scenes");
  sub.add_option("--scenes", options.scenes, "Scenes (default: all of their kind)")
      ->delimiter(',')
      ->check(CLI::IsMember(calibration_scene_names()));
  sub.add_option("--asked", options.asked, "Accuracies to check, m")
      ->delimiter(',')
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  const auto add_positive = [&](const char* name, double& value, const char* description) {
    sub.add_option(name, value, description)->check(CLI::PositiveNumber)->capture_default_str();
  };
  add_positive("--reference-tolerance", options.reference_tolerance,
               "Tolerance of the references, m");
  add_positive("--certainty", options.certainty, "Largest distance between the references, m");
  add_positive("--budget", options.budget, "CPU time of a run, s");
  sub.add_option("-o,--output", options.output,
                 "File of the table; sim/accuracy/calibration_table.inc is built in");
  sub.add_option("--plot", options.plot, "SVG file of the chart");
}

void add_skipping(CLI::App& sub, Arguments& arguments) {
  SkippingOptions& options = arguments.skipping;
  sub.add_option("--pairs", options.pairs, "Pairs of scenes (default: all)")
      ->delimiter(',')
      ->check(CLI::IsMember(skipping_pair_names()));
  add_repeats(sub, options.repeats);
  sub.add_flag("--json", options.json, "Print JSON instead of a table");
}

// Returns the fault of a text that no name of a check contains; empty if one does.
std::string is_in_check(const std::string& text) {
  const std::vector<std::string> names = shell_check_names();
  const bool found = std::ranges::any_of(
      names, [&](const std::string& name) { return name.find(text) != std::string::npos; });
  if (found) return "";
  return weft::sim::in_quotes(text) + " is in no name of a check; " +
         weft::sim::name_hint(text, names);
}

void add_shells(CLI::App& sub, Arguments& arguments) {
  ShellsOptions& options = arguments.shells;
  sub.add_option(
         "--cases", options.cases,
         "Cases of cases/benchmarks/, and triangle_springs, solver, calculix (default: all)")
      ->delimiter(',')
      ->check(CLI::IsMember(shell_case_names()));
  sub.add_option("--only", options.only, "Checks whose names contain this text; may be repeated")
      ->allow_extra_args(false)
      ->check(is_in_check);
  sub.add_flag("--list", options.list, "Print the names of the checks and run none");
  sub.add_flag("--json", options.json, "Print JSON instead of a table");
  sub.add_option("--plots", options.plots, "Folder of charts of errors (SVG)");
}

void add_contact(CLI::App& sub, Arguments& arguments) {
  ContactOptions& options = arguments.contact;
  add_sizes(sub, options.sizes, "Sheets of n x n vertices that drape over a ball");
  add_numbers(sub, "--threads", options.threads, 1, 1024, "Threads: a row of each for every sheet");
  sub.add_option("--stiffness", options.stiffnesses,
                 "Stiffnesses of contact: a row of 33 x 33 vertices for each, Pa/m")
      ->delimiter(',')
      ->check(CLI::PositiveNumber);
  sub.add_option("--duration", options.duration,
                 "Simulated time of every row, s (default: 1, or 0.5 for more than 129 x 129)")
      ->check(CLI::PositiveNumber);
  sub.add_flag("!--no-torus", options.torus, "Leave out cases/drape_torus.toml");
  sub.add_option("--looks", options.looks, "Times at which surfaces are checked for crossings")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  sub.add_option("--set", options.overrides, "Override a key of all cases: KEY=VALUE")
      ->allow_extra_args(false);
  sub.add_flag("--json", options.json, "Print JSON instead of a table");
  sub.add_option("--plots", options.plots, "Folder of charts of growth (SVG)");
}

void add_sweeps(CLI::App& sub, Arguments& arguments) {
  sub.add_option("--runs", arguments.sweeps.runs, "Runs of the sweep")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  sub.add_flag("--json", arguments.sweeps.json, "Print JSON instead of a table");
}

void add_particles(CLI::App& sub, Arguments& arguments) {
  ParticlesOptions& options = arguments.particles;
  add_numbers(sub, "--counts", options.counts, 1, 10'000'000, "Numbers of particles");
  sub.add_option("--seconds", options.seconds, "Time to simulate, s")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  sub.add_flag("--json", options.json, "Print one JSON object instead of a table");
}

#ifdef WEFT_BENCH_GPU
void add_backend(CLI::App& sub, std::string& backend) {
  sub.add_option("--backend", backend, "Device that runs the shaders")
      ->check(CLI::IsMember({"auto", "gpu", "osmesa"}))
      ->capture_default_str();
}

void add_gpu_narrow_phase(CLI::App& sub, Arguments& arguments) {
  GpuNarrowPhaseOptions& options = arguments.gpu_narrow_phase;
  add_backend(sub, options.backend);
  add_sizes(sub, options.sizes, "Sheets of n x n vertices");
  sub.add_option("--scenes", options.scenes, "Two sheets on each other, or one over a ball")
      ->delimiter(',')
      ->check(CLI::IsMember({"layers", "ball"}))
      ->capture_default_str();
  sub.add_option("--frictions", options.frictions, "Coulomb coefficients")
      ->delimiter(',')
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  add_repeats(sub, options.repeats);
}

void add_gpu(CLI::App& sub, Arguments& arguments) {
  GpuOptions& options = arguments.gpu;
  add_backend(sub, options.backend);
  add_sizes(sub, options.sizes, "Sheets of n x n vertices");
  sub.add_option("--scenes", options.scenes, "Sheets, each queried against itself")
      ->delimiter(',')
      ->check(CLI::IsMember({"rolled", "pleated", "crumpled", "drape"}))
      ->capture_default_str();
  add_repeats(sub, options.repeats);
}

void add_paper_lod(CLI::App& sub, Arguments& arguments) {
  PaperOptions& options = arguments.paper;
  sub.add_option("-o,--output", options.directory, "Folder of the CSV file and plot")
      ->capture_default_str();
  sub.add_option("--size", options.lod_size, "Columns n of each of the 48 patches of 2 n - 1 rows")
      ->check(CLI::Range(3, 1025))
      ->capture_default_str();
  sub.add_option("--frames", options.lod_frames, "Pictures for each median")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
}
#endif

struct Experiment {
  const char* name;
  const char* description;
  void (*add)(CLI::App& sub, Arguments& arguments);
  int (*run)(const Arguments& arguments);
};

constexpr std::array experiments{
    Experiment{"hierarchy", "Rebuild, query and exact test against other libraries", add_hierarchy,
               [](const Arguments& a) { return run_hierarchy(a.hierarchy); }},
    Experiment{"rebuild", "Rebuild of the pyramid and its parts against a copy", add_rebuild,
               [](const Arguments& a) { return run_rebuild(a.rebuild); }},
    Experiment{"paper-tori", "Two tori, at rest and approaching each other, against brute force",
               add_paper_tori, [](const Arguments& a) { return run_paper_tori(a.paper); }},
    Experiment{"paper-particles", "Particles against a torus, against brute force",
               add_paper_particles,
               [](const Arguments& a) { return run_paper_particles(a.paper); }},
    Experiment{"narrow-phase", "The narrow phase in batches against scalar functions",
               add_narrow_phase,
               [](const Arguments& a) { return run_narrow_phase(a.narrow_phase_size); }},
    Experiment{"linear-solver", "Multigrid against block-Jacobi, by size and step",
               add_linear_solver,
               [](const Arguments& a) { return run_linear_solver(a.linear_solver); }},
    Experiment{"accuracy", "Run time against error of all methods of time integration",
               add_accuracy, [](const Arguments& a) { return run_accuracy(a.accuracy); }},
    Experiment{"energy-drift", "Run time against the drift of energy, for the same methods",
               add_energy_drift,
               [](const Arguments& a) { return run_energy_drift(a.energy_drift); }},
    Experiment{"preview", "Linearly implicit steps: time, crossings, stretch and energy",
               add_preview, [](const Arguments& a) { return run_preview(a.preview); }},
    Experiment{"scaling", "Time and memory of a run by the size of its images", add_scaling,
               [](const Arguments& a) { return run_scaling(a.scaling); }},
    Experiment{"stability", "Extreme cases: each finishes correctly or reports why not",
               add_stability, [](const Arguments& a) { return run_stability(a.stability); }},
    Experiment{"calibrate", "The table behind time.accuracy, measured or verified", add_calibrate,
               [](const Arguments& a) { return run_calibrate(a.calibrate); }},
#ifdef WEFT_BENCH_GPU
    Experiment{"paper-lod", "Time of a picture against its level of detail", add_paper_lod,
               [](const Arguments& a) { return run_paper_lod(a.paper); }},
    Experiment{"gpu", "Pyramids and traversals in compute shaders against the CPU", add_gpu,
               [](const Arguments& a) { return run_gpu(a.gpu); }},
    Experiment{"gpu-narrow-phase", "Barriers and friction in compute shaders against the CPU",
               add_gpu_narrow_phase,
               [](const Arguments& a) { return run_gpu_narrow_phase(a.gpu_narrow_phase); }},
#endif
    Experiment{"shells", "Shells against closed forms and published figures", add_shells,
               [](const Arguments& a) { return run_shells(a.shells); }},
    Experiment{"skipping", "Cost of features that a scene does not need", add_skipping,
               [](const Arguments& a) { return run_skipping(a.skipping); }},
    Experiment{"particles", "Rigid particles that pour onto a torus, by their number",
               add_particles, [](const Arguments& a) { return run_particles(a.particles); }},
    Experiment{"contact", "Cost of cloth in contact, by size, threads and stiffness", add_contact,
               [](const Arguments& a) { return run_contact(a.contact); }},
    Experiment{"sweeps", "Cost of planning, listing and looking at many runs", add_sweeps,
               [](const Arguments& a) { return run_sweeps(a.sweeps); }},
};

// Returns the fault of the arguments, with the nearest name to an unknown experiment.
std::string reason(const CLI::App& app, const CLI::ParseError& error) {
  const std::vector<std::string> unknown = app.remaining(true);
  if (unknown.empty() || !app.get_subcommands().empty()) return error.what();
  std::vector<std::string> names;
  names.reserve(experiments.size());
  for (const Experiment& experiment : experiments) names.emplace_back(experiment.name);
  return weft::sim::in_quotes(unknown[0]) + " is unknown; " +
         weft::sim::name_hint(unknown[0], names);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Experiments on Weft's speed. Ratios within one run hold on any machine."};
  app.name("weft bench");
  app.require_subcommand(1);
  Arguments arguments;
  std::function<int()> run;
  for (const Experiment& experiment : experiments) {
    CLI::App* sub = app.add_subcommand(experiment.name, experiment.description);
    experiment.add(*sub, arguments);
    sub->callback([&] { run = [&] { return experiment.run(arguments); }; });
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {
    return app.exit(asked);
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "weft bench: %s\n", reason(app, error).c_str());
    return 2;
  }
  try {
    return run();
  } catch (const std::runtime_error& error) {
    std::fprintf(stderr, "weft bench: %s\n", error.what());
    return 4;
  }
}
