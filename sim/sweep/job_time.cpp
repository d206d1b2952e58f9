#include "sim/sweep/job_time.h"

#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>

namespace weft::sim {

namespace {

// Returns the leading whole number of a text, or nothing.
std::optional<long long> whole_number(const std::string& text) {
  long long number = 0;
  const auto end = std::from_chars(text.data(), text.data() + text.size(), number);
  return end.ec == std::errc() && number > 0 ? std::optional(number) : std::nullopt;
}

// Returns what squeue says about the end of the job, in seconds since 1970. The first task of an
// array has the number of the whole array, too, so that tasks are asked for as such.
std::string end_by_squeue() {
  std::FILE* const output = popen(
      "SLURM_TIME_FORMAT=%s squeue --noheader --format=%e "
      "--jobs=\"${SLURM_ARRAY_TASK_ID:+${SLURM_ARRAY_JOB_ID}_}"
      "${SLURM_ARRAY_TASK_ID:-$SLURM_JOB_ID}\" 2>/dev/null",
      "r");
  if (output == nullptr) return "";
  char line[64] = "";
  const bool has_line = std::fgets(line, sizeof line, output) != nullptr;
  pclose(output);
  return has_line ? line : "";
}

}  // namespace

std::optional<double> seconds_left_of_job() {
  if (std::getenv("SLURM_JOB_ID") == nullptr) return std::nullopt;
  const char* const told = std::getenv("SLURM_JOB_END_TIME");
  const std::optional<long long> end = whole_number(told != nullptr ? told : end_by_squeue());
  if (!end) return std::nullopt;
  return static_cast<double>(*end - std::time(nullptr));
}

}  // namespace weft::sim
