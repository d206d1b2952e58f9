// The weft command.
#include <CLI/CLI.hpp>
#include <iostream>

#include "sim/case_reader.h"
#include "sim/render_trajectory.h"
#include "sim/run_command.h"
#include "sim/trajectory.h"
#include "sim/trajectory_info.h"

namespace {

constexpr const char* description = R"(Weft simulates cloth, shells and particles stored as geometry images, integrated under error control.

  weft run cases/drape_torus.toml                    simulate; writes out/drape_torus.h5 and .xdmf
  weft run CASE -o DIR --set time.duration=0.5       the same with any case key overridden
  weft check CASE                                    what the scene needs, what it skips, and why
  weft info out/drape_torus.h5 --crossings           summary; counts surfaces that pass through each other
  weft render out/drape_torus.h5 -o pictures         PNG frames, and a movie when ffmpeg is there
  weft schema                                        the case file's JSON schema (--markdown: reference page)

Exit codes: 0 done, 1 numerical failure (the last good state is kept), 2 bad case or usage,
4 input or output, 130 and 143 stopped by Ctrl-C and SIGTERM after the step in hand.)";

using namespace weft::sim;

int show_info(const std::string& path, bool crossings, bool json) {
  try {
    if (!crossings) {
      const TrajectorySummary summary = summarise_trajectory(path);
      std::cout << (json ? to_json(summary) : to_text(summary));
      return exit_code::done;
    }
    const std::vector<FrameCrossings> frames = count_crossings(path);
    std::cout << (json ? to_json(frames) : to_text(frames));
    return exit_code::done;
  } catch (const TrajectoryError& error) {
    std::cerr << error.what() << '\n';
    return exit_code::input_output;
  }
}

int render(const std::string& path, const std::string& directory, RenderOptions options) {
  try {
    options.progress = [](int done, int all) { std::cerr << "\rpicture " << done << " of " << all << std::flush; };
    const RenderReport report = render_trajectory(path, directory, options);
    std::cerr << '\n';
    std::cout << report.pictures << " pictures in " << directory << '\n'
              << (report.movie.empty() ? report.why_no_movie : report.movie) << '\n';
    return exit_code::done;
  } catch (const std::runtime_error& error) {
    std::cerr << error.what() << '\n';
    return exit_code::input_output;
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{description};
  app.set_version_flag("--version", "weft " WEFT_VERSION);
  app.require_subcommand(1);
  app.failure_message(CLI::FailureMessage::help);
  int code = exit_code::done;

  RunCommand command;
  const auto add_case = [&](CLI::App* sub) {
    sub->add_option("case", command.case_path, "TOML case file")->required();
    sub->add_option("--set", command.overrides, "Override a case key: KEY=VALUE, for example contact.friction=0.3")
        ->type_name("KEY=VALUE");
  };
  CLI::App* run = app.add_subcommand("run", "Simulate a case");
  add_case(run);
  run->add_option("-o,--output", command.directory, "Folder of the trajectory")->capture_default_str();
  run->add_flag("--force", command.force, "Overwrite an existing trajectory");
  run->add_flag("--json", command.json, "Print the report as one JSON object");
  run->add_flag("--quiet", command.quiet, "No progress bar");
  run->callback([&] { code = run_case(command); });

  CLI::App* check = app.add_subcommand("check", "Say what a case needs and skips, without running it");
  add_case(check);
  check->callback([&] { code = check_case(command); });

  std::string trajectory;
  bool crossings = false, json = false;
  CLI::App* info = app.add_subcommand("info", "Summarise a trajectory");
  info->add_option("trajectory", trajectory, "HDF5 file of a run")->required();
  info->add_flag("--crossings", crossings, "Count the triangles that pass through each other, frame by frame, exactly");
  info->add_flag("--json", json, "Print one JSON object");
  info->callback([&] { code = show_info(trajectory, crossings, json); });

  std::string pictures = "pictures";
  RenderOptions drawing;
  CLI::App* render_command = app.add_subcommand("render", "Draw the frames of a trajectory");
  render_command->add_option("trajectory", trajectory, "HDF5 file of a run")->required();
  render_command->add_option("-o,--output", pictures, "Folder of the pictures")->capture_default_str();
  render_command->add_option("--every", drawing.every, "Draw every Nth frame")->check(CLI::PositiveNumber)->capture_default_str();
  render_command->add_option("--width", drawing.width, "Pixels")->check(CLI::Range(1, 8192))->capture_default_str();
  render_command->add_option("--height", drawing.height, "Pixels")->check(CLI::Range(1, 8192))->capture_default_str();
  render_command->callback([&] { code = render(trajectory, pictures, drawing); });

  bool markdown = false;
  CLI::App* schema = app.add_subcommand("schema", "Print the JSON schema of case files");
  schema->add_flag("--markdown", markdown, "The reference page instead");
  schema->callback([&] { std::cout << (markdown ? case_reference_markdown() : case_json_schema()); });

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? exit_code::done : exit_code::bad_case;
  }
  return code;
}
