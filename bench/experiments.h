// The experiments of weft-bench: one function and one file each. main.cpp describes them to the
// user.
//
// Each returns the exit code: 0, or 1 if its results are wrong (sets that differ, a contact at the
// wrong distance), which it reports on standard error.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace weft::bench {

// Weft and its peers on the scenes of bench/scenes.h.
struct HierarchyOptions {
  bool json = false;
  std::vector<int> sizes{128, 256, 512};
  std::vector<std::string> scenes;                         // empty: all
  std::vector<std::string> methods;                        // empty: all
  std::vector<int> threads{1};                             // of Weft; peers use one
  std::vector<int> growth{64, 128, 256, 512, 1024, 2048};  // sizes for the growth of Weft's cost
  int repeats = 7;
};
int run_hierarchy(const HierarchyOptions& options);

// Rebuild of the pyramid and its parts, compared with a copy, and on several threads.
struct RebuildOptions {
  std::vector<int> sizes{64, 128, 200, 256, 257, 512, 1024, 2048};
  int threads = 1;
  int repeats = 101;
};
int run_rebuild(const RebuildOptions& options);

struct PaperOptions {
  std::filesystem::path directory = "out";
  std::vector<int> sizes{32, 64, 128, 256, 512, 1024};
  int passes = 1000;
  int torus_size = 256;                                // paper-particles
  int directions = 200;                                // paper-tori
  int approach_size = 128;                             // paper-tori: of the tori that approach
  std::vector<int> particles{1'000, 10'000, 100'000};  // paper-particles
  int lod_size = 65;   // paper-lod: columns of each of the 48 patches of 2 n - 1 rows
  int lod_frames = 5;  // paper-lod: pictures for each median
};
int run_paper_tori(const PaperOptions& options);
int run_paper_particles(const PaperOptions& options);
// Writes paper_lod.csv and .svg, and the table to standard output. Needs gpu/: throws
// std::runtime_error without.
int run_paper_lod(const PaperOptions& options);

// The narrow phase in batches compared with scalar functions, on sheets of n x n vertices.
int run_narrow_phase(int size);

// The pyramids and traversals of gpu/ compared with those of the CPU. Needs gpu/; throws
// std::runtime_error without the device.
struct GpuOptions {
  std::string backend = "auto";  // "gpu", "osmesa"
  std::vector<int> sizes{256, 512, 1024, 2048, 4096};
  std::vector<std::string> scenes{"drape", "crumpled"};
  int repeats = 7;
};
int run_gpu(const GpuOptions& options);

// The narrow phase of contact on the device compared with that of the CPU. Needs gpu/; throws
// std::runtime_error without the device.
struct GpuNarrowPhaseOptions {
  std::string backend = "auto";  // "gpu", "osmesa"
  std::vector<int> sizes{65, 129, 257, 513, 1025};
  std::vector<std::string> scenes{"layers", "ball"};
  std::vector<double> frictions{0.3, 0};  // Coulomb coefficients
  int repeats = 7;
};
int run_gpu_narrow_phase(const GpuNarrowPhaseOptions& options);

// The linear system of an implicit step of a sheet, solved with block-Jacobi and with multigrid.
struct LinearSolverOptions {
  bool json = false;
  std::vector<int> sizes{33, 65, 129, 257, 513};
  std::vector<double> gammas{1e-3, 1.0 / 60, 0.1};  // s
  std::vector<int> threads{1};
  double tolerance = 1e-4;       // relative residual
  double bending_stiffness = 0;  // N m
  double shell_thickness = 0;    // m, of a steel shell in place of cloth; 0: cloth
  int repeats = 7;
};
int run_linear_solver(const LinearSolverOptions& options);

// Run time against error of every time integration method, over a ladder of tolerances or steps, on
// case files.
struct AccuracyOptions {
  std::vector<std::string> cases;
  std::vector<std::string> overrides;  // of the cases: KEY=VALUE
  std::vector<std::string> methods;    // empty: all
  std::optional<double> horizon;       // s; the duration of the case
  double reference_tolerance = 1e-8;   // m
  double reference_budget = 600;       // s of CPU time
  double certainty = 1e-6;             // m: distance of two references at which the horizon ends
  double budget = 60;                  // s of CPU time, of one run
  int repeats = 1;
  bool json = false;
  std::filesystem::path plot;  // SVG file; empty: none
};
std::vector<std::string> accuracy_methods();
int run_accuracy(const AccuracyOptions& options);

// Run time against the drift of energy, for the same methods and a motion that conserves it.
struct EnergyDriftOptions {
  std::string path;                    // of the case
  std::vector<std::string> overrides;  // KEY=VALUE
  std::vector<std::string> methods;    // empty: all
  double budget = 60;                  // s of CPU time, of one run
  bool json = false;
  std::filesystem::path plot;  // SVG file; empty: none
};
int run_energy_drift(const EnergyDriftOptions& options);

// Linearly implicit steps (euler, newton = 1) of several lengths on case files: CPU time,
// crossings, stretch and gain of energy. Returns 1 if a run fails or surfaces cross.
struct PreviewOptions {
  std::vector<std::string> cases;
  std::vector<std::string> overrides;        // of the cases: KEY=VALUE
  std::vector<int> rates{30, 60, 120, 240};  // steps per second
  bool json = false;
};
int run_preview(const PreviewOptions& options);

// Time and memory of the first steps of a case against the size of its first body's image.
struct ScalingOptions {
  std::string path;                    // of the case
  std::vector<std::string> overrides;  // of the case: KEY=VALUE
  std::vector<int> sizes{65, 129, 257, 513, 1025};
  int steps = 5;
  bool json = false;
};
int run_scaling(const ScalingOptions& options);

// A grid of extreme cases, each of which must finish correctly or report clearly why not. The
// slices are in stability_grid.cpp, the checks in stability_cell.h.
struct StabilityOptions {
  std::vector<std::string> slices;  // empty: all
  bool quick = false;               // a small grid whose cells should all finish
  int every = 1;                    // n: only every n-th cell
  // Limit of CPU time for a run of 81 vertices, s. Empty: 45 times the measured median, or a minute
  // for the small grid.
  std::optional<double> limit;
  int jobs = 1;  // cells at a time
  bool json = false;
  std::filesystem::path csv, plot;  // empty: none
};
int run_stability(const StabilityOptions& options);

// The table behind time.accuracy: settings against errors on short scenes; or its verification on
// other scenes.
struct CalibrateOptions {
  bool verify = false;
  std::vector<std::string> scenes;              // empty: all of their kind
  std::vector<double> asked{1e-3, 3e-4, 1e-4};  // m; accuracies to verify
  double reference_tolerance = 1e-8;            // m
  double certainty = 1e-5;                      // m: references must agree within this to the end
  double budget = 60;                           // s of CPU time, of one run
  std::filesystem::path output;                 // the table; empty: none
  std::filesystem::path plot;                   // SVG file; empty: none
};
std::vector<std::string> calibration_scene_names();
int run_calibrate(const CalibrateOptions& options);

// The cost of features that a scene does not need: the ratio of CPU time with and without them,
// from pairs of alternating runs.
struct SkippingOptions {
  std::vector<std::string> pairs;  // empty: all
  int repeats = 9;                 // pairs of runs
  bool json = false;
};
std::vector<std::string> skipping_pair_names();
int run_skipping(const SkippingOptions& options);

// Rigid particles that pour onto a torus on a floor. Fails if any overlap or lie inside.
struct ParticlesOptions {
  std::vector<int> counts{1'000, 10'000};
  double seconds = 2;
  bool json = false;
};
int run_particles(const ParticlesOptions& options);

// Cost of runs whose time goes to contact: a sheet that drapes over a ball, by the size of its
// image, by threads and by stiffness, and drape_torus. Returns 1 if a run fails, if surfaces cross,
// or if the number of threads changes a trajectory.
struct ContactOptions {
  std::vector<int> sizes{33, 65, 129};
  std::vector<int> threads{1};
  std::vector<double> stiffnesses;  // of contact, Pa/m; a row of 33 x 33 vertices each
  std::optional<double> duration;   // s, of every row; default: 1, or 0.5 for more than 129 x 129
  bool torus = true;                // also cases/drape_torus.toml
  int looks = 20;                   // times at which surfaces are checked
  std::vector<std::string> overrides;  // of every row
  bool json = false;
  std::filesystem::path plots;  // folder of SVG files; empty: none
};
int run_contact(const ContactOptions& options);

// Cost of planning, listing and looking at a sweep, whose runs take no time. Returns 1 if a result
// is lost.
struct SweepsOptions {
  int runs = 10'000;
  bool json = false;
};
int run_sweeps(const SweepsOptions& options);

// Shells and cloth against closed forms and published figures, on cases/benchmarks/, and against
// CalculiX where it is installed. Returns 1 if a row is beyond its limit.
struct ShellsOptions {
  std::vector<std::string> cases;  // empty: all; "calculix": the comparison
  std::vector<std::string> only;   // texts in the names of checks; empty: all
  bool list = false;               // print the names of the checks, run none
  bool json = false;
  std::filesystem::path plots;  // folder of SVG files; empty: none
};
// Cases by name, and the names of checks that are no case.
std::vector<std::string> shell_case_names();
std::vector<std::string> shell_check_names();
int run_shells(const ShellsOptions& options);

}  // namespace weft::bench
