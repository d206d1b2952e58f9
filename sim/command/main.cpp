// The weft command.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "sim/base/file_status.h"
#include "sim/case/case_error.h"
#include "sim/case/case_reader.h"
#include "sim/case/case_text.h"
#include "sim/case/material_presets.h"
#include "sim/command/argument_checks.h"
#include "sim/command/bench_command.h"
#include "sim/command/check_command.h"
#include "sim/command/command_json.h"
#include "sim/command/guarded_command.h"
#include "sim/command/modes_command.h"
#include "sim/command/progress_bar.h"
#include "sim/command/run_command.h"
#include "sim/command/sweep_arguments.h"
#include "sim/command/thread_waiting.h"
#include "sim/probes/outputs.h"
#include "sim/sweep/sweep_reader.h"
#include "sim/trajectory/trajectory.h"
#include "sim/view/field_values.h"
#include "sim/view/render_trajectory.h"
#include "sim/view/trajectory_info.h"

namespace {

constexpr const char* description =
    R"(Weft simulates cloth stored as geometry images, integrated under error control.

  weft run cases/drape_torus.toml                    simulate; writes out/drape_torus.h5 and .xdmf
  weft run CASE -o DIR --set time.duration=0.5       the same with any case key overridden
  weft check CASE                                    what the scene needs, what it skips, and why
  weft check CASE --picture start.png                the same, and a picture of the start; intersections are red
  weft check CASE --fix-initial start.h5             separates cloth that intersects slightly, in a new shape file
  weft modes CASE -n 10                              natural frequencies about the equilibrium of a case
  weft buckling CASE -n 5                            load factors at which it buckles
  weft info out/drape_torus.h5 --crossings           summary; counts surfaces that pass through each other
  weft outputs out/drape_torus.h5 'low = min(lower("cloth").z)'   numbers of a run, as expressions
  weft info --materials                              the presets of materials, their values and sources
  weft render out/drape_torus.h5 -o pictures         PNG frames, and a movie when ffmpeg is there
  weft render out/drape_torus.h5 --lod 0.5           the same with fewer triangles, exact to half a pixel
  weft render out/drape_torus.h5 --colour velocity   the same painted by a recorded field, with a legend
  weft sweep SWEEP.toml -o DIR                       many runs of a case with other values of its keys
  weft schema                                        the case file's JSON schema (--markdown: reference page)
  weft bench --help                                  experiments on speed, some against other libraries

Exit codes: 0 done, 1 numerical failure (the last good state is kept), 2 bad case or usage,
3 some runs of a sweep failed, 4 input or output, 130 and 143 stopped by Ctrl-C and SIGTERM after the current step.)";

using namespace weft::sim;

int refuse_file(const std::string& path, const std::exception& error, bool json) {
  std::string reason = error.what();
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) {
    reason = path + ": needs more memory than there is";
  } else if (const auto* fault = dynamic_cast<const std::filesystem::filesystem_error*>(&error)) {
    reason = fault_text(*fault);
  }
  complain(reason);
  if (json) std::cout << refusal_json(exit_code::input_output, reason) << '\n';
  return exit_code::input_output;
}

// Prints facts as JSON or as text. to_json() escapes control characters; printable() escapes those
// of text.
void show_facts(const auto& facts, bool json) {
  std::cout << (json ? to_json(facts) : printable(to_text(facts), true));
}

int show_info(const std::string& path, bool crossings, bool json) {
  try {
    if (crossings) {
      show_facts(count_crossings(path), json);
    } else {
      show_facts(summarise_trajectory(path), json);
    }
    return exit_code::done;
  } catch (const std::exception& error) {
    return refuse_file(path, error, json);
  }
}

// Prints outputs of a trajectory: those that `texts` give or, without any, those of its case.
int show_outputs(const std::string& path, const std::vector<std::string>& texts, bool json) {
  try {
    std::vector<OutputExpression> outputs = outputs_of(texts);
    const TrajectoryReader reader(path);
    if (texts.empty()) outputs = recorded_outputs(reader, path);
    if (outputs.empty()) {
      throw CaseError({path}, "its case has no [outputs]",
                      "expected NAME = EXPRESSION, such as 'stretch = max(largest_stretch)'");
    }
    show_facts(evaluate_outputs(outputs, reader), json);
    return exit_code::done;
  } catch (const CaseError& error) {
    complain(error.what());
    if (json) std::cout << refusal_json(exit_code::bad_case, error.what()) << '\n';
    return exit_code::bad_case;
  } catch (const std::exception& error) {
    return refuse_file(path, error, json);
  }
}

