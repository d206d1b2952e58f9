// A progress bar with the remaining time, on standard error.
#pragma once

#include <chrono>
#include <string>

namespace weft::sim {

// A progress bar. On a terminal it is one line, cut to the terminal's width. It is drawn by the
// constructor and then redrawn at most ten times per second. Elsewhere it prints whole lines: one
// whenever a tenth of the range is passed, and one after a second if none was printed before.
class ProgressBar {
 public:
  // The name and unit of the number whose progress is shown, as in "t = 0.2 of 2 s" or "picture 3
  // of 40".
  struct Quantity {
    std::string name = "t =", unit = " s";
  };
  // The number rises from 0 to `end` (> 0). Nothing is printed unless `shown`.
  ProgressBar(double end, bool shown, Quantity quantity = {"t =", " s"});
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  // Shows the number `value` if, by the rules above, the bar may be redrawn or a line is due.
  void show(double value);
  // Erases the line of a terminal.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  void draw(double value, const std::string& remaining);
  void print(double value, const std::string& remaining);
  std::string text(double value, const std::string& remaining) const;

  double end_;
  bool shown_;
  bool terminal_;
  Quantity quantity_;
  Clock::time_point start_, last_drawn_;
  bool has_printed_ = false;
  int next_tenth_ = 1;
};

}  // namespace weft::sim
