#include "sim/command/progress_bar.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace weft::sim {

namespace {

// Shortest time (s) between two drawings on a terminal, and time (s) after which a first line is
// printed elsewhere if no tenth has been passed.
constexpr double redrawn_after = 0.1, first_line_after = 1;

std::string minutes_and_seconds(double seconds) {
  const long whole = std::lround(seconds);
  char text[32];
  std::snprintf(text, sizeof text, "%ld:%02ld", whole / 60, whole % 60);
  return text;
}

std::string four_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

// Returns the number of characters that fit on a line of the terminal at present, or 79 if its
// width is unknown.
std::size_t columns() {
  winsize size{};
  const bool is_known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
  return is_known ? size.ws_col - 1
                  : 79;  // some terminals wrap a line that reaches the last column
}

}  // namespace

ProgressBar::ProgressBar(double end, bool shown, Quantity quantity)
    : end_(end),
      shown_(shown),
      terminal_(isatty(STDERR_FILENO) != 0),
      quantity_(std::move(quantity)),
      start_(Clock::now()) {
  if (shown_ && terminal_) draw(0, "unknown");
}

ProgressBar::~ProgressBar() { clear(); }

std::string ProgressBar::text(double value, const std::string& remaining) const {
  char percent[16];
  std::snprintf(percent, sizeof percent, "%3.0f %%  ", 100 * value / end_);
  return percent + quantity_.name + ' ' + four_digits(value) + " of " + four_digits(end_) +
         quantity_.unit + ", remaining " + remaining;
}

void ProgressBar::show(double value) {
  if (!shown_) return;
  const double fraction = value / end_;
  const double elapsed = std::chrono::duration<double>(Clock::now() - start_).count();
  const std::string remaining =
      fraction > 0 ? minutes_and_seconds(elapsed * (1 - fraction) / fraction) : "unknown";
  if (terminal_) {
    if (std::chrono::duration<double>(Clock::now() - last_drawn_).count() < redrawn_after) return;
    draw(value, remaining);
  } else if (fraction * 10 >= next_tenth_ || (!has_printed_ && elapsed >= first_line_after)) {
    print(value, remaining);
  }
}

void ProgressBar::print(double value, const std::string& remaining) {
  has_printed_ = true;
  while (value / end_ * 10 >= next_tenth_) ++next_tenth_;
  std::fprintf(stderr, "%s\n", text(value, remaining).c_str());
}

void ProgressBar::draw(double value, const std::string& remaining) {
  last_drawn_ = Clock::now();
  constexpr int width = 30;
  const int filled = static_cast<int>(width * std::clamp(value / end_, 0.0, 1.0));
  const std::string line = '[' + std::string(filled, '#') + std::string(width - filled, '.') +
                           "] " + text(value, remaining);
  std::fprintf(stderr, "\r%s\033[K", line.substr(0, columns()).c_str());
  std::fflush(stderr);
}

void ProgressBar::clear() {
  if (shown_ && terminal_) std::fprintf(stderr, "\r\033[K");
}

}  // namespace weft::sim
