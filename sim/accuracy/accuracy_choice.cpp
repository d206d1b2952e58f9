#include "sim/accuracy/accuracy_choice.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

#include "sim/case/case_checks.h"
#include "sim/case/case_error.h"
#include "sim/case/case_text.h"
#include "sim/case/case_writer.h"
#include "sim/case/time_methods.h"

namespace weft::sim {

namespace {

// Returns the calibrated methods: those that time_methods() marks as calibrated, set by tolerance,
// and "linear-euler" (euler with one Newton iteration per step), set by step.
const std::vector<CalibratedMethod>& methods() {
  static const std::vector<CalibratedMethod> all = [] {
    std::vector<CalibratedMethod> found;
    for (const TimeMethodTraits& each : time_methods()) {
      if (each.is_calibrated) found.push_back({each.name, each.method, false});
    }
    found.push_back({"linear-euler", TimeMethod::euler, true});
    return found;
  }();
  return all;
}

constexpr CalibrationRow calibration_rows[] = {
#include "sim/accuracy/calibration_table.inc"
};

constexpr double promised_factor = 3;  // largest CalibrationRow::factor of a preferred option

struct Option {
  const CalibratedMethod* method = nullptr;
  double setting = 0;
  double factor = 0;
  double cost = 0;
  bool limited = false;  // true if contact or the table demand a finer setting than the accuracy
  // Returns true if this option is preferable to the other. If both options have at most the
  // promised factor, the cheaper option is preferable, else the option with the smaller factor.
  bool is_better_than(const Option& other) const {
    if (std::max(factor, other.factor) <= promised_factor) return cost < other.cost;
    return factor < other.factor;
  }
};

std::vector<CalibrationRow> rows_of(const CalibratedMethod& method, bool meetings) {
  std::vector<CalibrationRow> rows;
  for (const CalibrationRow& row : calibration_rows) {
    if (row.meetings == meetings && std::string(row.method) == method.name) rows.push_back(row);
  }
  return rows;
}

// Interpolates the setting for an error rate between two rows, on logarithmic scales. A tolerance
// is at most `limit` (m). For a rate above all rows, the result is the largest tolerance, but
// nothing if the setting is a step. For a rate below all rows, the result is nothing.
std::optional<Option> option_at(const CalibratedMethod& method,
                                const std::vector<CalibrationRow>& rows, double rate,
                                double limit) {
  const CalibrationRow& last = rows.back();
  if (rate > last.error_rate && !method.by_step)
    return Option{&method, std::min(last.setting, limit), last.factor, last.cost, true};
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const CalibrationRow &fine = rows[i - 1], &coarse = rows[i];
    if (rate < fine.error_rate || rate > coarse.error_rate) continue;
    const double part =
        std::log(rate / fine.error_rate) / std::log(coarse.error_rate / fine.error_rate);
    const double setting = fine.setting * std::pow(coarse.setting / fine.setting, part);
    const bool limited = !method.by_step && setting > limit;
    return Option{&method, limited ? limit : setting, std::max(fine.factor, coarse.factor),
                  fine.cost * std::pow(coarse.cost / fine.cost, part), limited};
  }
  return std::nullopt;
}

// Returns the column `to` as a function of the column `from` at from = value. Between two rows, it
// interpolates on logarithmic scales. Beyond the rows, it takes `to` as proportional to
// from^power. The error of a method of order 2 is proportional to tolerance^(2/3).
double interpolated(const std::vector<CalibrationRow>& rows, double value,
                    double CalibrationRow::*from, double CalibrationRow::*to, double power) {
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const CalibrationRow &fine = rows[i - 1], &coarse = rows[i];
    if (value < fine.*from || value > coarse.*from) continue;
    const double part = std::log(value / fine.*from) / std::log(coarse.*from / fine.*from);
    return fine.*to * std::pow(coarse.*to / fine.*to, part);
  }
  const CalibrationRow& end = value < rows.front().*from ? rows.front() : rows.back();
  return end.*to * std::pow(value / end.*from, power);
}

std::vector<CalibrationRow> rows_of(const Case& source) {
  for (const CalibratedMethod& method : methods()) {
    if (method.method == source.time.method && !method.by_step) {
      return rows_of(method, has_meetings(source));
    }
  }
  return {};
}

// Returns the method as a case names it.
std::string shown(const CalibratedMethod& method) {
  return method.by_step ? std::string(traits_of(method.method).name) + " with newton = 1"
                        : method.name;
}

