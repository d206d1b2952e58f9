#include "sim/sweep/sweep_folder.h"

#include <fstream>

#include "sim/base/file_error.h"
#include "sim/case/case_error.h"

namespace weft::sim {

namespace {

namespace fs = std::filesystem;

bool is_there(const fs::path& path) {
  std::error_code unknown;
  return fs::exists(fs::symlink_status(path, unknown));
}

// Returns those files in the folder that a sweep would replace or remove.
std::vector<fs::path> replaced_files(const fs::path& directory) {
  std::vector<fs::path> found;
  for (const char* name : {"plan.json", "to_do.json", "summary.csv", "summary.h5",
                           "correlations.csv", "slurm/to_do.json", "slurm/job.sh"}) {
    if (is_there(directory / name)) found.push_back(directory / name);
  }
  std::error_code unknown;
  for (const auto& entry : fs::directory_iterator(directory / "plots", unknown)) {
    if (entry.path().extension() == ".svg") found.push_back(entry.path());
  }
  return found;
}

// Returns true for plans of all versions of Weft, which have this key near their beginning.
bool is_plan(const fs::path& path) {
  std::error_code unknown;
  if (!fs::is_regular_file(path, unknown)) return false;
  std::string begin(256, '\0');
  std::ifstream(path, std::ios::binary).read(begin.data(), std::ssize(begin));
  return begin.find("\"plan_format\"") != std::string::npos;
}

void refuse_same_file(const fs::path& replaced, const std::string& file) {
  std::error_code unknown;
  if (!fs::equivalent(replaced, file, unknown)) return;
  throw CaseError({replaced.string()}, "the sweep reads this file, which weft sweep would replace",
                  "expected another folder for the results (-o), or another name of the file");
}

}  // namespace

void refuse_lost_files(const fs::path& directory, const std::vector<std::string>& files,
                       const SweepPlan& plan) {
  const std::vector<fs::path> replaced = replaced_files(directory);
  for (const fs::path& each : replaced) {
    for (const std::string& file : files) refuse_same_file(each, file);
    for (const auto& [file, digest] : plan.digests) refuse_same_file(each, file);
  }
  // Each sweep writes its plan before all else, so another command that has just begun in this
  // folder has a plan by now if it has any of the files found above.
  if (replaced.empty() || is_plan(directory / "plan.json")) return;
  throw FileError(replaced.front().string() +
                  ": exists already, in a folder without a plan of Weft, and is not overwritten; "
                  "name another folder (-o), or move the file");
}

}  // namespace weft::sim
