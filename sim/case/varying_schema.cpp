// Describes the tables of values that vary in time: curves and gusts.
#include "sim/case/case_schema.h"
#include "sim/case/field_makers.h"

namespace weft::sim {

template <class Value>
Table describe_curve(CurveCase<Value>& target, const Field& of) {
  auto& [times, values, between] = target;
  return {{
      field("times", &times, "s", not_negative, "Times of the values, each later than the last.")
          .needed(),
      field("values", &values, of.unit, of.limits,
            "Values at these times. Before the first time the first value holds, after the last "
            "time the last one.")
          .needed(),
      field("between",
            choice(&between, {{Between::linear, "linear"},
                              {Between::smooth, "smooth"},
                              {Between::step, "step"}}),
            "Course between two times. linear: straight. smooth: eased, with first and second "
            "derivatives of zero at the times. step: each value holds until the next time."),
  }};
}

template Table describe_curve(CurveCase<double>&, const Field&);
template Table describe_curve(CurveCase<Vec3>&, const Field&);

Table describe_gust(GustCase& target) {
  auto& [mean, intensity, time_scale, seed] = target;
  return {{
      field("mean", &mean, "m/s", any, "Mean velocity; the gusts blow along it.").needed(),
      field("intensity", &intensity, "", not_negative,
            "Standard deviation of the speed, as a fraction of the mean speed.")
          .needed(),
      field("time_scale", &time_scale, "s", positive,
            "Integral time scale: gusts last about as long. At least 104 times "
            "time.minimum_step.")
          .needed(),
      field("seed", &seed, "", at_least(0), "Number that chooses the sequence of gusts."),
  }};
}

bool varies(const Field& field) {
  if (const auto* number = std::get_if<Varying<double>*>(&field.member)) return (*number)->varies();
  if (const auto* vector = std::get_if<Varying<Vec3>*>(&field.member)) return (*vector)->varies();
  return false;
}

std::vector<std::string> keys_that_vary() {
  Case prototype;
  std::vector<std::string> keys;
  const auto add_from = [&](const Table& table, const std::string& path) {
    for (const Field& each : table.fields) {
      if (is_varying(each)) keys.push_back(join_path(path, each.key));
    }
  };
  for (const Field& each : describe(prototype).fields) {
    if (const auto* member = std::get_if<TableMember>(&each.member)) {
      add_from(member->open(), each.key);
    } else if (const auto* list = std::get_if<TableList>(&each.member)) {
      add_from(list->append(), list->named ? join_path(each.key, "NAME") : each.key);
    }
  }
  return keys;
}

}  // namespace weft::sim