// Prints the range of the field's values, the range of the colours if the options set it, and the
// names of the bodies that lack the field.
void show_colours(const RenderOptions& options, const RenderReport& report) {
  std::cout << "coloured by " << printable(*options.colour_field) << ": "
            << rounded_text(report.least) << " to " << rounded_text(report.most)
            << after_number(report.units);
  if (options.colour_range) {
    std::cout << ", colours from " << rounded_text((*options.colour_range)[0]) << " to "
              << rounded_text((*options.colour_range)[1]);
  }
  std::cout << '\n';
  if (report.plain_bodies.empty()) return;
  std::cout << "without it, in their own colours: " << printable(quoted_list(report.plain_bodies))
            << '\n';
}

int render(const std::string& path, const std::string& directory, RenderOptions options) {
  try {
    std::optional<ProgressBar> bar;
    options.progress = [&](int done, int all) {
      if (!bar) bar.emplace(all, true, ProgressBar::Quantity{"picture", ""});
      bar->show(done);
    };
    const RenderReport report = render_trajectory(path, directory, options);
    bar.reset();
    std::cout << counted(report.pictures, "picture", "pictures") << " in " << printable(directory)
              << '\n';
    if (options.colour_field) show_colours(options, report);
    if (options.detail_pixels) {
      std::cout << report.triangles << " of " << report.all_triangles << " triangles drawn, within "
                << *options.detail_pixels << " pixels\n";
    }
    std::cout << printable(report.movie.empty() ? report.why_no_movie : report.movie, true) << '\n';
    return exit_code::done;
  } catch (const RenderUsageError& error) {
    complain(path + ": " + error.what());
    return exit_code::bad_case;
  } catch (const std::exception& error) {
    return refuse_file(path, error, false);
  }
}

// The parsed command line.
struct Arguments {
  RunCommand command;
  CheckCommand check;
  ModesCommand modes;
  std::string trajectory;
  std::vector<std::string> outputs;
  bool crossings = false, materials = false, json = false;
  std::string pictures = "pictures";
  RenderOptions drawing;
  SweepCommand sweep;
  bool markdown = false, sweep_schema = false;
  int code = exit_code::done;  // exit code of the command that ran
};

void add_case_arguments(CLI::App& sub, Arguments& arguments) {
  sub.add_option("case", arguments.command.case_path, "TOML case file")->required();
  sub.add_option("--set", arguments.command.overrides,
                 "Override a case key, for example --set contact.friction=0.3; one --set per key")
      ->option_text("KEY=VALUE")  // for a vector, CLI11 would show KEY=VALUE ...
      ->allow_extra_args(false);
}

// Validates an option: returns an error message, or an empty text if the text is a positive finite
// number.
std::string is_duration(const std::string& text) {
  double seconds = 0;
  if (CLI::detail::lexical_cast(text, seconds) && std::isfinite(seconds) && seconds > 0) return "";
  return in_quotes(text) + " is not a duration: expected a positive number of seconds";
}

void add_run_and_check(CLI::App& app, Arguments& arguments) {
  CLI::App* run = app.add_subcommand("run", "Simulate a case");
  add_case_arguments(*run, arguments);
  run->add_option("-o,--output", arguments.command.directory, "Folder of the trajectory")
      ->check(is_name)
      ->capture_default_str();
  CLI::Option* force =
      run->add_flag("--force", arguments.command.force, "Overwrite an existing trajectory");
  run->add_flag("--resume", arguments.command.resume,
                "Go on from the last checkpoint of a run of this case that was stopped or killed; "
                "without a checkpoint, begin at t = 0")
      ->excludes(force);
  run->add_option("--extend", arguments.command.extend,
                  "Go on to this duration, beyond that of the run so far")
      ->type_name("SECONDS")
      ->check(is_duration)
      ->excludes(force);
  CLI::Option* restart =
      run->add_option("--restart-from", arguments.command.restart_from,
                      "Start the bodies in the state of another run, at the time of --time")
          ->type_name("TRAJECTORY")
          ->check(is_name);
  CLI::Option* time = run->add_option("--time", arguments.command.restart_time,
                                      "Time of a frame of that run, or of its last checkpoint")
                          ->type_name("SECONDS")
                          ->needs(restart);
  restart->needs(time);
  run->add_flag("--json", arguments.command.json, "Print the report as one JSON object");
  run->add_flag("--quiet", arguments.command.quiet,
                "No progress bar and no lines about choices; warnings stay");
  run->add_flag(
      "--estimate-error", arguments.command.estimate_error,
      "Measure the error by a second, more exact run, which takes four to eight times as many "
      "steps");
  run->callback([&] { arguments.code = run_case(arguments.command); });

  CLI::App* check =
      app.add_subcommand("check", "Say what a case needs and skips, without running it");
  add_case_arguments(*check, arguments);
  check
      ->add_option("--picture", arguments.check.picture,
                   "Draw the initial state to this PNG file, from above and from below, with "
                   "triangles that intersect in red")
      ->type_name("FILE")
      ->check(is_name);
  check
      ->add_option("--fix-initial", arguments.check.new_start,
                   "Separate cloth that intersects slightly, and write the shapes of the bodies "
                   "that moved to this new HDF5 file; the case stays as it is")
      ->type_name("FILE")
      ->check(is_name);
  check->add_flag("--force", arguments.command.force, "Overwrite an existing FILE");
  check->callback([&] {
    arguments.check.run = arguments.command;
    arguments.code = check_case(arguments.check);
  });
}

