#include "sim/sweep/sweep_plan.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <limits>
#include <optional>

#include "sim/case/case_error.h"
#include "sim/case/case_include.h"
#include "sim/case/case_override.h"
#include "sim/case/case_text.h"
#include "sim/case/case_tree.h"
#include "sim/case/case_writer.h"
#include "sim/case/memory_estimate.h"
#include "sim/case/time_methods.h"
#include "sim/sweep/run_identity.h"
#include "sim/sweep/sample_points.h"
#include "sim/sweep/sweep_keys.h"
#include "sim/sweep/sweep_reader.h"
#include "sim/sweep/sweep_rules.h"
#include "sim/sweep/sweep_values.h"

namespace weft::sim {

namespace {

constexpr double most_runs = 1e6;
// Largest number of values of factors in all runs. They take up to three gigabytes.
constexpr double most_values = 2e7;

// Values of one column of the plan: a list, or numbers from a distribution.
struct Column {
  std::string key;
  SourceLocation key_place;
  std::vector<TomlValue> list;  // empty: samples
  const FactorCase* factor = nullptr;
  bool is_whole = false;

  // Returns the value of a unit coordinate.
  TomlValue sample(double coordinate) const {
    if (!list.empty())
      return list[static_cast<std::size_t>(coordinate * static_cast<double>(list.size()))];
    const bool is_log = factor->uniform.empty();
    const std::vector<double>& ends = is_log ? factor->log_uniform : factor->uniform;
    const double value =
        is_whole ? (is_log ? log_uniform_whole : uniform_whole)(ends[0], ends[1], coordinate)
                 : (is_log ? log_uniform_value : uniform_value)(ends[0], ends[1], coordinate);
    return {number(value), false, factor->numbers_location};
  }
  std::string number(double value) const {
    constexpr double first_beyond = 0x1p63;  // which no whole number in TOML reaches
    const bool is_written_whole = is_whole && std::abs(value) < first_beyond;
    return is_written_whole ? std::to_string(std::llround(value)) : toml_number(value);
  }
};

CaseOverride override_of(const std::string& key, const SourceLocation& key_place,
                         const TomlValue& value) {
  return {key, value.text, true, key_place, value.where};
}

// Returns PlannedRun::work of a case.
double work_of(const Case& source) {
  double vertices = 0;
  for (const double each : size_of_case(source).body) vertices += std::max(1.0, each);
  return std::min(vertices * source.time.duration, std::numeric_limits<double>::max());
}

// The values of one run, one per column.
using Combination = std::vector<TomlValue>;

class Planner {
 public:
  Planner(const SweepCase& sweep, const std::vector<std::string>& overrides) : sweep_(sweep) {
    base_path_ = (std::filesystem::path(sweep.path).parent_path() / sweep.base).string();
    const FileText base = read_text(base_path_);
    if (!base.fault.empty()) {
      throw CaseError(sweep.base_location, in_quotes(sweep.base) + ' ' + base.fault,
                      "expected a case file, here " + base_path_);
    }
    base_ = base.text;
    add_fixed(overrides);
    keys_.emplace(fixed_keys());
    for (const FactorCase& factor : sweep.factors) add_column(factor);
    if (!sweep.run.empty()) add_listed_columns();
    check_repeat_key();
  }

  SweepPlan plan() {
    plan_.sweep = std::filesystem::absolute(sweep_.path).lexically_normal().string();
    plan_.limits = sweep_.limits;
    plan_.estimate_error = sweep_.estimate_error;
    plan_.sweep_outputs = sweep_.outputs;
    for (const Column& column : columns_) plan_.factors.push_back(column.key);
    const bool repeats = sweep_.sample.repeats > 1;
    if (repeats) plan_.factors.push_back(sweep_.sample.repeat_key);
    const SweepRules rules(sweep_, rule_factors());
    for (const Combination& combination : combinations()) {
      if (!rules.keep(texts_of(combination))) {
        ++plan_.left_out;
        continue;
      }
      for (int repeat = 1; repeat <= sweep_.sample.repeats; ++repeat) {
        add_run(combination, repeats ? std::optional(repeat) : std::nullopt);
      }
    }
    refuse_empty_plan();
    plan_.digests = hasher_.digests();
    return std::move(plan_);
  }

