#include "sim/sweep/run_folder.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "sim/base/file_error.h"
#include "sim/case/case_error.h"
#include "sim/case/case_reader.h"
#include "sim/run/numerics_version.h"
#include "sim/run/resumption.h"
#include "sim/sweep/run_identity.h"
#include "sim/sweep/whole_file.h"
#include "sim/trajectory/file_lock.h"

namespace weft::sim {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t name_digits = 16;
constexpr const char* attempt_prefix = "attempt_";
constexpr std::array failure_names{
    "", "bad_case", "numerical_failure", "input_output", "over_time", "over_memory", "signal"};
// Files that an attempt leaves to its run, and those with which another attempt can go on.
constexpr std::array kept_files{"run.toml", "run.h5", "run.xdmf", "run.checkpoint", "log.txt"};
constexpr std::array resumed_files{"run.h5", "run.xdmf", "run.checkpoint"};

std::vector<fs::path> attempts_in(const fs::path& folder) {
  std::vector<fs::path> attempts;
  std::error_code missing;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, missing)) {
    if (entry.path().filename().string().starts_with(attempt_prefix))
      attempts.push_back(entry.path());
  }
  std::ranges::sort(attempts);
  return attempts;
}

Json result_json(const RunResult& result) {
  Json json{{"hash", result.hash},
            {"status", result.is_done() ? "done" : "failed"},
            {"failure", result.is_done() ? Json() : Json(failure_name(result.failure))},
            {"reason", result.reason.empty() ? Json() : Json(result.reason)},
            {"exit_code", result.exit_code},
            {"signal", result.signal},
            {"attempts", result.attempts},
            {"wall_s", result.wall_seconds},
            {"cpu_s", result.cpu_seconds},
            {"peak_memory_mib", result.peak_memory},
            {"weft_version", result.version},
            {"numerics", numerics_version}};
  json["outputs"] = Json::object();
  for (const auto& [text, value] : result.outputs)
    if (!std::isinf(value)) json["outputs"][text] = std::isnan(value) ? Json() : Json(value);
  const Json report = Json::parse(result.report, nullptr, false);
  json["report"] = report.is_discarded() ? Json() : report;
  return json;
}

// Leaves the report out of a result that is parsed: it is most of the file, and has no reader here.
bool keep_all_but_report(int depth, Json::parse_event_t event, const Json& parsed) {
  return depth != 1 || event != Json::parse_event_t::key || parsed != "report";
}

RunResult result_from(const Json& json) {
  RunResult result;
  json.at("hash").get_to(result.hash);
  if (json.at("status") != "done") {
    const auto name = std::ranges::find(failure_names, json.at("failure").get<std::string>());
    if (name == failure_names.end()) throw Json::other_error::create(501, "failure", nullptr);
    result.failure = static_cast<RunResult::Failure>(name - failure_names.begin());
  }
  if (!json.at("reason").is_null()) json.at("reason").get_to(result.reason);
  json.at("exit_code").get_to(result.exit_code);
  json.at("signal").get_to(result.signal);
  json.at("attempts").get_to(result.attempts);
  json.at("wall_s").get_to(result.wall_seconds);
  json.at("cpu_s").get_to(result.cpu_seconds);
  json.at("peak_memory_mib").get_to(result.peak_memory);
  json.at("weft_version").get_to(result.version);
  if (json.contains("outputs")) {
    for (const auto& [text, value] : json.at("outputs").items())
      result.outputs[text] = value.is_null() ? NAN : value.get<double>();
  }
  return result;
}

// True if all bytes of a file can be read.
bool can_be_read(const fs::path& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return false;
  std::vector<char> part(1 << 16);
  ssize_t count = 1;
  while (count > 0 || (count < 0 && errno == EINTR)) count = read(file, part.data(), part.size());
  close(file);
  return count == 0;
}

// Returns the message of an exception with which `find` refuses, or an empty text.
std::string refusal_of(const auto& find) {
  try {
    find();
  } catch (const CaseError& error) {
    return error.what();
  } catch (const FileError& error) {
    return error.what();
  } catch (const std::bad_alloc&) {
    return "";  // another time there may be enough memory
  }
  return "";
}

}  // namespace

const char* failure_name(RunResult::Failure failure) {
  return failure_names[static_cast<std::size_t>(failure)];
}

const char* state_name(RunState state) {
  constexpr std::array names{"not begun", "running", "interrupted", "done", "failed"};
  return names[static_cast<std::size_t>(state)];
}

RunAttempt::RunAttempt(RunAttempt&& other) noexcept
    : folder_(std::move(other.folder_)),
      lock_(std::exchange(other.lock_, -1)),
      resumes_(other.resumes_) {}

RunAttempt::~RunAttempt() {
  if (lock_ >= 0) close(lock_);
}