// Validates an option: returns an error message, or an empty text if the text is a finite number.
std::string is_load_factor(const std::string& text) {
  double factor = 0;
  if (CLI::detail::lexical_cast(text, factor) && std::isfinite(factor)) return "";
  return in_quotes(text) + " is not a load factor: expected a number";
}

// Adds a command that computes modes, with the options that `modes` and `buckling` share.
CLI::App* add_modes_command(CLI::App& app, const std::string& name, const std::string& purpose,
                            Arguments& arguments, int (*show)(const ModesCommand&)) {
  CLI::App* sub = app.add_subcommand(name, purpose);
  ModesCommand& modes = arguments.modes;
  add_case_arguments(*sub, arguments);
  sub->add_option("-n,--count", modes.count, "Number of modes")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  CLI::Option* output =
      sub->add_option("-o,--output", arguments.command.directory,
                      "Folder of a trajectory that shows the modes; without it, none is written")
          ->type_name("FOLDER")
          ->check(is_name);
  sub->add_option("--animate", modes.frames_per_mode,
                  "Frames of the trajectory per mode, over one period; without it, each mode has "
                  "one frame, its shape")
      ->type_name("FRAMES")
      ->check(CLI::Range(4, 1000))
      ->needs(output);
  sub->add_flag("--force", arguments.command.force, "Overwrite an existing trajectory");
  sub->add_flag("--json", arguments.command.json, "Print one JSON object");
  sub->add_flag("--quiet", arguments.command.quiet, "No progress bar");
  sub->callback([&arguments, output, show] {
    arguments.modes.run = arguments.command;
    arguments.modes.writes = output->count() > 0;
    arguments.code = show(arguments.modes);
  });
  return sub;
}

void add_modes_and_buckling(CLI::App& app, Arguments& arguments) {
  CLI::App* modes = add_modes_command(
      app, "modes", "Natural frequencies and shapes about the equilibrium of a case", arguments,
      show_modes);
  modes->add_flag("--start-shape", arguments.modes.start_shape,
                  "Take the start shape as it is, without a search for the equilibrium");
  CLI::App* buckling =
      add_modes_command(app, "buckling", "Load factors at which a case buckles, and shapes",
                        arguments, show_buckling);
  buckling
      ->add_option("--load-factor", arguments.modes.load_factor,
                   "Load factor of the equilibrium from which critical ones are sought")
      ->check(is_load_factor)
      ->capture_default_str();
}

// Validates an option: returns an error message, or an empty text if the text is a number from
// 0.001 to 1000. Unlike CLI::Range it refuses NaN.
std::string in_pixels(const std::string& text) {
  double pixels = 0;
  if (CLI::detail::lexical_cast(text, pixels) && pixels >= 1e-3 && pixels <= 1e3) return "";
  return in_quotes(text) + " is not a number of pixels from 0.001 to 1000";
}

// Reads "MIN,MAX". Throws CLI::ValidationError unless both are finite numbers and MIN < MAX.
std::array<double, 2> range_of(const std::string& text) {
  const std::size_t comma = text.find(',');
  std::array<double, 2> range{};
  const bool is_range = comma != std::string::npos &&
                        CLI::detail::lexical_cast(text.substr(0, comma), range[0]) &&
                        CLI::detail::lexical_cast(text.substr(comma + 1), range[1]) &&
                        std::isfinite(range[0]) && std::isfinite(range[1]) && range[0] < range[1];
  if (is_range) return range;
  throw CLI::ValidationError("--colour-range", in_quotes(text) +
                                                   " is not a range: expected MIN,MAX, two "
                                                   "numbers, the first one smaller");
}

