#include "sim/case/accuracy_choice.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

#include "sim/case/case_checks.h"
#include "sim/case/case_error.h"
#include "sim/case/case_text.h"

namespace weft::sim {

namespace {

constexpr CalibratedMethod methods[] = {
    {"cvode", TimeMethod::cvode, false},
    {"arkode", TimeMethod::arkode, false},
    {"euler", TimeMethod::euler, false},
    {"linear-euler", TimeMethod::euler, true},
};

constexpr CalibrationRow table[] = {
#include "sim/case/calibration_table.inc"
};

struct Option {
  const CalibratedMethod* method = nullptr;
  double setting = 0;
  double cost = 0;
};

std::vector<CalibrationRow> rows_of(const CalibratedMethod& method, bool meetings) {
  std::vector<CalibrationRow> rows;
  for (const CalibrationRow& row : table) {
    if (row.meetings == meetings && std::string(row.method) == method.name) rows.push_back(row);
  }
  return rows;
}

// Between two rows on logarithmic scales; nothing outside of them.
std::optional<Option> option_at(const CalibratedMethod& method,
                                const std::vector<CalibrationRow>& rows, double rate) {
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const CalibrationRow &fine = rows[i - 1], &coarse = rows[i];
    if (rate < fine.error_rate || rate > coarse.error_rate) continue;
    const double part =
        std::log(rate / fine.error_rate) / std::log(coarse.error_rate / fine.error_rate);
    return Option{&method, fine.setting * std::pow(coarse.setting / fine.setting, part),
                  fine.cost * std::pow(coarse.cost / fine.cost, part)};
  }
  return std::nullopt;
}

std::string rounded(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

// All that the table offers for an accuracy, the cheapest first.
class Offers {
 public:
  Offers(const Case& source, bool method_given) {
    const double rate = *source.time.accuracy / source.time.duration;
    for (const CalibratedMethod& method : methods) {
      if (method_given && method.method != source.time.method) continue;
      const std::vector<CalibrationRow> rows = rows_of(method, has_meetings(source));
      if (rows.empty()) continue;
      least_ = std::min(least_.value_or(rows.front().error_rate), rows.front().error_rate);
      most_ = std::max(most_.value_or(rows.back().error_rate), rows.back().error_rate);
      if (const auto option = option_at(method, rows, rate)) options_.push_back(*option);
    }
    std::ranges::sort(options_, {}, &Option::cost);
  }
  const std::vector<Option>& options() const { return options_; }
  bool know_the_method() const { return least_.has_value(); }
  // m, for a run of this duration (s).
  std::string range(double duration) const {
    return rounded(*least_ * duration) + " to " + rounded(*most_ * duration) + " m";
  }

 private:
  std::vector<Option> options_;
  std::optional<double> least_, most_;  // m/s
};

std::string choice_text(const Case& target, const std::vector<Option>& options, bool method_given,
                        bool limited) {
  const TimeCase& time = target.time;
  const Option& best = options.front();
  std::string text = std::string(best.method->name) + " with ";
  text += best.method->by_step ? "steps of " + rounded(best.setting) + " s"
                               : "position_tolerance " + rounded(time.position_tolerance) + " m";
  text +=
      " for an accuracy of " + rounded(*time.accuracy) + " m over " + rounded(time.duration) + " s";
  if (limited) text += "; contact.range allows no larger one, so that the error will be smaller";
  if (method_given) return text + "; the method is that of the case";
  if (options.size() == 1) return text + "; no other method is calibrated for it";
  return text + "; " + options[1].method->name + " is calibrated to take " +
         rounded(options[1].cost / best.cost) + " times as long";
}

}  // namespace

std::span<const CalibratedMethod> calibrated_methods() { return methods; }

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

bool has_meetings(const Case& source) {
  return source.contact.enabled && source.body.size() + source.obstacle.size() > 1;
}

void choose_accuracy(Case& target, const Locations& locations) {
  TimeCase& time = target.time;
  if (!time.accuracy) return;
  const bool method_given = locations.given("time.method");
  const Offers offers(target, method_given);
  if (!offers.know_the_method()) {
    throw CaseError(locations.value("time.method"), "this method is not calibrated for an accuracy",
                    "expected no method beside \"accuracy\", or \"cvode\"");
  }
  if (offers.options().empty()) {
    throw CaseError(locations.value("time.accuracy"),
                    "the accuracy is " + number_text(*time.accuracy) + " m over " +
                        number_text(time.duration) + " s",
                    "expected " + offers.range(time.duration) +
                        ", which the calibration covers for a run as long" +
                        (method_given ? " with this method" : ""));
  }
  const Option& best = offers.options().front();
  apply_setting(time, *best.method, best.setting);
  const double limit = position_tolerance_limit(target);
  const bool limited = time.position_tolerance > limit;
  if (limited) {
    time.position_tolerance = limit;
    time.relative_tolerance = std::min(time.relative_tolerance, 10 * limit);
  }
  target.accuracy_choice =
      choice_text(target, offers.options(), method_given, limited && !best.method->by_step);
}

}  // namespace weft::sim