  std::vector<std::string> files() const {
    std::vector<std::string> all = included_;
    all.insert(all.end(), {sweep_.path, base_path_});
    return all;
  }

 private:
  void add_fixed(const std::vector<std::string>& overrides) {
    for (const KeyedValue& each : sweep_.set)
      fixed_.push_back(override_of(each.key, each.key_place, each.value));
    for (const std::string& text : overrides) {
      CaseOverride each = override_of_option(text);
      const bool varies =
          std::ranges::find(sweep_.factors, each.key, &FactorCase::key) != sweep_.factors.end() ||
          (!sweep_.run.empty() &&
           std::ranges::find(sweep_.run.front().set, each.key, &KeyedValue::key) !=
               sweep_.run.front().set.end()) ||
          each.key == sweep_.sample.repeat_key;
      if (varies) {
        throw CaseError(each.key_place, in_quotes(each.key) + " varies in this sweep",
                        "expected a key that is no factor");
      }
      fixed_.push_back(std::move(each));
    }
    if (fixed_.empty()) return;
    // Values that need each other, such as the path and the time of [restart], are given together.
    try {
      check_last_override(base_, base_path_, fixed_);
    } catch (const CaseError&) {
      for (std::size_t i = 1; i <= fixed_.size(); ++i)
        check_last_override(base_, base_path_, std::span(fixed_).first(i));
    }
  }

  // Returns the keys of the fixed values. Notes which files the base case includes.
  SweepKeys fixed_keys() {
    toml::table tree = parse_toml(base_, base_path_);
    for (const CaseOverride& each : fixed_) {
      if (each.key == "include" || each.key.starts_with("include.")) apply_override(tree, each);
    }
    included_ = merge_includes(tree, base_path_);
    return {std::move(tree), fixed_, sweep_.set.size()};
  }

  // Throws CaseError at a value that the case refuses. Returns true if the key takes whole numbers
  // only.
  bool check_value(const std::string& key, const SourceLocation& key_place,
                   const TomlValue& value) const {
    std::vector<CaseOverride> all = fixed_;
    all.push_back(override_of(key, key_place, value));
    return check_last_override(base_, base_path_, all);
  }

  void add_column(const FactorCase& factor) {
    keys_->add_varying(factor.key, factor.key_location);
    Column column{factor.key, factor.key_location, factor.list, &factor};
    for (const TomlValue& value : factor.list)
      column.is_whole = check_value(factor.key, factor.key_location, value);
    for (const auto* ends : {&factor.range, &factor.uniform, &factor.log_uniform}) {
      if (!ends->empty()) check_ends(column, (*ends)[0], (*ends)[1]);
    }
    if (!factor.range.empty()) fill_range(column);
    columns_.push_back(std::move(column));
  }

  // Checks the ends of a range or a distribution as values of the key.
  void check_ends(Column& column, double first, double last) const {
    const FactorCase& factor = *column.factor;
    const bool are_whole = first == std::round(first) && last == std::round(last);
    column.is_whole = are_whole;  // a key of any numbers takes whole ones, too
    const TomlValue of_first{column.number(first), false, factor.numbers_location};
    const TomlValue of_last{column.number(last), false, factor.numbers_location};
    check_value(column.key, column.key_place, of_first);
    column.is_whole = check_value(column.key, column.key_place, of_last);
  }

  static void fill_range(Column& column) {
    const FactorCase& factor = *column.factor;
    for (int i = 0; i < factor.count; ++i) {
      const double value = range_value(factor.range[0], factor.range[1], factor.count, i);
      if (column.is_whole && value != std::round(value)) {
        throw CaseError(
            factor.numbers_location,
            in_quotes(column.key) + " takes whole numbers, and the range has " + number_text(value),
            "expected a \"count\" with a whole number between two values");
      }
      column.list.push_back({column.number(value), false, factor.numbers_location});
    }
    refuse_equal_values(column);
  }