std::string rounded(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

// The options (methods with settings) that the table has for an accuracy, best first.
class Offers {
 public:
  Offers(const Case& source, bool method_given) {
    const double rate = *source.time.accuracy / source.time.duration;
    for (const CalibratedMethod& method : methods()) {
      if (method_given && method.method != source.time.method) continue;
      const std::vector<CalibrationRow> rows = rows_of(method, has_meetings(source));
      if (rows.empty()) continue;
      const double duration = source.time.duration;
      ranges_ += (ranges_.empty() ? "" : " or ") + rounded(duration * rows.front().error_rate) +
                 " to " + rounded(duration * rows.back().error_rate) + " m (" + shown(method) + ")";
      const auto option = option_at(method, rows, rate, position_tolerance_limit(source));
      if (option) options_.push_back(*option);
    }
    std::ranges::sort(options_,
                      [](const Option& a, const Option& b) { return a.is_better_than(b); });
  }
  const std::vector<Option>& options() const { return options_; }
  // Returns a text with the accuracies that the table covers for the run's duration. The text is
  // empty if the table has no rows for the method.
  const std::string& ranges() const { return ranges_; }

 private:
  std::vector<Option> options_;
  std::string ranges_;
};

std::string choice_text(const Case& target, const std::vector<Option>& options, bool method_given) {
  const TimeCase& time = target.time;
  const Option& best = options.front();
  std::string text = shown(*best.method) + (best.method->by_step ? " and " : " with ");
  text += best.method->by_step ? "steps of " + rounded(*time.step) + " s"
                               : "position_tolerance " + rounded(time.position_tolerance) + " m";
  text +=
      " for an accuracy of " + rounded(*time.accuracy) + " m over " + rounded(time.duration) + " s";
  text += " (nine of ten scenes came within a factor " + rounded(best.factor) + ")";
  if (best.limited)
    text += "; contact.range or the calibration allow no larger one, so the error will be smaller";
  if (method_given) return text + "; the method is that of the case";
  if (options.size() == 1) return text + "; no other method is calibrated for it";
  return text + "; " + shown(*options[1].method) + " is calibrated to take " +
         rounded(options[1].cost / best.cost) + " times as long";
}

}  // namespace

std::span<const CalibratedMethod> calibrated_methods() { return methods(); }

void apply_setting(TimeCase& time, const CalibratedMethod& method, double setting) {
  time.method = method.method;
  if (method.by_step) {
    time.step = setting;
    time.newton = 1;
    time.position_tolerance = 1e-3 * setting;
    time.relative_tolerance = 1e-3;
    return;
  }
  time.position_tolerance = setting;
  time.relative_tolerance = std::min(0.1, 10 * setting);
}

double error_rate_at(const Case& source, double tolerance) {
  return interpolated(rows_of(source), tolerance, &CalibrationRow::setting,
                      &CalibrationRow::error_rate, 2.0 / 3);
}

double tolerance_at(const Case& source, double error_rate) {
  const std::vector<CalibrationRow> rows = rows_of(source);
  const double tolerance = interpolated(rows, error_rate, &CalibrationRow::error_rate,
                                        &CalibrationRow::setting, 3.0 / 2);
  return std::min({tolerance, rows.back().setting, position_tolerance_limit(source)});
}

bool has_chosen_tolerance(const Case& source) { return source.time.accuracy && !source.time.step; }

bool has_meetings(const Case& source) {
  return source.contact.enabled && source.body.size() + source.obstacle.size() > 1;
}

void choose_accuracy(Case& target) {
  if (!target.awaits_accuracy()) return;
  TimeCase& time = target.time;
  const Offers offers(target, target.method_given);
  if (offers.ranges().empty()) {
    std::vector<std::string> names;
    for (const CalibratedMethod& method : methods())
      if (!method.by_step) names.emplace_back(method.name);
    throw CaseError(target.method_location, "this method is not calibrated for an accuracy",
                    "expected no method beside \"accuracy\", or one of " + quoted_list(names));
  }
  if (offers.options().empty()) {
    throw CaseError(target.accuracy_location,
                    "the accuracy is " + number_text(*time.accuracy) + " m over " +
                        number_text(time.duration) + " s",
                    "expected " + offers.ranges() + ", which the calibration covers for it");
  }
  const Option& best = offers.options().front();
  const double longest = best.method->by_step ? time.duration : best.setting;
  apply_setting(time, *best.method, std::min(best.setting, longest));
  time.position_tolerance = std::min(time.position_tolerance, position_tolerance_limit(target));
  target.accuracy_choice = choice_text(target, offers.options(), target.method_given);
  target.resolved_text = case_text(target);
}

}  // namespace weft::sim
