// A part of the state of a run that advances with accepted steps alone.
#pragma once

#include <cstdint>
#include <utility>

namespace weft::sim {

// The value at the start and at the end of the last accepted step. Forces at a time after the start
// of that step and before its end follow from the value at its start; those at later times follow
// from the value at its end.
template <class Value>
class StepHistory {
 public:
  StepHistory() = default;
  explicit StepHistory(Value start) : at_begin_(start), at_end_(std::move(start)) {}

  // Selects the value from which forces at a time (s) follow.
  void choose(double time) {
    const bool is_earlier = time < end_;
    if (is_earlier == is_earlier_) return;
    is_earlier_ = is_earlier;
    ++version_;
  }
  const Value& selected() const {
    if (fixed_ != nullptr) return *fixed_;
    return is_earlier_ ? at_begin_ : at_end_;
  }
  // Differs from all earlier numbers whenever another value is selected.
  std::int64_t version() const { return version_; }

  // Begins to accept a step that ends at `time`: its start keeps the value so far. The caller then
  // changes at_end() to what follows from the step, until end_accept().
  void begin_accept(double time) {
    at_begin_ = at_end_;
    begin_ = end_;
    end_ = time;
  }
  Value& at_end() { return at_end_; }
  const Value& at_end() const { return at_end_; }
  void end_accept() { ++version_; }
  // Takes the last step back if it ended after `time`. Returns true if `time` is later than the end
  // of the steps that are left.
  bool take_back(double time) {
    if (time < end_) {
      at_end_ = at_begin_;
      end_ = begin_;
      is_earlier_ = false;
      ++version_;
    }
    return time > end_;
  }

  // Selects this value, whatever the time, until the call with null.
  void fix(const Value* value) {
    fixed_ = value;
    ++version_;
  }
  // Writes or reads both values by transfer_value(value), and their times by `archive`.
  template <class Archive, class TransferValue>
  void transfer(Archive& archive, const TransferValue& transfer_value) {
    transfer_value(at_begin_);
    transfer_value(at_end_);
    archive(begin_, end_);
    if (!archive.reads()) return;
    is_earlier_ = false;
    ++version_;
  }

 private:
  Value at_begin_{}, at_end_{};
  double begin_ = 0, end_ = 0;  // s
  bool is_earlier_ = false;     // the value at the start of the last step is selected
  const Value* fixed_ = nullptr;
  std::int64_t version_ = 0;
};

}  // namespace weft::sim