  // Throws CaseError for a range of fewer numbers than values.
  static void refuse_equal_values(const Column& column) {
    const FactorCase& factor = *column.factor;
    const auto same = [](const TomlValue& a, const TomlValue& b) { return a.text == b.text; };
    const bool is_point = factor.range[0] == factor.range[1];
    if (is_point || std::ranges::adjacent_find(column.list, same) == column.list.end()) return;
    throw CaseError(factor.numbers_location,
                    in_quotes(column.key) + " has a range of fewer numbers than " +
                        counted(factor.count, "value", "values"),
                    "expected a smaller \"count\", or ends farther apart");
  }

  void add_listed_columns() {
    for (const KeyedValue& each : sweep_.run.front().set) {
      keys_->add_varying(each.key, each.key_place);
      Column column{each.key, each.key_place, {}};
      for (const ListedRun& run : sweep_.run) {
        const auto found = std::ranges::find(run.set, each.key, &KeyedValue::key);
        check_value(found->key, found->key_place, found->value);
        column.list.push_back(found->value);
      }
      columns_.push_back(std::move(column));
    }
  }

  void check_repeat_key() {
    const SampleCase& sample = sweep_.sample;
    if (sample.repeat_key.empty()) return;
    keys_->add_varying(sample.repeat_key, sweep_.repeat_key_location);
    check_value(sample.repeat_key, sweep_.repeat_key_location,
                {std::to_string(sample.repeats), false, sweep_.repeat_key_location});
  }

  std::vector<RuleFactor> rule_factors() const {
    std::vector<RuleFactor> factors;
    for (const Column& column : columns_) {
      factors.push_back({column.key, !column.list.empty() &&
                                         std::ranges::all_of(column.list, &TomlValue::is_string)});
    }
    return factors;
  }

  static std::vector<std::string> texts_of(const Combination& combination) {
    std::vector<std::string> texts;
    for (const TomlValue& value : combination) texts.push_back(value.text);
    return texts;
  }

  std::vector<Combination> combinations() const {
    switch (sweep_.sample.method) {
      case SampleMethod::grid:
        return grid();
      case SampleMethod::zip:
      case SampleMethod::list:
        return rows();
      default:
        return samples();
    }
  }

  // Returns all combinations. The last column changes first.
  std::vector<Combination> grid() const {
    double count = sweep_.sample.repeats;
    for (const Column& column : columns_) count *= static_cast<double>(column.list.size());
    refuse_too_many(count);
    std::vector<Combination> all{{}};
    for (const Column& column : columns_) {
      std::vector<Combination> longer;
      for (const Combination& each : all) {
        for (const TomlValue& value : column.list) {
          longer.push_back(each);
          longer.back().push_back(value);
        }
      }
      all = std::move(longer);
    }
    return all;
  }

  std::vector<Combination> rows() const {
    std::vector<Combination> all(columns_.front().list.size());
    refuse_too_many(static_cast<double>(all.size()) * sweep_.sample.repeats);
    for (std::size_t i = 0; i < all.size(); ++i) {
      for (const Column& column : columns_) all[i].push_back(column.list[i]);
    }
    return all;
  }

  std::vector<Combination> samples() const {
    const auto count = static_cast<std::size_t>(sweep_.sample.runs);
    refuse_too_many(static_cast<double>(count) * sweep_.sample.repeats);
    const auto seed = static_cast<std::uint64_t>(sweep_.sample.seed);
    const SampleMethod method = sweep_.sample.method;
    const auto points = method == SampleMethod::random            ? random_points
                        : method == SampleMethod::latin_hypercube ? latin_hypercube_points
                                                                  : sobol_points;
    std::vector<Combination> all;
    for (const UnitPoint& point : points(count, columns_.size(), seed)) {
      Combination& combination = all.emplace_back();
      for (std::size_t i = 0; i < columns_.size(); ++i)
        combination.push_back(columns_[i].sample(point[i]));
    }
    return all;
  }

