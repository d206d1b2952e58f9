#include "sim/sweep/to_do_list.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string_view>

#include "sim/base/file_error.h"
#include "sim/sweep/run_folder.h"
#include "sim/sweep/whole_file.h"

namespace weft::sim {

namespace {

using Json = nlohmann::ordered_json;

// Number of the layout of the file. Another number is refused.
constexpr int to_do_format = 1;

// Returns the entry of a run that is to be computed, or nothing.
std::optional<RunToDo> entry_of(const RunFolder& folder, std::size_t index, bool rerun_failed) {
  const std::optional<RunResult> result = folder.result();
  if (!result) return RunToDo{index};
  if (!rerun_failed || result->is_done()) return std::nullopt;
  return RunToDo{index, folder.result_mark()};
}

}  // namespace

std::vector<RunToDo> runs_to_do(const std::filesystem::path& directory, const SweepPlan& plan,
                                bool rerun_failed) {
  struct Ranked {
    RunToDo run;
    bool is_interrupted;
  };
  std::vector<Ranked> found;
  std::set<std::string_view> seen;
  for (std::size_t i = 0; i < plan.runs.size(); ++i) {
    const PlannedRun& run = plan.runs[i];
    if (!run.refusal.empty() || !seen.insert(run.hash).second) continue;
    const RunFolder folder(directory, run.hash);
    auto entry = entry_of(folder, i, rerun_failed);
    if (!entry) continue;
    const bool has_result = !entry->failed_result.empty();
    const bool is_interrupted = !has_result && folder.state_without_result() != RunState::not_begun;
    found.push_back({std::move(*entry), is_interrupted});
  }
  std::ranges::stable_sort(found, [&](const Ranked& a, const Ranked& b) {
    if (a.is_interrupted != b.is_interrupted) return a.is_interrupted;
    return plan.runs[a.run.index].work > plan.runs[b.run.index].work;
  });
  std::vector<RunToDo> list;
  for (Ranked& each : found) list.push_back(std::move(each.run));
  return list;
}

std::filesystem::path to_do_path(const std::filesystem::path& directory) {
  return directory / "to_do.json";
}

void write_to_do_list(const std::filesystem::path& path, const SweepPlan& plan,
                      const std::vector<RunToDo>& list) {
  std::string text = "{\"to_do_format\": " + std::to_string(to_do_format) + ", \"runs\": [";
  const char* separator = "\n";
  for (const RunToDo& each : list) {
    Json entry{{"hash", plan.runs[each.index].hash}};
    if (!each.failed_result.empty()) entry["failed_result"] = each.failed_result;
    text += separator + entry.dump();
    separator = ",\n";
  }
  write_whole_file(path, text + "\n]}\n");
}

std::vector<RunToDo> read_to_do_list(const std::filesystem::path& path, const SweepPlan& plan) {
  const std::optional<std::string> text = read_whole_file(path);
  if (!text) throw FileError(path.string() + ": there is no such file; weft sweep plan makes it");
  std::map<std::string_view, std::size_t> indices;
  for (std::size_t i = 0; i < plan.runs.size(); ++i) indices.emplace(plan.runs[i].hash, i);
  try {
    const Json json = Json::parse(*text);
    if (json.at("to_do_format") != to_do_format)
      throw FileError(path.string() +
                      ": is a list of another version of Weft; plan the sweep anew");
    std::vector<RunToDo> list;
    for (const Json& each : json.at("runs")) {
      const auto hash = each.at("hash").get<std::string>();
      const auto found = indices.find(hash);
      if (found == indices.end()) {
        throw FileError(path.string() + ": has the run " + hash.substr(0, 16) +
                        ", which plan.json lacks: another sweep was planned into this folder; "
                        "plan or submit this one again");
      }
      list.push_back({found->second, each.value("failed_result", "")});
    }
    return list;
  } catch (const Json::exception& error) {
    throw FileError(path.string() + ": is damaged: " + error.what());
  }
}

Slice slice_of(const std::vector<RunToDo>& list, std::size_t number, std::size_t count) {
  Slice slice;
  for (std::size_t i = 0; i < list.size(); ++i)
    (i % count == number ? slice.own : slice.others).push_back(list[i]);
  return slice;
}

}  // namespace weft::sim
