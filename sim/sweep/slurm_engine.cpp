#include "sim/sweep/slurm_engine.h"

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <thread>

#include "sim/base/file_error.h"
#include "sim/case/case_error.h"
#include "sim/sweep/child_process.h"
#include "sim/sweep/whole_file.h"

namespace weft::sim {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Time (s) before the end of a job at which Slurm sends SIGUSR1, or up to a minute earlier.
constexpr int notice_time = 90;
// Slurm's default of MaxArraySize, taken where scontrol does not tell.
constexpr int usual_array_size = 1001;

struct ToolEnd {
  int code = 0;
  std::string output, errors;
};

// Runs a program of Slurm, found by PATH, with its output in files of `folder`.
ToolEnd run_tool(const fs::path& folder, const std::vector<std::string>& words) {
  ChildProcess::Command command;
  command.words = {"/usr/bin/env"};
  command.words.insert(command.words.end(), words.begin(), words.end());
  command.output = folder / (words[0] + ".out");
  command.errors = folder / (words[0] + ".err");
  ChildProcess process(command);
  std::optional<ChildEnd> end;
  while (!(end = process.poll())) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  ToolEnd result{end->signal != 0 ? 128 + end->signal : end->exit_code,
                 read_whole_file(command.output).value_or(""),
                 read_whole_file(command.errors).value_or("")};
  std::error_code ignored;
  fs::remove(command.output, ignored);
  fs::remove(command.errors, ignored);
  return result;
}

// Returns the largest number of tasks that an array may have.
int largest_array(const fs::path& folder) {
  const ToolEnd config = run_tool(folder, {"scontrol", "show", "config"});
  std::istringstream lines(config.output);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string key, sign;
    int size = 0;
    if (words >> key >> sign >> size && key == "MaxArraySize") return size;
  }
  return usual_array_size;
}

}  // namespace

void refuse_live_job(const fs::path& directory) {
  const fs::path folder = fs::absolute(directory) / "slurm";
  const std::optional<std::string> text = read_whole_file(folder / "job.json");
  if (!text) return;
  const Json json = Json::parse(*text, nullptr, false);
  if (!json.is_object() || !json.contains("job") || !json["job"].is_string()) return;
  const std::string job = json["job"];
  const ToolEnd queue = run_tool(folder, {"squeue", "--noheader", "--jobs=" + job});
  // squeue refuses the number of a job that ended some time ago.
  if (queue.code != 0 || queue.output.find_first_not_of(" \n") == std::string::npos) return;
  throw CaseError({folder.string()}, "job " + job + " of this sweep has not ended",
                  "expected it to end, by itself or by scancel " + job);
}

namespace {

// Returns a word that a shell reads as `text`.
std::string shell_word(const std::string& text) {
  std::string word = "'";
  for (const char c : text) {
    if (c == '\'') {
      word += "'\\''";
    } else {
      word += c;
    }
  }
  return word + '\'';
}

fs::path list_path(const fs::path& directory) { return directory / "slurm" / "to_do.json"; }

std::string script_text(const fs::path& directory, int tasks, int runs,
                        const SlurmOptions& options) {
  std::string text = "#!/bin/bash\n#SBATCH --job-name=" + options.name + "\n#SBATCH --array=0-" +
                     std::to_string(tasks - 1);
  if (options.tasks_at_a_time > 0) text += '%' + std::to_string(options.tasks_at_a_time);
  text += "\n#SBATCH --cpus-per-task=" + std::to_string(options.cores) +
          "\n#SBATCH --signal=B:USR1@" + std::to_string(notice_time) +
          "\n#SBATCH --output=" + (directory / "slurm" / "%A_%a.log").string() + '\n';
  for (const std::string& option : options.sbatch_options) text += "#SBATCH " + option + '\n';
  // Slurm balances the load where each run is a task, and a task leaves when its run is done.
  const char* const only_slice = tasks == runs ? " --only-slice" : "";
  // exec makes the shell, which gets the signal, weft itself. Until that can heed it, it is
  // ignored.
  return text + "trap '' USR1\nexec " + shell_word(options.program) + " sweep work " +
         shell_word(directory.string()) + " --list " + shell_word(list_path(directory).string()) +
         " --slice \"$SLURM_ARRAY_TASK_ID/" + std::to_string(tasks) + '"' + only_slice +
         options.worker_options + '\n';
}

}  // namespace

SlurmJob submit_to_slurm(const fs::path& directory, const SweepPlan& plan,
                         const std::vector<RunToDo>& list, const SlurmOptions& options) {
  const fs::path place = fs::absolute(directory);
  const fs::path folder = place / "slurm";
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw FileError(folder.string() + ": cannot create: " + error.message());
  const int most = largest_array(folder);
  if (options.tasks > most) {
    throw CaseError({"--tasks " + std::to_string(options.tasks)},
                    "more tasks than an array of this cluster may have",
                    "expected at most " + std::to_string(most) + ", its MaxArraySize");
  }
  const int runs = static_cast<int>(std::min<std::size_t>(list.size(), 1U << 30U));
  const int tasks = std::min(runs, options.tasks > 0 ? options.tasks : most);
  write_to_do_list(list_path(place), plan, list);
  write_whole_file(folder / "job.sh", script_text(place, tasks, runs, options));
  const ToolEnd end = run_tool(folder, {"sbatch", "--parsable", (folder / "job.sh").string()});
  if (end.code != 0) {
    throw FileError((folder / "job.sh").string() + ": sbatch refuses it (exit code " +
                    std::to_string(end.code) + "): " + end.errors);
  }
  // sbatch prints "JOB" or "JOB;CLUSTER".
  SlurmJob job{end.output.substr(0, end.output.find_first_of(";\n")), tasks};
  write_whole_file(folder / "job.json", Json{{"job", job.id}, {"tasks", tasks}}.dump() + '\n');
  return job;
}

}  // namespace weft::sim
