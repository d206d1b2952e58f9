// The linear system of one implicit step of a sheet, preconditioned by block-Jacobi and by
// multigrid: iterations and times against the size and the step.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <utility>

#include "bench/experiments.h"
#include "bench/medians.h"
#include "bench/run_apart.h"
#include "bench/run_cost.h"
#include "sim/case/case_reader.h"
#include "sim/solver/velocity_system.h"

namespace weft::bench {

namespace {

using namespace sim;

constexpr const char* sheet = R"(
[contact]
enabled = false
[material.cloth]
density = 0.2
membrane_stiffness = 1000
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [2, 2] }
[[body.pin]]
corners = ["last_first", "last_last"]
)";

// A quarter of a cylinder, clamped at one end.
constexpr const char* shell = R"(
[contact]
enabled = false
[material.steel]
model = "shell"
youngs_modulus = 2.1e11
poisson_ratio = 0.3
shell_thickness = 1e-3
volume_density = 7850
[[body]]
name = "shell"
shape = { type = "cylinder", radius = 0.5, length = 1.0, angle_deg = 90, resolution = [4, 4] }
[[body.pin]]
edges = ["first_row"]
clamp = true
)";

std::unique_ptr<const Scene> scene_of(int n, int threads, const std::string& preconditioner,
                                      const LinearSolverOptions& options) {
  const bool is_shell = options.shell_thickness > 0;
  Case source = parse_case(is_shell ? shell : sheet, "scene.toml",
                           {"time.preconditioner=\"" + preconditioner + "\""});
  source.compute.threads = threads;
  if (is_shell) {
    source.material[0].shell_thickness = options.shell_thickness;
  } else {
    source.material[0].bending_stiffness = options.bending_stiffness;
  }
  source.body[0].shape.resolution = {n, n};
  return build_scene(source);
}

// A sheet that bulges by a tenth of its size, which stretches it everywhere, or a shell that bulges
// by its thickness, with the right-hand side of the first Newton iteration of a step from there. A
// bulged shell is compressed in places, where its exact matrix is indefinite. Its matrix is
// therefore the semi-definite one that integrators use (docs/decisions/0006).
struct Problem {
  Problem(int n, int threads, const std::string& preconditioner, const LinearSolverOptions& options)
      : scene(scene_of(n, threads, preconditioner, options)),
        dynamics(*scene, statistics),
        system(dynamics) {
    std::vector<double> state = dynamics.initial_state();
    auto* x = reinterpret_cast<Vec3*>(state.data());
    const double size = options.shell_thickness > 0 ? 10 * options.shell_thickness : 1;
    constexpr double pi = std::numbers::pi;
    for (int i = 0; i < dynamics.particle_count(); ++i) {
      if (scene->pinned[i] != 0) continue;
      x[i].z() += size * std::cos(pi * x[i].x()) * std::cos(pi * x[i].y()) *
                  (0.1 + 0.002 * std::sin(17 * x[i].x() + 7 * x[i].y()));
    }
    rate.resize(state.size());
    static_cast<void>(dynamics.rate(0, state, rate));
    dynamics.assemble(
        0, state, options.shell_thickness > 0 ? Definiteness::semi_definite : Definiteness::exact);
    weight.assign(rate.size(), 1.0);
    correction.resize(rate.size());
  }

  VelocitySystem::Outcome solve(double gamma, double relative) {
    std::vector<double> b(rate.size(), 0.0);
    double square = 0;
    for (std::size_t i = b.size() / 2; i < b.size(); ++i) {
      b[i] = gamma * rate[i];
      square += b[i] * b[i];
    }
    return system.solve(gamma, b, weight, {.residual = relative * std::sqrt(square)}, correction);
  }

  std::unique_ptr<const Scene> scene;
  Statistics statistics;
  Dynamics dynamics;
  VelocitySystem system;
  std::vector<double> rate, weight, correction;
};

struct Row {
  int n = 0;
  double gamma = 0, gamma_frequency = 0;
  int threads = 1;
  const char* method = "";
  bool converged = false;
  int iterations = 0;
  double first_ms = 0, set_up_ms = 0, solve_ms = 0;
  double bytes_per_vertex = 0;  // of scene, matrices and solver, beyond those of the program
};

// Returns the peak memory of a process that prepares the solution of the system of the longest
// gamma: no iteration follows, since any residual is accepted. Uses one thread.
double peak_bytes(int n, const std::string& preconditioner, const LinearSolverOptions& options) {
  const auto work = [&] {
    Problem problem(n, 1, preconditioner, options);
    problem.solve(*std::max_element(options.gammas.begin(), options.gammas.end()),
                  std::numeric_limits<double>::infinity());
    return std::string();
  };
  return run_apart(work).peak_bytes;
}

double bytes_per_vertex(int n, const std::string& preconditioner,
                        const LinearSolverOptions& options) {
  return (peak_bytes(n, preconditioner, options) -
          peak_bytes(tiny_image, preconditioner, options)) /
         (n * n);
}

class Measurement {
 public:
  // Measures memory before any other work, as long as this process has one thread: a child process
  // does not have the other threads of its parent.
  explicit Measurement(const LinearSolverOptions& options) : options_(options) {
    for (const int n : options.sizes) {
      for (const char* preconditioner : {"block_jacobi", "multigrid"})
        bytes_[{n, preconditioner}] = bytes_per_vertex(n, preconditioner, options);
    }
  }

