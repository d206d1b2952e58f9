// Probes: numbers of a run, as expressions over what its trajectory holds.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sim/case/located_text.h"
#include "sim/probes/recorded_values.h"

namespace weft::sim {

// A number of a run, such as "max(largest_stretch)" or "last(position('cloth', -1, 0).z) / 0.3".
//
// Functions over time reduce a quantity q that varies in time to a number:
//   first(q), last(q)      value at the first or last instant
//   min(q), max(q)         extreme; instants at which q is no number are left out
//   mean(q)                mean by time, with q linear between instants; the time beside instants
//                          at which q is no number is left out
//   at(q, t)               value at time t (s), linear between instants; NaN outside of them
//   first_time(condition)  time (s) of the first instant at which the condition holds; NaN if none
// q is an expression over `time`, the series of frames by name and the quantities of
// recorded_quantity.h, or over `time` and the series of steps as step.NAME. Its instants are the
// frames, or the ends of steps. A function over time within q is a constant there. Around these
// functions stands an expression of numbers, which may use cpu_time and wall_time (s, of the whole
// run), duration (s, time of the last frame) and frames. A number that is missing is NaN.
class Probe {
 public:
  // Throws CaseError at the character at fault: for faults of an expression (expression.h), for
  // names that `contents` does not have, and for a quantity outside of functions over time.
  Probe(const LocatedText& text, const TrajectoryContents& contents);
  ~Probe();
  Probe(Probe&&) noexcept;
  Probe& operator=(Probe&&) noexcept;

  // Returns the value. The contents of `values` must be equal to those of the constructor. Reads
  // only the frames that the functions need. Throws FileError.
  double value(RecordedValues& values) const;

 private:
  struct Formula;
  struct TimeFunction;
  class Compiler;
  class Evaluation;
  std::unique_ptr<Formula> formula_;
};

}  // namespace weft::sim
