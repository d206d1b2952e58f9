#include "sim/command/command_json.h"

#include "sim/base/process_memory.h"
#include "sim/trajectory/json_text.h"

namespace weft::sim {

namespace {

using Json = nlohmann::ordered_json;

Json error_json(const ErrorEstimate& estimate) {
  Json json;
  for (const BodyError& body : estimate.bodies) {
    json["bodies"].push_back({{"body", body.body},
                              {"largest_m", body.largest},
                              {"largest_time_s", body.largest_time},
                              {"last_m", body.last}});
  }
  json["last_time_s"] = estimate.last_time;
  json["parted_time_s"] = estimate.parted_time ? Json(*estimate.parted_time) : nullptr;
  if (!estimate.failure.empty()) json["failure"] = estimate.failure;
  return json;
}

void add_cost(Json& json, const std::string& part, const Cost& cost) {
  json[part + "wall_s"] = cost.wall;
  json[part + "cpu_s"] = cost.cpu;
}

// Adds the costs of the bill. The cost of the error estimate is left out, because report_json()
// puts it into the object of the error estimate.
void add_bill(Json& json, const Bill& bill) {
  for (const BillPart& part : bill_parts) {
    if (part.cost != &Bill::error_estimate) add_cost(json, part.prefix, bill.*part.cost);
  }
}

// Returns an object with the members that all objects of this file have.
Json ending_json(int code, const std::string& status, const std::string& reason) {
  Json json{{"weft_version", WEFT_VERSION}, {"status", status}, {"exit_code", code}};
  json["reason"] = reason.empty() ? Json() : Json(reason);
  json["reason_kind"] = Json();
  return json;
}

const char* refusal_status(int code) { return code == exit_code::bad_case ? "refused" : "failed"; }

void add_command(Json& json, const RunCommand& command) {
  json["case"] = command.case_path;
  json["overrides"] = command.overrides;
}

Json counters_json(const Counters& counters) {
  return {{"body_pairs", counters.body_pairs},
          {"rebuilds", counters.rebuilds},
          {"self_traversals", counters.self_traversals},
          {"pair_traversals", counters.pair_traversals},
          {"bound_tests", counters.bound_tests},
          {"candidate_pairs", counters.candidate_pairs},
          {"narrow_phase_calls", counters.narrow_phase_calls},
          {"ccd_calls", counters.ccd_calls},
          {"friction_terms", counters.friction_terms},
          {"force_evaluations", counters.force_evaluations},
          {"matrix_assemblies", counters.matrix_assemblies},
          {"sparse_factorisations", counters.sparse_factorisations}};
}

// Returns the non-empty classes of step lengths.
Json lengths_json(const StepCensus& census) {
  Json classes = Json::array();
  const auto& ends = StepCensus::ends;
  for (std::size_t i = 0; i < census.by_length.size(); ++i) {
    if (census.by_length[i] == 0) continue;
    classes.push_back({{"from_s", i == 0 ? 0.0 : ends[i - 1]},
                       {"to_s", i == ends.size() ? Json() : Json(ends[i])},
                       {"steps", census.by_length[i]}});
  }
  return classes;
}

Json limits_json(const StepCensus& census) {
  Json limits = Json::object();
  for (std::size_t i = 0; i < census.by_limit.size(); ++i)
    limits[step_limit_names[i]] = census.by_limit[i];
  return limits;
}

Json phases_json(const PhaseTimes& phases) {
  return {{"wall_rebuild", phases.rebuild},
          {"wall_traverse", phases.traverse},
          {"wall_narrow_phase", phases.narrow_phase},
          {"wall_forces", phases.forces},
          {"wall_linear_solve", phases.linear_solve},
          {"wall_energies", phases.energies},
          {"wall_record", phases.record}};
}

void add_counts(Json& json, const IntegratorCounts& counts) {
  json["steps"] = counts.steps;
  json["vetoed_steps"] = counts.vetoed_steps;
  json["error_test_failures"] = counts.error_test_failures;
  json["convergence_failures"] = counts.convergence_failures;
  json["newton_iterations"] = counts.newton_iterations;
  json["linear_iterations"] = counts.linear_iterations;
  json["linear_setups"] = counts.linear_setups;
  json["restarts"] = counts.restarts;
  json["step_lengths"] = lengths_json(counts.census);
  json["step_limits"] = limits_json(counts.census);
}

// Returns the report of `weft modes` or `weft buckling` with an empty list of modes.
Json modes_head(const RunCommand& command, const ModesReport& report, int unknowns, int code) {
  Json json = ending_json(code, report.failure ? "failed" : "done",
                          report.failure ? report.failure->text : "");
  if (report.failure) json["reason_kind"] = kind_name(report.failure->kind);
  add_command(json, command);
  json["title"] = report.title;
  json["warnings"] = report.warnings;
  json["about"] = report.about;
  json["time_s"] = report.time;
  json["load_factor"] = report.load_factor;
  json["imbalance"] = report.imbalance;
  json["unknowns"] = unknowns;
  add_cost(json, "", report.cost);
  json["trajectory"] = report.trajectory.empty() ? Json() : Json(report.trajectory);
  json["modes"] = Json::array();
  return json;
}

}  // namespace

std::string report_json(const RunCommand& command, const Case& source, const RunReport& report,
                        const std::vector<std::string>& warnings, int code) {
  Json json = ending_json(code, status_name(report.status), report.reason);
  if (report.failure) json["reason_kind"] = kind_name(report.failure->kind);
  add_command(json, command);
  json["title"] = source.title;
  json["warnings"] = warnings;
  json["simulated_s"] = report.simulated_time;
  json["resumed_at_s"] = report.resumed_at ? Json(*report.resumed_at) : Json();
  add_bill(json, report.bill);
  json["peak_memory_mib"] = peak_resident_memory();
  json["frames"] = report.frames;
  add_counts(json, report.counts);
  json["smallest_gap"] = report.smallest_gap ? Json(*report.smallest_gap) : Json();
  json["largest_stretch"] = report.largest_stretch;
  json["energies"] = Json::object();
  for (const auto& [name, value] : report.energies) json["energies"][name] = value;
  json["outputs"] = Json::object();
  for (const auto& [name, value] : report.outputs) json["outputs"][name] = value;
  if (!report.compute.empty()) json["compute"] = report.compute;
  if (!report.decision.empty()) json["integrator"] = report.decision;
  json["counters"] = counters_json(report.statistics.counters);
  json["phases_s"] = phases_json(report.statistics.phases);
  if (!source.accuracy_choice.empty()) json["accuracy"] = source.accuracy_choice;
  if (report.error_estimate) {
    json["error_estimate"] = error_json(*report.error_estimate);
    add_cost(json["error_estimate"], "", report.bill.error_estimate);
  }
  json["trajectory"] = report.trajectory.empty() ? Json() : Json(report.trajectory);
  return json_text(json);
}

std::string modes_json(const RunCommand& command, const ModesReport& report,
                       const VibrationModes& found, int code) {
  Json json = modes_head(command, report, found.unknowns, code);
  for (const VibrationMode& mode : found.modes) {
    json["modes"].push_back({{"kind", kind_name(mode.kind)},
                             {"frequency_hz", mode.frequency()},
                             {"angular_frequency_rad_per_s", mode.angular_frequency()},
                             {"growth_rate_per_s", mode.growth_rate()},
                             {"eigenvalue_per_s2", mode.eigenvalue},
                             {"modal_mass_kg", mode.modal_mass},
                             {"error", mode.error}});
  }
  return json_text(json);
}

std::string modes_json(const RunCommand& command, const ModesReport& report,
                       const BucklingModes& found, int code) {
  Json json = modes_head(command, report, found.unknowns, code);
  for (const BucklingMode& mode : found.modes)
    json["modes"].push_back({{"load_factor", mode.load_factor}, {"error", mode.error}});
  return json_text(json);
}

std::string refusal_json(const RunCommand& command, const std::optional<std::string>& title,
                         int code, const std::string& reason) {
  Json json = ending_json(code, refusal_status(code), reason);
  add_command(json, command);
  if (title) json["title"] = *title;
  return json_text(json);
}

std::string refusal_json(int code, const std::string& reason) {
  return json_text(ending_json(code, refusal_status(code), reason));
}

}  // namespace weft::sim
