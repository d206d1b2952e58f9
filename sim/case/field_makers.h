// Functions that make Field objects (case_schema.h). The files *_schema.cpp use them.
#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "sim/case/case_schema.h"

namespace weft::sim {

inline constexpr Limits any{};
inline constexpr double infinity = std::numeric_limits<double>::infinity();
inline constexpr Limits positive{0, infinity, true, false};
inline constexpr Limits not_negative{0, infinity, false, false};
constexpr Limits at_least(double minimum) { return {minimum, infinity, false, false}; }

inline Field field(std::string key, Member member, std::string unit, Limits limits,
                   std::string meaning) {
  Field result;
  result.key = std::move(key);
  result.member = std::move(member);
  result.unit = std::move(unit);
  result.limits = limits;
  result.meaning = std::move(meaning);
  return result;
}

// Makes a field without unit and limits, for values that are not numbers.
inline Field field(std::string key, Member member, std::string meaning) {
  return field(std::move(key), std::move(member), "", any, std::move(meaning));
}

template <class Enum>
struct NamedValue {
  Enum value;
  std::string name;
};

template <class Enum>
Choice choice(Enum* target, std::type_identity_t<std::vector<NamedValue<Enum>>> values) {
  std::vector<std::string> names;
  for (const NamedValue<Enum>& each : values) names.push_back(each.name);
  return {std::move(names),
          [target, values] {
            const auto found = std::ranges::find(values, *target, &NamedValue<Enum>::value);
            return static_cast<std::size_t>(found - values.begin());
          },
          [target, values](std::size_t index) { *target = values[index].value; }};
}

template <class Struct>
TableMember table(Struct* target) {
  return {[] { return true; }, [target] { return describe(*target); }};
}

template <class Struct>
TableMember table(std::optional<Struct>* target) {
  return {[target] { return target->has_value(); },
          [target] {
            if (!*target) target->emplace();
            return describe(**target);
          }};
}

template <class Struct>
TableList tables(std::vector<Struct>* target, bool named = false) {
  return {named, false, [target] { return target->size(); },
          [target](std::size_t index) { return describe((*target)[index]); },
          [target] { return describe(target->emplace_back()); }};
}

}  // namespace weft::sim
