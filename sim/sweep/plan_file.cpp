#include "sim/sweep/plan_file.h"

#include <nlohmann/json.hpp>

#include "sim/base/file_error.h"
#include "sim/base/output_folder.h"
#include "sim/run/numerics_version.h"
#include "sim/sweep/whole_file.h"

namespace weft::sim {

namespace {

using Json = nlohmann::ordered_json;

// Number of the layout of the file. Another number is refused.
constexpr int plan_format = 3;

// Texts may hold bytes that are not UTF-8, such as paths; JSON cannot.
std::string dump(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::filesystem::path plan_path(const std::filesystem::path& directory) {
  return directory / "plan.json";
}

Json limits_json(const LimitsCase& limits) {
  return {{"time_s", limits.time ? Json(*limits.time) : Json()},
          {"memory_mib", limits.memory ? Json(*limits.memory) : Json()}};
}

Json outputs_json(const std::vector<OutputExpression>& outputs) {
  Json json = Json::array();
  for (const OutputExpression& output : outputs) json.push_back({output.name, output.text.text});
  return json;
}

// Returns the outputs of a plan. Their place is that of the plan.
std::vector<OutputExpression> outputs_of(const Json& json, const std::filesystem::path& plan) {
  std::vector<OutputExpression> outputs;
  for (const Json& each : json) {
    const auto name = each.at(0).get<std::string>();
    outputs.push_back(
        {name, {each.at(1).get<std::string>(), {plan.string() + ": output " + name}}});
  }
  return outputs;
}

std::optional<double> optional_number(const Json& json) {
  return json.is_null() ? std::nullopt : std::optional(json.get<double>());
}

}  // namespace

void write_plan(const std::filesystem::path& directory, const SweepPlan& plan) {
  std::string text = "{\"plan_format\": " + std::to_string(plan_format) +
                     ", \"weft_version\": " + dump(WEFT_VERSION) +
                     ", \"numerics\": " + std::to_string(numerics_version) +
                     ",\n\"sweep\": " + dump(plan.sweep) + ",\n\"factors\": " + dump(plan.factors) +
                     ",\n\"limits\": " + dump(limits_json(plan.limits)) +
                     ",\n\"estimate_error\": " + (plan.estimate_error ? "true" : "false") +
                     ",\n\"case_outputs\": " + dump(outputs_json(plan.case_outputs)) +
                     ",\n\"sweep_outputs\": " + dump(outputs_json(plan.sweep_outputs)) +
                     ",\n\"files\": " + dump(plan.digests) +
                     ",\n\"left_out\": " + std::to_string(plan.left_out) + ",\n\"runs\": [";
  const char* separator = "\n";
  for (const PlannedRun& run : plan.runs) {
    Json json{{"hash", run.hash}, {"values", run.values}};
    if (run.refusal.empty()) {
      json["case"] = run.case_text;
      json["work"] = run.work;
      if (!run.inputs.empty()) json["files"] = run.inputs;
    } else {
      json["refusal"] = run.refusal;
    }
    text += separator + dump(json);
    separator = ",\n";
  }
  const std::filesystem::path path = plan_path(directory);
  in_output_folder(path.string());
  write_whole_file(path, text + "\n]}\n");
}

SweepPlan read_plan(const std::filesystem::path& directory) {
  const std::filesystem::path path = plan_path(directory);
  const std::optional<std::string> text = read_whole_file(path);
  if (!text) throw FileError(path.string() + ": there is no such file; weft sweep makes it");
  try {
    const Json json = Json::parse(*text);
    if (json.at("plan_format") != plan_format)
      throw FileError(path.string() +
                      ": is a plan of another version of Weft; plan the sweep anew");
    SweepPlan plan;
    json.at("sweep").get_to(plan.sweep);
    json.at("factors").get_to(plan.factors);
    plan.limits = {optional_number(json.at("limits").at("time_s")),
                   optional_number(json.at("limits").at("memory_mib"))};
    json.at("estimate_error").get_to(plan.estimate_error);
    plan.case_outputs = outputs_of(json.at("case_outputs"), path);
    plan.sweep_outputs = outputs_of(json.at("sweep_outputs"), path);
    json.at("files").get_to(plan.digests);
    json.at("left_out").get_to(plan.left_out);
    for (const Json& each : json.at("runs")) {
      PlannedRun& run = plan.runs.emplace_back();
      each.at("hash").get_to(run.hash);
      each.at("values").get_to(run.values);
      run.refusal = each.value("refusal", "");
      run.case_text = each.value("case", "");
      run.work = each.value("work", 0.0);
      run.inputs = each.value("files", std::vector<std::string>());
    }
    return plan;
  } catch (const Json::exception& error) {
    throw FileError(path.string() + ": is damaged: " + error.what());
  }
}

}  // namespace weft::sim
