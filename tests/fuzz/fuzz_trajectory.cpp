#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>

#include "bsi/shapes.h"
#include "sim/base/file_error.h"
#include "sim/base/reading_process.h"
#include "sim/case/case_reader.h"
#include "sim/probes/outputs.h"
#include "sim/run/restart.h"
#include "sim/run/resumption.h"
#include "sim/run/run_checkpoint.h"
#include "sim/trajectory/frame_copy.h"
#include "sim/trajectory/trajectory.h"
#include "sim/view/render_trajectory.h"
#include "sim/view/trajectory_info.h"
#include "tests/fuzz/described_hdf5.h"
#include "tests/fuzz/fuzz_readers.h"
#include "tests/fuzz/input_files.h"

namespace weft::sim {

namespace {

[[noreturn]] void fail_trajectory(const char* what) {
  std::fprintf(stderr, "%s\n", what);
  std::abort();
}

// Work with a trajectory by its name, with the rest of the line.
class TrajectoryWork {
 public:
  explicit TrajectoryWork(const InputFolder& folder) : folder_(folder) {}

  void carry_out(const std::string& line) const {
    const std::size_t end = std::min(line.find(' '), line.size());
    const std::string name = line.substr(0, end),
                      rest = line.substr(std::min(end + 1, line.size()));
    if (name == "info") {
      const TrajectorySummary summary = summarise_trajectory(path_);
      if (to_text(summary).empty() || to_json(summary).empty()) fail_trajectory("no summary");
    } else if (name == "crossings") {
      const std::vector<FrameCrossings> crossings = count_crossings(path_);
      if (to_text(crossings).empty() || to_json(crossings).empty()) fail_trajectory("no count");
    } else if (name == "outputs") {
      evaluate(rest);
    } else if (name == "render") {
      render(rest);
    } else if (name == "resume") {
      resume();
    } else if (name == "copy") {
      copy();
    } else if (name == "restart") {
      restart(rest);
    } else if (name == "checkpoint") {
      read_state(rest);
    }
  }

 private:
  void evaluate(const std::string& text) const {
    const TrajectoryReader reader(path_);
    const std::vector<OutputExpression> outputs =
        text.empty() ? recorded_outputs(reader, path_)
                     : std::vector<OutputExpression>{output_of(text)};
    if (evaluate_outputs(outputs, reader).size() != outputs.size())
      fail_trajectory("outputs without values");
  }

  void render(const std::string& text) const {
    RenderOptions options;
    options.width = 16;
    options.height = 12;
    options.movie = false;
    options.force = true;
    for (const std::string& word : words_of(text)) {
      const std::string value = word.substr(std::min(word.find('=') + 1, word.size()));
      const double number = std::strtod(value.c_str(), nullptr);
      const int level = number > 0 ? static_cast<int>(std::min(number, 30.0)) : 0;
      if (word.starts_with("colour=")) options.colour_field = value;
      if (word.starts_with("lod=") && number > 0) options.detail_pixels = number;
      if (word.starts_with("level=")) options.surface_of_level = level;
      if (word.starts_with("spheres=")) options.spheres_of_level = level;
    }
    if (options.colour_field) {
      options.width = 240;  // the smallest picture with a legend
      options.height = 180;
      options.spheres_of_level.reset();
    }
    if (options.spheres_of_level) options.detail_pixels.reset(), options.surface_of_level.reset();
    if (options.detail_pixels) options.surface_of_level.reset();
    render_trajectory(path_, folder_.path("pictures"), options);
  }

  // The case of the trajectory, as if it lay beside it.
  Case case_of_run(const std::vector<std::string>& overrides) const {
    const std::string text = TrajectoryReader(path_).case_text();
    return parse_case(text, folder_.path("case.toml"), overrides);
  }

  void resume() const {
    Case source = case_of_run({});
    find_resumption(path_, source, {});
  }