void add_info_and_render(CLI::App& app, Arguments& arguments) {
  CLI::App* info = app.add_subcommand("info", "Summarise a trajectory");
  CLI::Option* trajectory =
      info->add_option("trajectory", arguments.trajectory, "HDF5 file of a run");
  CLI::Option* crossings =
      info->add_flag("--crossings", arguments.crossings,
                     "Count the triangles that pass through each other, frame by frame, exactly");
  info->add_flag("--materials", arguments.materials,
                 "List the presets of materials, with their values and sources")
      ->excludes(trajectory)
      ->excludes(crossings);
  info->add_flag("--json", arguments.json, "Print one JSON object");
  info->callback([&] {
    if (arguments.materials) {
      std::cout << (arguments.json ? material_presets_json() : material_presets_text());
      return;
    }
    if (arguments.trajectory.empty()) throw CLI::RequiredError("trajectory");
    arguments.code =
        run_guarded({.path = arguments.trajectory,
                     .json = arguments.json,
                     .is_long = arguments.crossings,
                     .run = [&] {
                       return show_info(arguments.trajectory, arguments.crossings, arguments.json);
                     }});
  });

  CLI::App* pictures = app.add_subcommand("render", "Draw the frames of a trajectory");
  RenderOptions& drawing = arguments.drawing;
  pictures->add_option("trajectory", arguments.trajectory, "HDF5 file of a run")->required();
  pictures->add_option("-o,--output", arguments.pictures, "Folder of the pictures")
      ->check(is_name)
      ->capture_default_str();
  pictures->add_option("--every", drawing.every, "Draw every Nth frame")
      ->check(CLI::Range(1, std::numeric_limits<int>::max()))
      ->capture_default_str();
  pictures
      ->add_option("--width", drawing.width,
                   "Width of the pictures, pixels (with --colour at least 240)")
      ->check(CLI::Range(1, 8192))
      ->capture_default_str();
  pictures
      ->add_option("--height", drawing.height,
                   "Height of the pictures, pixels (with --colour at least 180)")
      ->check(CLI::Range(1, 8192))
      ->capture_default_str();
  pictures
      ->add_option("--lod", drawing.detail_pixels,
                   "Draw fewer triangles, with every point within this many pixels of its place, "
                   "and no grid lines; 0.5 is hard to see")
      ->type_name("PIXELS")
      ->check(in_pixels);
  CLI::Option* field =
      pictures
          ->add_option("--colour", drawing.colour_field,
                       "Paint the bodies by this recorded field, vectors by their magnitude, with "
                       "a legend; weft info lists the fields")
          ->type_name("FIELD");
  pictures
      ->add_option_function<std::string>(
          "--colour-range", [&](const std::string& text) { drawing.colour_range = range_of(text); },
          "Numbers at the ends of the colours; default: the extremes of all pictures")
      ->type_name("MIN,MAX")
      ->needs(field);
  const auto whole = CLI::Range(0, 20);
  CLI::Option* surface =
      pictures
          ->add_option(
              "--level", drawing.surface_of_level,
              "Draw the surface of this level of the bounding sphere image, 0 the coarsest")
          ->type_name("LEVEL")
          ->check(whole)
          ->excludes("--lod");
  pictures
      ->add_option("--bsi", drawing.spheres_of_level,
                   "Draw the spheres of this level of the bounding sphere image, those that touch "
                   "another body's in red")
      ->type_name("LEVEL")
      ->check(whole)
      ->excludes("--lod")
      ->excludes(surface)
      ->excludes(field);
  pictures->add_flag("--force", drawing.force,
                     "Overwrite pictures and a movie that weft render did not make");
  pictures->callback([&] {
    arguments.code =
        run_guarded({.path = arguments.trajectory, .draws = true, .is_long = true, .run = [&] {
                       return render(arguments.trajectory, arguments.pictures, drawing);
                     }});
  });
}

void add_outputs(CLI::App& app, Arguments& arguments) {
  CLI::App* outputs = app.add_subcommand(
      "outputs",
      "Compute numbers from a trajectory: the [outputs] of its case, or expressions given here. "
      "docs/guide.md lists what they may use");
  outputs->add_option("trajectory", arguments.trajectory, "HDF5 file of a run")->required();
  outputs
      ->add_option("expressions", arguments.outputs,
                   "Outputs in place of those of the case, for example 'stretch = "
                   "max(largest_stretch)'")
      ->type_name("NAME=EXPRESSION");
  outputs->add_flag("--json", arguments.json, "Print one JSON object");
  outputs->callback([&] {
    arguments.code = run_guarded(
        {.path = arguments.trajectory, .json = arguments.json, .is_long = true, .run = [&] {
           return show_outputs(arguments.trajectory, arguments.outputs, arguments.json);
         }});
  });
}

