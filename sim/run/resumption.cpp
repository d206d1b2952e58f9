#include "sim/run/resumption.h"

#include <filesystem>
#include <sstream>

#include "sim/base/file_status.h"
#include "sim/case/case_error.h"
#include "sim/case/case_reader.h"
#include "sim/case/case_text.h"
#include "sim/case/case_writer.h"
#include "sim/trajectory/frame_copy.h"
#include "sim/trajectory/trajectory.h"

namespace weft::sim {

namespace {

[[noreturn]] void refuse_resumption(const ResumeOptions& options, const std::string& message,
                                    const std::string& hint) {
  throw CaseError({options.extends ? "--extend" : "--resume"}, message, hint);
}

// Throws CaseError with the first line in which the case differs from that of the trajectory.
void require_same_case(const ResumeOptions& options, const std::string& trajectory,
                       const std::string& before, const std::string& now) {
  if (before == now) return;
  std::istringstream old_lines(before), new_lines(now);
  std::string old_line, new_line;
  while (old_line == new_line && (old_lines || new_lines)) {
    if (!std::getline(old_lines, old_line)) old_line.clear();
    if (!std::getline(new_lines, new_line)) new_line.clear();
  }
  refuse_resumption(
      options,
      trajectory + " was made by another case: it has " + in_quotes(old_line) + ", not " +
          in_quotes(new_line),
      "expected the case of that run; --force begins anew, -o writes to another folder");
}

void require_duration(const ResumeOptions& options, const std::string& trajectory, double before,
                      double now) {
  if (before == now || (options.extends && before < now)) return;
  const std::string message = trajectory + " has a time.duration of " + number_text(before) +
                              " s, not " + number_text(now) + " s";
  refuse_resumption(
      options, message,
      options.extends ? "expected a longer one" : "expected the same; --extend makes it longer");
}

// Returns the case of a trajectory, with the options of time of `source` where these await a
// choice.
std::string text_of_case(const TrajectoryReader& reader, const Case& source) {
  Case before = parse_case(without_obsolete_keys(reader.case_text()), source.path);
  if (source.awaits_accuracy()) {
    const double duration = before.time.duration;
    before.time = source.time;
    before.time.duration = duration;
  }
  return motion_text(before);
}

// Checks a trajectory without a checkpoint. Its run has to begin anew.
void check_without_checkpoint(const std::string& trajectory, const Case& source,
                              const ResumeOptions& options) {
  require_readable(trajectory, 0);
  const TrajectoryReader reader(trajectory);
  require_same_case(options, trajectory, text_of_case(reader, source), motion_text(source));
  if (reader.end() && reader.end()->status == "done") {
    refuse_resumption(options, trajectory + " is complete, and has no checkpoint to go on from",
                      "expected the trajectory of a run that was stopped; --force begins anew");
  }
}

// Returns the text by which two cases are compared. Frames may be added to what --extend adds.
std::string text_to_compare(const Case& source, const ResumeOptions& options,
                            const RunCheckpoint& checkpoint) {
  Case compared = source;
  if (options.extends) {
    const double former_end = checkpoint.time.duration;
    std::erase_if(compared.output.frame_times, [&](double time) { return time > former_end; });
  }
  return motion_text(compared);
}

void check_with_checkpoint(const std::string& trajectory, const Case& source,
                           const ResumeOptions& options, const RunCheckpoint& checkpoint) {
  require_same_case(options, trajectory, without_obsolete_keys(checkpoint.case_text),
                    text_to_compare(source, options, checkpoint));
  require_duration(options, trajectory, checkpoint.time.duration, source.time.duration);
  if (options.estimates_error != checkpoint.estimates_error) {
    refuse_resumption(
        options,
        trajectory + (options.estimates_error ? " has no estimate of its error"
                                              : " has an estimate of its error"),
        options.estimates_error ? "expected no --estimate-error" : "expected --estimate-error");
  }
  const int frames = checkpoint.frames;
  require_readable(trajectory, frames);
  const TrajectoryReader reader(trajectory);
  if (frames > reader.frames() ||
      (frames > 0 && reader.time(frames - 1) != checkpoint.last_frame_time)) {
    throw FileError(trajectory + ": is not the trajectory of " + checkpoint_path(trajectory) +
                    ", whose last frame it lacks");
  }
}

}  // namespace

Resumption find_resumption(const std::string& trajectory, Case& source,
                           const ResumeOptions& options) {
  TrajectoryWriter::refuse_existing(trajectory, true);
  TrajectoryWriter::refuse_foreign_sidecar(trajectory);
  if (!std::filesystem::exists(status_of(trajectory))) return {};
  Resumption found{read_checkpoint(trajectory)};
  if (!found.checkpoint) {
    check_without_checkpoint(trajectory, source, options);
    return found;
  }
  check_with_checkpoint(trajectory, source, options, *found.checkpoint);
  if (source.awaits_accuracy()) {
    source.time = found.checkpoint->time;
    source.accuracy_choice = found.checkpoint->accuracy_choice;
    source.resolved_text = case_text(source);
  }
  return found;
}

}  // namespace weft::sim