  // Copies frames as a resumed run does, which has bodies and series of its own.
  void copy() const {
    const bsi::Surface cloth = bsi::make_rectangle(1, 1, 3, 4);
    TrajectoryLayout layout;
    layout.bodies.resize(1);
    layout.bodies[0].name = "cloth";
    layout.bodies[0].atlas = cloth.atlas;
    layout.bodies[0].fields = {{"heat", "K", "heat", 1}};
    layout.series = {{"steps", "1"}, {"energy", "J"}};
    layout.step_series = {{"step_time", "s"}};
    layout.records = {{"reactions/pin/force", "N", "reactions", 3}};
    TrajectoryWriter::Options options;
    options.force = true;
    options.step_series = layout.step_series;
    options.records = layout.records;
    const int frames = TrajectoryReader(path_).frames();
    const std::string copy = folder_.path("copy.h5");
    {
      TrajectoryWriter writer(copy, layout.bodies, layout.series, options, {cloth.positions});
      copy_frames(path_, frames, layout, writer);
    }
    const TrajectoryReader from(path_), to(copy);
    if (to.frames() != frames) fail_trajectory("a copy with other frames");
  }

  void restart(const std::string& time) const {
    Case source = case_of_run({"restart.path=run.h5", "restart.time=" + time});
    read_restart(source);
    if (source.restart && !source.restart->states) fail_trajectory("no states");
  }

  static void read_state(const std::string& digits) {
    std::string bytes;
    for (std::size_t i = 0; i + 1 < digits.size(); i += 2)
      bytes += static_cast<char>(std::strtol(digits.substr(i, 2).c_str(), nullptr, 16));
    try {
      StateArchive archive{std::string_view(bytes)};
      RunCheckpoint().transfer(archive);
    } catch (const std::invalid_argument&) {
    }
  }

  static std::vector<std::string> words_of(const std::string& text) {
    std::vector<std::string> words;
    for (std::size_t start = 0; start < text.size();) {
      const std::size_t end = std::min(text.find(' ', start), text.size());
      words.push_back(text.substr(start, end - start));
      start = end + 1;
    }
    return words;
  }

  const InputFolder& folder_;
  const std::string path_ = folder_.path("run.h5");
};

// Carries out the work. Errors for the user end it; other exceptions pass.
void try_work(const TrajectoryWork& work, const std::string& line) {
  try {
    work.carry_out(line);
  } catch (const CaseError&) {
  } catch (const FileError&) {
  } catch (const RenderUsageError&) {
  } catch (const std::runtime_error& error) {
    const std::string_view reason = error.what();
    const bool is_of_pictures = reason.starts_with("cannot draw") || reason.starts_with("field ") ||
                                reason.find("no complete frame to draw") != reason.npos;
    if (!is_of_pictures) throw;
  }
}

// HDF5 may crash on bytes. Then it ends a process of its own; any other end is a fault.
void work_on_bytes(const TrajectoryWork& work) {
  const ProcessEnd end = run_in_process(
      [&] {
        for (const char* each : {"info", "outputs", "resume"}) try_work(work, each);
        return 0;
      },
      [] {}, reading_cpu_limit);
  if (end.signal == 0 && end.code != 0) fail_trajectory("a reader failed");
  if (end.signal == SIGABRT) fail_trajectory("an exception that no one catches");
}

}  // namespace

void fuzz_trajectory(std::string_view input) {
  const InputFolder& folder = empty_input_folder();
  const TrajectoryWork work(folder);
  if (input.starts_with("\x89HDF")) {
    folder.write("run.h5", input);
    return work_on_bytes(work);
  }
  const std::vector<std::string> lines = lines_of(input);
  write_described_file(folder.path("run.h5"), lines);
  constexpr std::string_view mark = "do ";
  int left = 4;  // work on one input
  for (const std::string& line : lines) {
    if (line.starts_with(mark) && left-- > 0) try_work(work, line.substr(mark.size()));
  }
}

}  // namespace weft::sim
