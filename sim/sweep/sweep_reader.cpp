#include "sim/sweep/sweep_reader.h"

#include <algorithm>
#include <tuple>

#include "sim/case/case_error.h"
#include "sim/case/case_locations.h"
#include "sim/case/case_table_reader.h"
#include "sim/case/case_text.h"
#include "sim/case/case_tree.h"
#include "sim/case/located_text.h"
#include "sim/sweep/sample_points.h"

namespace weft::sim {

namespace {

auto order_of(const SourceLocation& place) { return std::tuple(place.line, place.column); }

// Sets the places of a factor's key and numbers, which its description does not hold.
void note_places(FactorCase& factor, const Locations& locations) {
  const std::string path = join_path("factors", factor.key);
  factor.key_location = locations.key(path);
  for (const char* name : {"range", "uniform", "log_uniform"}) {
    const std::string numbers = join_path(path, name);
    if (locations.given(numbers)) factor.numbers_location = locations.value(numbers);
  }
}

void check_order(const FactorCase& factor) {
  for (const std::vector<double>* ends : {&factor.uniform, &factor.log_uniform}) {
    if (ends->empty() || (*ends)[0] < (*ends)[1]) continue;
    throw CaseError(factor.numbers_location,
                    in_quotes(factor.key) + " has samples from " + number_text((*ends)[0]) +
                        " to " + number_text((*ends)[1]),
                    "expected the least value before the largest one");
  }
}

void check_count(const FactorCase& factor, const Locations& locations) {
  const std::string path = join_path("factors", factor.key);
  if (!factor.range.empty() && factor.count == 0) {
    throw CaseError(factor.numbers_location,
                    in_quotes(factor.key) + " has a range without \"count\"",
                    "expected \"count\", the number of values");
  }
  if (factor.range.empty() && factor.count > 0) {
    throw CaseError(locations.key(join_path(path, "count")), "\"count\" does not belong here",
                    "expected only with \"range\"");
  }
}

void check_factor(const FactorCase& factor, const SweepCase& sweep, const Locations& locations) {
  if (factor.list.empty() && factor.range.empty() && factor.uniform.empty() &&
      factor.log_uniform.empty()) {
    throw CaseError(factor.location, in_quotes(factor.key) + " has no values",
                    "expected one of \"list\", \"range\", \"uniform\", \"log_uniform\"");
  }
  check_count(factor, locations);
  check_order(factor);
  const bool is_distribution = !factor.uniform.empty() || !factor.log_uniform.empty();
  if (is_distribution && !is_sampled(sweep.sample.method)) {
    throw CaseError(
        locations.key(join_path(join_path("factors", factor.key),
                                factor.uniform.empty() ? "log_uniform" : "uniform")),
        in_quotes(factor.key) + " has samples, which this sample.method does not take",
        "expected \"list\" or \"range\", or a sample.method of \"random\", \"latin_hypercube\" or "
        "\"sobol\"");
  }
}

// Throws CaseError at a key that comes a second time among the factors and the overrides.
void refuse_key_twice(const SweepCase& sweep) {
  std::vector<std::string> keys;
  for (const FactorCase& factor : sweep.factors) keys.push_back(factor.key);
  if (!sweep.run.empty()) {
    for (const KeyedValue& each : sweep.run.front().set) keys.push_back(each.key);
  }
  for (const KeyedValue& each : sweep.set) {
    if (std::ranges::find(keys, each.key) == keys.end()) continue;
    throw CaseError(each.key_place, in_quotes(each.key) + " varies in this sweep",
                    "expected it either in [set] or as a factor");
  }
  keys.reserve(keys.size() + sweep.set.size());
  for (const KeyedValue& each : sweep.set) keys.push_back(each.key);
  const SampleCase& sample = sweep.sample;
  if (std::ranges::find(keys, sample.repeat_key) != keys.end()) {
    throw CaseError(sweep.repeat_key_location,
                    in_quotes(sample.repeat_key) + " has values of its own in this sweep",
                    "expected a key that neither [set] nor a factor sets");
  }
}

void check_listed_runs(const SweepCase& sweep, const Locations& locations) {
  const bool is_list = sweep.sample.method == SampleMethod::list;
  if (is_list && sweep.run.empty()) {
    throw CaseError(sweep.method_location, "sample.method = \"list\" without runs",
                    "expected tables [[run]] with a key \"set\"");
  }
  if (!is_list && !sweep.run.empty()) {
    throw CaseError(locations.key("run"), "[[run]] does not belong to this sample.method",
                    "expected only with sample.method = \"list\"");
  }
  if (is_list && !sweep.factors.empty()) {
    throw CaseError(locations.key("factors"), "[factors] do not belong to sample.method = \"list\"",
                    "expected all values in the tables [[run]]");
  }
  for (const ListedRun& run : sweep.run) {
    const auto same_key = [](const KeyedValue& a, const KeyedValue& b) { return a.key == b.key; };
    std::vector<KeyedValue> first = sweep.run.front().set, these = run.set;
    std::ranges::sort(first, {}, &KeyedValue::key);
    std::ranges::sort(these, {}, &KeyedValue::key);
    if (std::ranges::equal(first, these, same_key)) continue;
    std::vector<std::string> names;
    for (const KeyedValue& each : sweep.run.front().set) names.push_back(each.key);
    throw CaseError(run.location, "this [[run]] has other keys than the first one",
                    "expected " + quoted_list(names));
  }
}

void check_zip(const SweepCase& sweep) {
  if (sweep.sample.method != SampleMethod::zip) return;
  const auto size = [](const FactorCase& factor) {
    return factor.range.empty() ? factor.list.size() : static_cast<std::size_t>(factor.count);
  };
  const FactorCase& first = sweep.factors.front();
  for (const FactorCase& factor : sweep.factors) {
    if (size(factor) == size(first)) continue;
    throw CaseError(factor.key_location,
                    in_quotes(factor.key) + " has " + std::to_string(size(factor)) +
                        " values, and " + in_quotes(first.key) + " has " +
                        std::to_string(size(first)),
                    "expected as many values for each factor of sample.method = \"zip\"");
  }
}

void check_repeats(const SweepCase& sweep, const Locations& locations) {
  const SampleCase& sample = sweep.sample;
  if (sample.repeats > 1 && sample.repeat_key.empty()) {
    throw CaseError(locations.value("sample.repeats"), "the repeats would all be the same run",
                    "expected \"repeat_key\", a case key that gets the number of the repeat");
  }
  if (sample.repeats == 1 && !sample.repeat_key.empty()) {
    throw CaseError(sweep.repeat_key_location, "\"repeat_key\" without repeats",
                    "expected \"repeats\" of at least 2");
  }
}

void check_rules(const SweepCase& sweep) {
  for (const auto* rules : {&sweep.sample.include, &sweep.sample.exclude}) {
    for (const TomlValue& rule : *rules) {
      if (rule.is_string) continue;
      throw CaseError(rule.where, "the rule " + rule.text + " is not a string",
                      "expected an expression in quotes, such as \"contact.friction < 0.3\"");
    }
  }
}

void check_sweep(const SweepCase& sweep, const Locations& locations) {
  check_listed_runs(sweep, locations);
  if (sweep.factors.empty() && sweep.sample.method != SampleMethod::list) {
    throw CaseError({sweep.path, 1, 1}, "the sweep has no factors",
                    "expected [factors], with case keys in quotes");
  }
  for (const FactorCase& factor : sweep.factors) check_factor(factor, sweep, locations);
  if (sweep.sample.method == SampleMethod::sobol && sweep.factors.size() > most_sobol_dimensions) {
    throw CaseError(sweep.method_location,
                    std::to_string(sweep.factors.size()) + " factors are too many for \"sobol\"",
                    "expected at most " + std::to_string(most_sobol_dimensions));
  }
  check_zip(sweep);
  check_repeats(sweep, locations);
  refuse_key_twice(sweep);
  check_rules(sweep);
}

}  // namespace

bool is_sampled(SampleMethod method) {
  return method == SampleMethod::random || method == SampleMethod::latin_hypercube ||
         method == SampleMethod::sobol;
}

namespace {

// Reads the tables of a sweep file, and gives its outputs the places of their bytes.
SweepCase read_tables(const std::string& text, const std::string& path, Locations& locations) {
  const toml::table root = parse_toml(text, path);
  SweepCase sweep;
  sweep.path = path;
  sweep.text = text;
  read_table(root, describe(sweep), "", locations);
  for (OutputExpression& output : sweep.outputs)
    output.text = located_text(output.text.text, output.text.location, text);
  return sweep;
}

std::string text_of_sweep(const std::string& path) {
  FileText file = read_text(path);
  if (!file.fault.empty()) throw CaseError({path}, file.fault, "expected a sweep file");
  return std::move(file.text);
}

}  // namespace

SweepCase parse_sweep(const std::string& text, const std::string& path) {
  Locations locations(path);
  SweepCase sweep = read_tables(text, path, locations);
  std::ranges::sort(sweep.factors, {},
                    [](const FactorCase& factor) { return order_of(factor.location); });
  for (FactorCase& factor : sweep.factors) note_places(factor, locations);
  sweep.base_location = locations.value("case");
  sweep.factors_location = locations.key("factors");
  sweep.method_location = locations.value("sample.method");
  sweep.repeat_key_location = locations.value("sample.repeat_key");
  sweep.estimate_location = locations.value("estimate_error");
  check_sweep(sweep, locations);
  return sweep;
}

SweepCase read_sweep(const std::string& path) { return parse_sweep(text_of_sweep(path), path); }

std::vector<OutputExpression> read_sweep_outputs(const std::string& path) {
  Locations locations(path);
  return read_tables(text_of_sweep(path), path, locations).outputs;
}

std::string sweep_json_schema() {
  SweepCase prototype;
  return json_schema(describe(prototype), "Weft sweep",
                     "A sweep file of Weft: a case and the values of keys that vary.");
}

std::string sweep_reference_markdown() {
  SweepCase prototype;
  return "# Sweep file reference\n\n"
         "A sweep is a [TOML](https://toml.io) file that names a case and the values of keys that "
         "vary from run to run.\nThe [guide](guide.md#sweeps-many-runs-of-a-case) shows its use. "
         "Keys of the case are "
         "written as for `--set`, in quotes: `\"material.cotton.density\"`.\n" +
         reference_sections(describe(prototype));
}

}  // namespace weft::sim