  void refuse_too_many(double count) const {
    if (count > most_runs) {
      throw CaseError(sweep_.factors_location, "the sweep has " + rounded_text(count) + " runs",
                      "expected at most " + rounded_text(most_runs));
    }
    const double values = count * static_cast<double>(columns_.size());
    if (values <= most_values) return;
    throw CaseError(sweep_.factors_location,
                    "the runs of the sweep have " + rounded_text(values) + " values of factors",
                    "expected at most " + rounded_text(most_values) + ": fewer runs or factors");
  }

  void add_run(const Combination& combination, std::optional<int> repeat) {
    std::vector<CaseOverride> overrides = fixed_;
    PlannedRun& run = plan_.runs.emplace_back();
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      overrides.push_back(override_of(columns_[i].key, columns_[i].key_place, combination[i]));
      run.values.push_back(combination[i].text);
    }
    if (repeat) {
      const SourceLocation& place = sweep_.repeat_key_location;
      const TomlValue value{std::to_string(*repeat), false, place};
      overrides.push_back(override_of(sweep_.sample.repeat_key, place, value));
      run.values.push_back(value.text);
    }
    try {
      const Case source = parse_case(base_, base_path_, overrides);
      if (sweep_.estimate_error) refuse_error_of_equilibrium(source);
      if (plan_.case_outputs.empty()) plan_.case_outputs = source.outputs;
      run.hash = hasher_.hash(source, sweep_.estimate_error);
      run.inputs = input_paths(source);
      run.case_text = portable_case_text(without_replaced_outputs(source));
      run.work = work_of(source);
    } catch (const CaseError& error) {
      if (!first_refusal_) first_refusal_ = std::current_exception();
      run.refusal = error.what();
      run.hash = hash_of_refused(overrides);
    }
  }

  // Returns the case without the outputs that the sweep replaces, which a run need not be able to
  // compute.
  Case without_replaced_outputs(const Case& source) const {
    Case result = source;
    std::erase_if(result.outputs, [&](const OutputExpression& each) {
      return std::ranges::find(sweep_.outputs, each.name, &OutputExpression::name) !=
             sweep_.outputs.end();
    });
    if (result.outputs.size() < source.outputs.size()) result.resolved_text = case_text(result);
    return result;
  }

  void refuse_error_of_equilibrium(const Case& source) const {
    if (!traits_of(source.time.method).finds_equilibria()) return;
    throw CaseError(sweep_.estimate_location, "time.method = \"static\" has no error of time steps",
                    "expected another time.method, or estimate_error = false");
  }

  std::string hash_of_refused(const std::vector<CaseOverride>& overrides) const {
    std::string inputs = "refused\n" + base_;
    for (const CaseOverride& each : overrides) inputs += each.key + '=' + each.value + '\n';
    return sha256(inputs);
  }

  void refuse_empty_plan() const {
    const std::vector<PlannedRun>& runs = plan_.runs;
    if (runs.empty()) {
      throw CaseError(sweep_.method_location, "the rules leave no run",
                      "expected a combination for which all of \"include\" and none of "
                      "\"exclude\" hold");
    }
    const bool some_run = std::ranges::any_of(runs, &std::string::empty, &PlannedRun::refusal);
    if (!some_run) std::rethrow_exception(first_refusal_);
  }

  const SweepCase& sweep_;
  std::string base_path_, base_;
  std::vector<std::string> included_;  // paths of files that the base case includes
  std::vector<CaseOverride> fixed_;    // overrides of all runs
  std::optional<SweepKeys> keys_;      // with values in this sweep
  std::vector<Column> columns_;
  RunHasher hasher_;
  SweepPlan plan_;
  std::exception_ptr first_refusal_;
};

}  // namespace

SweepPlan plan_sweep(const SweepCase& sweep, const std::vector<std::string>& overrides) {
  return Planner(sweep, overrides).plan();
}

std::vector<std::string> files_of_sweep(const SweepCase& sweep,
                                        const std::vector<std::string>& overrides) {
  return Planner(sweep, overrides).files();
}

}  // namespace weft::sim
