#include "sim/run/run_checkpoint.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>

#include "sim/base/file_error.h"
#include "sim/base/file_status.h"
#include "sim/base/fingerprint.h"
#include "sim/run/numerics_version.h"

namespace weft::sim {

namespace {

constexpr std::string_view mark_of_all_versions = "weft checkpoint ";

// First bytes of a checkpoint. The fingerprint and the contents follow.
std::string checkpoint_mark() {
  return std::string(mark_of_all_versions) + "1, version " WEFT_VERSION ", numerics " +
         std::to_string(numerics_version) + '\n';
}

std::uint64_t fingerprint_of(std::string_view contents) {
  Fingerprint fingerprint;
  fingerprint.add(contents);
  return fingerprint.value();
}

void write_checkpoint_file(const std::string& path, const std::string& contents) {
  const std::uint64_t fingerprint = fingerprint_of(contents);
  unlink(path.c_str());  // a link would lead to another file
  errno = 0;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << checkpoint_mark();
  file.write(reinterpret_cast<const char*>(&fingerprint), sizeof fingerprint);
  file.write(contents.data(), static_cast<std::streamsize>(contents.size()));
  file.close();
  if (file) return;
  const int error = errno;
  std::remove(path.c_str());
  throw FileError(path + ": cannot write: " + std::strerror(error != 0 ? error : EIO));
}

// Throws FileError if `path` names a file that has something else than a checkpoint.
void refuse_foreign_file(const std::string& path) {
  std::string begin(mark_of_all_versions.size(), '\0');
  std::ifstream(path, std::ios::binary).read(begin.data(), std::ssize(begin));
  if (begin == mark_of_all_versions) return;
  throw FileError(path + ": is no checkpoint of Weft, and is only overwritten by force (--force)");
}

}  // namespace

void RunCheckpoint::transfer(StateArchive& archive) {
  archive(case_text, time, accuracy_choice, estimates_error, is_complete, reached, steps, frames,
          last_frame_time, next_frame, smallest_gap, largest_stretch, bill, simulation, recorder,
          monitor);
  std::size_t count = energies.size();
  archive(count);
  // Read one by one: an archive that claims more than it has ends before they take much memory.
  if (archive.reads()) energies.clear();
  for (std::size_t i = 0; i < count; ++i) {
    if (archive.reads()) energies.emplace_back();
    archive(energies[i].first, energies[i].second);
  }
}

std::string checkpoint_path(const std::string& trajectory) {
  return std::filesystem::path(trajectory).replace_extension(".checkpoint").string();
}

std::string unfinished_checkpoint_path(const std::string& trajectory) {
  return checkpoint_path(trajectory) + ".tmp";
}

void write_checkpoint(const std::string& trajectory, RunCheckpoint checkpoint) {
  StateArchive archive;
  checkpoint.transfer(archive);
  const std::string path = checkpoint_path(trajectory);
  const std::string temporary = unfinished_checkpoint_path(trajectory);
  write_checkpoint_file(temporary, archive.bytes());
  if (std::rename(temporary.c_str(), path.c_str()) == 0) return;
  const int error = errno;
  std::remove(temporary.c_str());
  throw FileError(path + ": cannot write: " + std::strerror(error));
}

std::optional<RunCheckpoint> read_checkpoint(const std::string& trajectory) {
  const std::string path = checkpoint_path(trajectory);
  const std::filesystem::file_status status = status_of(path);
  if (!std::filesystem::exists(status)) return std::nullopt;
  if (!std::filesystem::is_regular_file(status)) throw FileError(path + ": is not a regular file");
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  if (!file) throw FileError(path + ": cannot be read");
  const std::string mark = checkpoint_mark();
  if (!bytes.starts_with(mark))
    throw FileError(path + ": is not a checkpoint of this version of Weft");
  std::string_view contents = std::string_view(bytes).substr(mark.size());
  std::uint64_t fingerprint = 0;
  RunCheckpoint checkpoint;
  try {
    StateArchive head(contents.substr(0, sizeof fingerprint));
    head(fingerprint);
    contents.remove_prefix(sizeof fingerprint);
    if (fingerprint != fingerprint_of(contents)) throw std::invalid_argument("damaged");
    StateArchive archive(contents);
    checkpoint.transfer(archive);
    if (!archive.is_at_end()) throw std::invalid_argument("damaged");
  } catch (const std::invalid_argument&) {
    throw FileError(path + ": is damaged");
  }
  return checkpoint;
}

void refuse_foreign_checkpoint(const std::string& trajectory, bool force) {
  namespace fs = std::filesystem;
  const std::string path = checkpoint_path(trajectory);
  refuse_long_name(unfinished_checkpoint_path(trajectory));
  const fs::file_status found = status_of(path);
  if (fs::exists(found) && !fs::is_regular_file(found))
    throw FileError(path + ": is not a regular file");
  if (force) return;
  if (fs::exists(found)) refuse_foreign_file(path);
  // A run that was killed leaves an empty file, or the beginning of a checkpoint.
  const std::string unfinished = unfinished_checkpoint_path(trajectory);
  const fs::file_status status = link_status_of(unfinished);
  std::error_code gone;
  const bool is_file = fs::is_regular_file(status) && fs::file_size(unfinished, gone) > 0 && !gone;
  if (is_file || fs::is_symlink(status)) refuse_foreign_file(unfinished);
}

void remove_checkpoint(const std::string& trajectory) {
  std::remove(checkpoint_path(trajectory).c_str());
}

bool WaitingCheckpoint::is_due(double pause) const {
  constexpr double interval = 0.25;  // s, as between two commits of frames
  const std::chrono::duration<double> age = std::chrono::steady_clock::now() - last_write_;
  return waiting_ && age.count() + pause >= interval;
}

void WaitingCheckpoint::write() {
  if (!waiting_) return;
  write_checkpoint(trajectory_, *std::exchange(waiting_, std::nullopt));
  has_written_ = true;
  last_write_ = std::chrono::steady_clock::now();
}

}  // namespace weft::sim