  void run(int n, int threads) {
    Problem jacobi(n, threads, "block_jacobi", options_);
    Problem multigrid(n, threads, "multigrid", options_);
    for (double gamma : options_.gammas) {
      Row first{n, gamma, gamma * jacobi.system.highest_frequency(), threads};
      Row second = first;
      first.method = "block-jacobi";
      second.method = "multigrid";
      first.bytes_per_vertex = bytes_.at({n, "block_jacobi"});
      second.bytes_per_vertex = bytes_.at({n, "multigrid"});
      std::vector<double> solves[2], set_ups[2], images;
      for (int i = 0; i < options_.repeats; ++i) {
        measure(jacobi, gamma, first, solves[0], set_ups[0], nullptr);
        measure(multigrid, gamma, second, solves[1], set_ups[1], &images);
      }
      first.solve_ms = median(solves[0]);
      first.set_up_ms = median(set_ups[0]);
      second.solve_ms = median(solves[1]);
      second.set_up_ms = median(set_ups[1]);
      second.first_ms = median(images);
      for (const Row& row : {first, second}) {
        rows_.push_back(row);
        if (!options_.json) print(row);
      }
    }
  }
  const std::vector<Row>& rows() const { return rows_; }

 private:
  // Measures one thread by its CPU time, which other load on the machine does not lengthen, and
  // several threads by wall time. Returns ms.
  template <class Work>
  double ms(int threads, const Work& work) const {
    return 1e3 * (threads == 1 ? thread_time_of(work) : wall_time_of(work));
  }

  // Appends times to the lists; `images` is given for a multigrid, whose images and patterns are
  // found once per scene.
  void measure(Problem& problem, double gamma, Row& row, std::vector<double>& solves,
               std::vector<double>& set_ups, std::vector<double>* images) const {
    VelocityMatrix matrix(problem.dynamics);
    std::unique_ptr<Multigrid> multigrid;
    if (images != nullptr) {
      images->push_back(ms(row.threads, [&] {
        multigrid = std::make_unique<Multigrid>(*problem.scene, matrix.pattern());
      }));
      matrix.form(gamma);
      static_cast<void>(multigrid->set_up(matrix));
    }
    set_ups.push_back(ms(row.threads, [&] {
      matrix.form(gamma);
      if (multigrid) static_cast<void>(multigrid->set_up(matrix));
    }));
    problem.system.set_up(gamma);
    problem.solve(gamma, options_.tolerance);  // forms the coarse matrices
    VelocitySystem::Outcome outcome;
    solves.push_back(ms(row.threads, [&] { outcome = problem.solve(gamma, options_.tolerance); }));
    row.iterations = outcome.iterations;
    row.converged = outcome.converged && outcome.multigrid == (images != nullptr);
  }

  static void print(const Row& row) {
    std::printf("%6d %9.2g %9.1f %8d  %-13s %9.1f %9.2f %9.2f %9.2f %10d %9.2f%s\n", row.n,
                row.gamma, row.gamma_frequency, row.threads, row.method, row.first_ms,
                row.set_up_ms, row.solve_ms, row.set_up_ms + row.solve_ms, row.iterations,
                row.bytes_per_vertex / 1e3, row.converged ? "" : " not converged");
    std::fflush(stdout);
  }

  const LinearSolverOptions& options_;
  std::map<std::pair<int, std::string>, double> bytes_;  // per vertex, by size and preconditioner
  std::vector<Row> rows_;
};

}  // namespace

int run_linear_solver(const LinearSolverOptions& options) {
  if (!options.json) {
    std::printf(
        "a bulged %s of n x n vertices, relative residual %g, bending stiffness %g N m; "
        "medians of %d interleaved repeats\n%6s %9s %9s %8s  %-13s %9s %9s %9s %9s %10s %9s\n",
        options.shell_thickness > 0 ? "shell" : "sheet", options.tolerance,
        options.bending_stiffness, options.repeats, "n", "gamma", "g*omega", "threads", "method",
        "once ms", "set-up ms", "solve ms", "sum ms", "iterations", "kB/vertex");
  }
  Measurement measurement(options);
  for (int n : options.sizes) {
    for (int threads : options.threads) measurement.run(n, threads);
  }
  nlohmann::ordered_json json;
  bool multigrid_converged = true;
  for (const Row& row : measurement.rows()) {
    multigrid_converged =
        multigrid_converged && (row.converged || std::string(row.method) != "multigrid");
    json["rows"].push_back({{"n", row.n},
                            {"gamma_s", row.gamma},
                            {"gamma_frequency", row.gamma_frequency},
                            {"threads", row.threads},
                            {"method", row.method},
                            {"once_ms", row.first_ms},
                            {"set_up_ms", row.set_up_ms},
                            {"solve_ms", row.solve_ms},
                            {"iterations", row.iterations},
                            {"bytes_per_vertex", row.bytes_per_vertex},
                            {"converged", row.converged}});
  }
  if (options.json) std::printf("%s\n", json.dump(2).c_str());
  if (!multigrid_converged) std::fprintf(stderr, "multigrid did not converge\n");
  return multigrid_converged ? 0 : 1;
}

}  // namespace weft::bench
