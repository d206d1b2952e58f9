// The properties of the time integration methods, one line per method.
#pragma once

#include <cstddef>
#include <span>

#include "sim/case/case.h"

namespace weft::sim {

struct TimeMethodTraits {
  // The rule for the step length. fixed: `time.step`. chosen: the method chooses it. either:
  // `time.step` if given, else the method. loads: one load step per frame, or several where one
  // step fails.
  enum class Steps { fixed, chosen, either, loads };

  TimeMethod method;
  const char* name;   // value of `time.method`
  const char* title;  // name in words
  int order;          // order of convergence; for cvode, the largest time.maximum_order
  Steps steps;
  bool is_explicit;    // true if the method needs no stiffness matrix
  bool is_calibrated;  // true if the calibration of `time.accuracy` covers the method
  bool finds_equilibria() const { return steps == Steps::loads; }
  // True if SUNDIALS chooses the lengths of steps by estimates of their errors.
  bool has_error_control() const {
    return method == TimeMethod::cvode || method == TimeMethod::arkode;
  }
  // True if later steps depend on a history that SUNDIALS keeps and no saved state holds.
  bool has_hidden_history() const { return has_error_control(); }
};

// True if the table has one row per TimeMethod, in the order of that enum. Rows need a member
// `method`.
constexpr bool is_in_order_of_methods(const auto& table) {
  for (std::size_t i = 0; i < table.size(); ++i) {
    if (table[i].method != static_cast<TimeMethod>(i)) return false;
  }
  return table.size() == static_cast<std::size_t>(TimeMethod::impulses) + 1;
}

// Returns the properties of all methods, in the order of TimeMethod.
std::span<const TimeMethodTraits> time_methods();
const TimeMethodTraits& traits_of(TimeMethod method);

}  // namespace weft::sim