void add_schema(CLI::App& app, Arguments& arguments) {
  CLI::App* schema =
      app.add_subcommand("schema", "Print the JSON schema of case files or sweep files");
  schema->add_flag("--markdown", arguments.markdown, "Print the reference page instead");
  schema->add_flag("--sweep", arguments.sweep_schema, "Describe sweep files instead");
  schema->callback([&] {
    if (arguments.sweep_schema) {
      std::cout << (arguments.markdown ? sweep_reference_markdown() : sweep_json_schema());
    } else {
      std::cout << (arguments.markdown ? case_reference_markdown() : case_json_schema());
    }
  });
}

void add_bench(CLI::App& app, Arguments& arguments) {
  CLI::App* bench = app.add_subcommand("bench", "Experiments on speed: see weft bench --help");
  bench->set_help_flag();  // weft-bench prints its own help
  bench->prefix_command();
  bench->callback([&arguments, bench] { arguments.code = run_bench(bench->remaining()); });
}

// Returns the innermost subcommand that was chosen, such as `estimate` of `weft sweep estimate`, or
// the application itself.
const CLI::App& chosen_command(const CLI::App& app) {
  const std::vector<CLI::App*> chosen = app.get_subcommands();
  return chosen.empty() ? app : chosen_command(*chosen.front());
}

// Returns a message about the first argument that no command or option accepts, with a hint if
// there is one, such as `did you mean "--force"?`. Returns an empty text if there is no such
// argument.
std::string hint_for_unknown(const CLI::App& app) {
  const std::vector<std::string> unknown = app.remaining(true);
  if (unknown.empty()) return "";
  const CLI::App& command = chosen_command(app);
  std::vector<std::string> names;
  if (unknown[0].starts_with("-")) {
    for (const CLI::Option* option : command.get_options()) {
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
  } else if (&command == &app) {
    for (const CLI::App* each : app.get_subcommands(nullptr)) names.push_back(each->get_name());
  }
  const std::string name = unknown[0].substr(0, unknown[0].find('='));
  const bool is_override = name != unknown[0] && !name.starts_with("-");
  if (is_override && command.get_option_no_throw("--set") != nullptr)
    return in_quotes(unknown[0]) + " is unknown; did you mean \"--set " + unknown[0] +
           "\"? Each override has a --set of its own";
  return in_quotes(name) + " is unknown" + (names.empty() ? "" : "; " + name_hint(name, names));
}

int refuse_arguments(const CLI::App& app, const CLI::ParseError& error,
                     std::span<const char* const> arguments) {
  if (arguments.size() == 1) {
    std::cerr << app.help();
    return exit_code::bad_case;
  }
  const std::string hint = hint_for_unknown(app);
  const std::string reason = hint.empty() ? error.what() : hint;
  complain("weft: " + reason);
  const auto is_json = [](const char* argument) { return std::string_view(argument) == "--json"; };
  if (std::ranges::any_of(arguments, is_json)) {
    std::cout << refusal_json(exit_code::bad_case, reason) << '\n';
  }
  std::string command = "weft ";
  for (const CLI::App* each = &app; !each->get_subcommands().empty();) {
    each = each->get_subcommands().front();
    command += each->get_name() + ' ';
  }
  std::cerr << "See " << command << "--help\n";
  return exit_code::bad_case;
}

}  // namespace

int main(int argc, char** argv) {
  shorten_waiting(argv);
  // A file that outgrows the limit of the shell fails to be written, as on a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
  CLI::App app{description};
  app.set_version_flag("--version", "weft " WEFT_VERSION);
  app.require_subcommand(1);
  Arguments arguments;
  add_run_and_check(app, arguments);
  add_modes_and_buckling(app, arguments);
  add_info_and_render(app, arguments);
  add_outputs(app, arguments);
  add_sweep(app, arguments.sweep, arguments.code);
  add_schema(app, arguments);
  add_bench(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {
    app.exit(asked);  // prints the help or the version
  } catch (const CLI::ParseError& error) {
    return refuse_arguments(app, error, {argv, static_cast<std::size_t>(argc)});
  } catch (const std::bad_alloc&) {
    complain("weft: needs more memory than there is");
    return exit_code::input_output;
  }
  return deliver(arguments.code);
}
