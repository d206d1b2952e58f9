#include "bench/case_check.h"

#include <cmath>
#include <fstream>
#include <stdexcept>

#include "bench/medians.h"
#include "sim/run/make_simulation.h"

namespace weft::bench {

namespace {

std::string list_of(const std::vector<int>& numbers) {
  std::string text;
  for (const int each : numbers) text += (text.empty() ? "" : ", ") + std::to_string(each);
  return text;
}

// Keeps the worst of the quantities measured.
void keep_worst(const std::vector<Measured>& measured, CheckRow& row) {
  for (const Measured& each : measured) {
    const double error = std::abs(each.value - each.reference.value) / each.scale;
    if (!row.quantity.empty() && error <= row.error()) continue;
    row.quantity = each.quantity;
    row.value = each.value;
    row.reference = each.reference.value;
    row.scale = each.scale;
    row.source = each.reference.source;
  }
}

void measure_frames(const CaseCheck& check, const sim::Case& source, CheckRow& row) {
  sim::Simulation simulation = sim::make_simulation(source);
  const std::string& body = source.body.at(0).name;
  const std::vector<sim::Vec3> start = simulation.position(body);
  const int frames =
      static_cast<int>(std::lround(source.time.duration * source.time.frames_per_second));
  for (int frame = 0; frame <= frames; ++frame) {
    advance_to(simulation, frame / source.time.frames_per_second);
    const FramedBody framed(start, simulation.position(body), row.resolution.at(1));
    keep_worst(check.measure(framed, frame), row);
  }
}

}  // namespace

ReferenceFigure reference_figure(const std::string& name) {
  const std::string path = WEFT_SOURCE_DIR "/tests/reference/closed_forms.csv";
  std::ifstream file(path);
  std::string source;
  for (std::string line; std::getline(file, line);) {
    const std::size_t first = line.find(','), second = line.find(',', first + 1);
    if (second == std::string::npos) continue;
    std::string text = line.substr(second + 1);
    // "the same" stands for the source of the line before.
    source = text.starts_with("the same") ? source : std::move(text);
    if (line.compare(0, first, name) == 0)
      return {std::stod(line.substr(first + 1, second - first - 1)), source};
  }
  throw std::runtime_error(path + " has no " + name);
}

Measured relative(std::string quantity, double value, ReferenceFigure reference) {
  const double scale = std::abs(reference.value);
  return {std::move(quantity), value, std::move(reference), scale};
}
Measured by_name(std::string quantity, double value, const std::string& name) {
  return relative(std::move(quantity), value, reference_figure(name));
}

std::vector<CheckedImage> strips(const std::vector<std::pair<int, double>>& columns) {
  std::vector<CheckedImage> images;
  for (const auto& [count, limit] : columns) images.push_back({{4, count}, limit});
  return images;
}
std::vector<CheckedImage> squares(const std::vector<std::pair<int, double>>& sides) {
  std::vector<CheckedImage> images;
  for (const auto& [side, limit] : sides) images.push_back({{side, side}, limit});
  return images;
}

std::string benchmark_path(const std::string& case_name) {
  return std::string(WEFT_CASES_DIR) + "/benchmarks/" + case_name + ".toml";
}

sim::Case case_of(const CaseCheck& check, const CheckedImage& image) {
  std::vector<std::string> overrides = check.overrides;
  overrides.push_back("body.0.shape.resolution=[" + list_of(image.resolution) + ']');
  return sim::read_case(benchmark_path(check.case_name), overrides);
}

void advance_to(sim::Simulation& simulation, double time) {
  if (time <= simulation.time()) return;
  if (const auto failure = simulation.advance(time - simulation.time()))
    throw std::runtime_error(failure->text);
}

CheckRow run_check(const CaseCheck& check, const CheckedImage& image) {
  CheckRow row{.check = check.name,
               .case_path = "cases/benchmarks/" + check.case_name + ".toml",
               .resolution = image.resolution,
               .points = image.resolution.at(0) * image.resolution.at(1),
               .bound = check.bound == Bound::error && image.limit == 0 ? Bound::none : check.bound,
               .limit = image.limit};
  row.cpu_s = cpu_time_of([&] {
    try {
      const sim::Case source = case_of(check, image);
      check.measure_case ? keep_worst(check.measure_case(source), row)
                         : measure_frames(check, source, row);
    } catch (const std::runtime_error& error) {
      row.failure = error.what();
    }
  });
  return row;
}

}  // namespace weft::bench