std::string RunAttempt::fault_of_checkpoint(const std::string& case_text,
                                            bool estimates_error) const {
  const fs::path trajectory = folder_ / "run.h5";
  const auto files_can_be_read = [&] {
    return can_be_read(folder_ / "run.checkpoint") && can_be_read(trajectory) &&
           !is_locked(trajectory.string());
  };
  if (!files_can_be_read()) return "";
  std::optional<Case> source;
  const auto read = [&] { source = parse_case(case_text, (folder_ / "run.toml").string()); };
  if (!refusal_of(read).empty() || !source) return "";
  const std::string reason = refusal_of(
      [&] { find_resumption(trajectory.string(), *source, {.estimates_error = estimates_error}); });
  // A disk may fail between the two.
  return files_can_be_read() ? reason : "";
}

RunFolder::RunFolder(const fs::path& sweep, const std::string& hash)
    : path_(sweep / "runs" / hash.substr(0, name_digits)), hash_(hash) {}

std::optional<RunResult> RunFolder::result() const {
  const std::optional<std::string> text = read_whole_file(path_ / "result.json");
  if (!text) return std::nullopt;
  try {
    RunResult result = result_from(Json::parse(*text, keep_all_but_report));
    return result.hash == hash_ ? std::optional(result) : std::nullopt;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

std::string RunFolder::result_mark() const {
  const std::optional<std::string> text = read_whole_file(path_ / "result.json");
  return text ? sha256(*text) : "";
}

RunState RunFolder::state_without_result() const {
  if (is_locked(lock_path().string())) return RunState::running;
  return attempts_in(path_).empty() ? RunState::not_begun : RunState::interrupted;
}

int RunFolder::lock() const {
  while (true) {
    const int file = open(lock_path().c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (file < 0)
      throw FileError(lock_path().string() + ": cannot be locked: " + std::strerror(errno));
    const bool is_locked_here = lock_open_file(file);
    // A worker that ends removes the file before it gives up the lock.
    if (is_locked_here && names_open_file(lock_path().string(), file)) return file;
    close(file);
    if (!is_locked_here) return -1;
  }
}

std::optional<RunAttempt> RunFolder::begin(const std::string& case_text, const Start& start) const {
  std::error_code error;
  fs::create_directories(path_, error);
  if (error) throw FileError(path_.string() + ": cannot create: " + error.message());
  // The process of the run inherits the lock (ChildProcess), so that it lasts as long as both.
  RunAttempt attempt({}, lock(), false);
  if (attempt.lock_ < 0) return std::nullopt;
  // Another worker may have ended the run before this one got the lock.
  if (result() && result_mark() != start.replaced) {
    fs::remove(lock_path(), error);
    return std::nullopt;
  }
  attempt.folder_ = make_attempt_folder(start.anew);
  if (attempt.folder_.empty()) return std::nullopt;
  take_over_files(attempt.folder_, start.anew);
  write_file(attempt.folder_ / "run.toml", case_text);
  attempt.resumes_ = fs::exists(attempt.folder_ / "run.checkpoint");
  return attempt;
}

fs::path RunFolder::make_attempt_folder(bool anew) const {
  const std::vector<fs::path> earlier = attempts_in(path_);
  fs::path folder = path_ / (attempt_prefix + process_name());
  std::error_code error;
  if (!anew && !earlier.empty()) {
    fs::rename(earlier.front(), folder, error);
    if (error) return {};
  }
  for (const fs::path& each : earlier) {
    if (each != folder || anew) fs::remove_all(each, error);
  }
  error.clear();
  fs::create_directories(folder, error);
  if (error) throw FileError(folder.string() + ": cannot create: " + error.message());
  return folder;
}

void RunFolder::take_over_files(const fs::path& attempt, bool anew) const {
  std::error_code ignored;  // without these files the run begins anew
  for (const char* name : resumed_files) {
    if (anew) {
      fs::remove(path_ / name, ignored);
    } else if (!fs::exists(attempt / name)) {
      fs::rename(path_ / name, attempt / name, ignored);
    }
  }
  fs::remove(path_ / "result.json", ignored);
}

bool RunFolder::finish(RunAttempt attempt, const RunResult& result) const {
  if (!attempt.is_ours()) return false;
  for (const char* name : kept_files) {
    std::error_code error;
    if (!fs::exists(attempt.folder() / name)) continue;
    flush_file(attempt.folder() / name);
    fs::rename(attempt.folder() / name, path_ / name, error);
    if (error) throw FileError((path_ / name).string() + ": cannot be written: " + error.message());
  }
  write_whole_file(path_ / "result.json",
                   result_json(result).dump(2, ' ', false, Json::error_handler_t::replace) + '\n');
  std::error_code ignored;  // a folder that stays is an attempt that nobody goes on with
  fs::remove_all(attempt.folder(), ignored);
  fs::remove(lock_path(), ignored);
  return true;
}

void RunFolder::discard(RunAttempt attempt) const {
  if (!attempt.is_ours()) return;
  std::error_code ignored;  // without its checkpoint, a folder that stays is only begun anew
  fs::remove(attempt.folder() / "run.checkpoint", ignored);
  fs::remove_all(attempt.folder(), ignored);
  fs::remove(lock_path(), ignored);
}

}  // namespace weft::sim
