// `weft bench contact`: the cost of runs whose time goes to contact.
#include "bench/contact.h"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench/experiments.h"
#include "sim/case/case_reader.h"
#include "sim/case/case_text.h"
#include "sim/view/plot.h"

namespace weft::bench {

namespace {

// A run of the table. Costs are compared with `wanted`, but do not fail the experiment, because
// they depend on the machine.
struct ContactRow {
  std::string name;
  std::string path;
  std::vector<std::string> overrides;
  double wanted = 0;             // CPU s per simulated s; 0: nothing in particular
  double wanted_per_vertex = 0;  // microseconds per vertex and 1/60 s
  int n = 0;                     // image of n x n vertices
  int threads = 1;
  int steps_per_second = 0;  // of Bullet's soft body; 0: a run of Weft
};

// Duration (s) of the drape. Fine images are run over the first half second alone, in which the
// sheet wraps the ball.
double drape_duration(const ContactOptions& options, int n) {
  return options.duration.value_or(n > 129 ? 0.5 : 1.0);
}

double wanted_of_drape(int n) { return n == 33 ? 2.5 : n == 65 ? 12 : n == 129 ? 60 : 0; }

ContactRow drape_row(const ContactOptions& options, int n, int threads) {
  const std::string side = std::to_string(n);
  ContactRow row{.name = "drape " + side,
                 .path = WEFT_CASES_DIR "/benchmarks/drape.toml",
                 .overrides = {"body.sheet.shape.resolution=[" + side + "," + side + "]",
                               "time.duration=" + sim::number_text(drape_duration(options, n))},
                 .wanted = wanted_of_drape(n),
                 .wanted_per_vertex = 60,
                 .n = n,
                 .threads = threads};
  if (threads > 1) row.name += ", " + std::to_string(threads) + " threads";
  return row;
}

// The iterations per step of Bullet's soft body.
constexpr int soft_body_iterations = 10;

// Adds Bullet's soft body on the first of the sheets, if it was built.
void add_peers(const ContactOptions& options, std::vector<ContactRow>& rows) {
  if (!ball_program()) {
    std::fprintf(stderr, "Bullet's soft body does not take part: it was not found\n");
    return;
  }
  for (const int steps_per_second : {60, 240}) {
    ContactRow& row = rows.emplace_back(drape_row(options, options.sizes.front(), 1));
    row.name = "Bullet " + std::to_string(row.n) + ", 1/" + std::to_string(steps_per_second) + " s";
    row.wanted = row.wanted_per_vertex = 0;
    row.steps_per_second = steps_per_second;
  }
}

ContactRun run_of(const ContactRow& row, int looks) {
  const sim::Case source = sim::read_case(row.path, row.overrides);
  if (row.steps_per_second == 0) return measure_contact(source, looks);
  return measure_soft_body(ball_program().value(), source, row.steps_per_second,
                           soft_body_iterations);
}

std::vector<ContactRow> rows_of(const ContactOptions& options) {
  std::vector<ContactRow> rows;
  for (const int n : options.sizes)
    for (const int threads : options.threads) rows.push_back(drape_row(options, n, threads));
  for (const double stiffness : options.stiffnesses) {
    ContactRow& row = rows.emplace_back(drape_row(options, 33, 1));
    row.name += ", " + sim::number_text(stiffness);
    row.overrides.push_back("contact.stiffness=" + sim::number_text(stiffness));
    row.wanted = row.wanted_per_vertex = 0;
  }
  if (options.torus) {
    ContactRow& row = rows.emplace_back();
    row.name = "drape_torus";
    row.path = WEFT_CASES_DIR "/drape_torus.toml";
    row.n = 65;
    row.wanted = 10;
    if (options.duration)
      row.overrides.push_back("time.duration=" + sim::number_text(*options.duration));
  }
  add_peers(options, rows);
  for (ContactRow& row : rows) {
    row.overrides.push_back("compute.threads=" + std::to_string(row.threads));
    row.overrides.insert(row.overrides.end(), options.overrides.begin(), options.overrides.end());
  }
  return rows;
}

nlohmann::ordered_json json_of(const ContactRow& row, const ContactRun& run) {
  const double steps = std::max(1.0, run.steps), evaluations = std::max(1.0, run.evaluations);
  nlohmann::ordered_json json{{"row", row.name},
                              {"n", row.n},
                              {"threads", row.threads},
                              {"vertices", run.vertices},
                              {"simulated_s", run.simulated},
                              {"cpu_s_per_s", run.cpu_per_second()},
                              {"wall_s_per_s", run.wall / run.simulated},
                              {"wanted_cpu_s_per_s", row.wanted},
                              {"us_per_vertex_and_60th", run.per_vertex()},
                              {"wanted_us", row.wanted_per_vertex},
                              {"detection_share", run.detection / run.wall},
                              {"linear_solve_share", run.linear_solve / run.wall},
                              {"steps", run.steps},
                              {"vetoed_steps", run.vetoed},
                              {"evaluations", run.evaluations},
                              {"pairs_measured_per_evaluation", run.pairs_measured / evaluations},
                              {"pairs_in_contact", run.pairs_in_contact},
                              {"linear_iterations_per_solve", run.iterations_per_solve()},
                              {"sparse_factorisations", run.factorisations},
                              {"mean_step_s", run.simulated / steps},
                              {"largest_strain", run.largest_strain},
                              {"crossings", run.crossings},
                              {"trajectory", std::to_string(run.trajectory)}};
  if (!run.failure.empty()) json["failure"] = run.failure;
  return json;
}

void print_contact_heading() {
  std::printf(
      "CPU s of one process per simulated s. us: per vertex and 1/60 s. Shares of wall time: "
      "search\n"
      "and narrow phase, linear solve. Pairs measured per evaluation of the forces, and pairs in\n"
      "contact (mean over the steps). fact: sparse factorisations. Crossings: exact, all looks\n"
      "together.\n\n"
      "%-22s %6s %9s %8s %7s %7s %7s %7s %8s %8s %8s %7s %5s %7s %6s\n",
      "scene", "s", "CPU s/s", "to reach", "us", "search", "solve", "steps", "evals", "measured",
      "contact", "it/sol", "fact", "strain", "cross");
}

void print_contact_row(const ContactRow& row, const ContactRun& run) {
  char wanted[32] = "-";
  if (row.wanted > 0) std::snprintf(wanted, sizeof wanted, "%.3g", row.wanted);
  std::printf(
      "%-22s %6.3g %9.3g %8s %7.4g %6.1f%% %6.1f%% %7.0f %8.0f %8.0f %8.0f %7.1f %5.0f %6.1f%% "
      "%6d\n",
      row.name.c_str(), run.simulated, run.cpu_per_second(), wanted, run.per_vertex(),
      100 * run.detection / run.wall, 100 * run.linear_solve / run.wall, run.steps, run.evaluations,
      run.pairs_measured / std::max(1.0, run.evaluations), run.pairs_in_contact,
      run.iterations_per_solve(), run.factorisations, 100 * run.largest_strain, run.crossings);
  if (!run.failure.empty()) std::printf("  failed: %s\n", run.failure.c_str());
  std::fflush(stdout);
}

struct Finished {
  ContactRow row;
  ContactRun run;
};

// Prints the speed-up of the rows with several threads over those with one, and returns false if
// their trajectories differ.
bool compare_threads(const std::vector<Finished>& all, bool print) {
  bool same = true;
  for (const Finished& many : all) {
    if (many.row.threads == 1) continue;
    for (const Finished& one : all) {
      if (one.row.threads != 1 || one.row.name != "drape " + std::to_string(many.row.n)) continue;
      const bool equal = one.run.trajectory == many.run.trajectory;
      same = same && equal;
      if (print) {
        std::printf("%s: %.2f times as fast as one (wall time), %s\n", many.row.name.c_str(),
                    one.run.wall / many.run.wall, equal ? "same bits" : "OTHER BITS");
      }
    }
  }
  return same;
}

// Two charts: cost of a vertex against the size of the image, and cost of an evaluation against the
// pairs in contact.
void write_growth(const std::vector<Finished>& all, const std::filesystem::path& folder) {
  sim::Plot sizes{"Cost of a vertex in a drape",
                  "one thread",
                  {"vertices along a side", true},
                  {"CPU us per vertex and 1/60 s", true},
                  {}};
  sim::Plot contacts{"Search and narrow phase against contacts",
                     "one thread, every look of a run",
                     {"pairs in contact", true},
                     {"us per evaluation of the forces", true},
                     {}};
  sim::PlotSeries series{"drape", {}, {}};
  for (const auto& [row, run] : all) {
    if (row.threads > 1 || row.steps_per_second > 0 || !run.failure.empty()) continue;
    if (row.wanted_per_vertex > 0) {
      series.x.push_back(row.n);
      series.y.push_back(run.per_vertex());
    }
    sim::PlotSeries moments{row.name, {}, {}};
    moments.line = false;
    for (const ContactMoment& moment : run.moments) {
      if (!(moment.pairs_in_contact > 0)) continue;
      moments.x.push_back(moment.pairs_in_contact);
      moments.y.push_back(moment.microseconds);
    }
    if (!moments.x.empty()) contacts.series.push_back(std::move(moments));
  }
  if (!series.x.empty()) {
    sizes.series.push_back(std::move(series));
    sim::write_svg(sizes, folder / "contact_growth.svg");
  }
  if (!contacts.series.empty()) sim::write_svg(contacts, folder / "contact_pairs.svg");
}

}  // namespace

int run_contact(const ContactOptions& options) {
  if (!options.json) print_contact_heading();
  nlohmann::ordered_json json;
  json["rows"] = nlohmann::json::array();
  std::vector<Finished> all;
  bool is_right = true;
  for (const ContactRow& row : rows_of(options)) {
    const ContactRun& run = all.emplace_back(row, run_of(row, options.looks)).run;
    const bool is_peer = row.steps_per_second > 0;
    is_right = is_right && (is_peer || (run.failure.empty() && run.crossings == 0));
    if (options.json) {
      json["rows"].push_back(json_of(row, run));
    } else {
      print_contact_row(row, run);
    }
  }
  if (options.json) std::printf("%s\n", json.dump(2).c_str());
  is_right = compare_threads(all, !options.json) && is_right;
  if (!options.plots.empty()) write_growth(all, options.plots);
  if (!is_right) std::fprintf(stderr, "a run failed, surfaces crossed, or bits differ\n");
  return is_right ? 0 : 1;
}

}  // namespace weft::bench
