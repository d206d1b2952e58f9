#include "sim/command/progress_bar.h"

#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <string>

namespace weft::sim {

namespace {

std::string minutes_and_seconds(double seconds) {
  const long whole = std::lround(seconds);
  char text[32];
  std::snprintf(text, sizeof text, "%ld:%02ld", whole / 60, whole % 60);
  return text;
}

}  // namespace

ProgressBar::ProgressBar(double end, bool shown)
    : end_(end),
      shown_(shown),
      terminal_(isatty(STDERR_FILENO) != 0),
      start_(Clock::now()),
      last_drawn_(start_) {}

void ProgressBar::show(double value) {
  if (!shown_) return;
  const Clock::time_point now = Clock::now();
  const double fraction = value / end_;
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const double remaining = fraction > 0 ? elapsed * (1 - fraction) / fraction : 0;
  if (!terminal_) {
    if (fraction * 10 < next_tenth_) return;
    while (fraction * 10 >= next_tenth_) ++next_tenth_;
    std::fprintf(stderr, "%3.0f %%  t = %.4g s, remaining %s\n", 100 * fraction, value,
                 minutes_and_seconds(remaining).c_str());
    return;
  }
  if (std::chrono::duration<double>(now - last_drawn_).count() < 0.1) return;
  last_drawn_ = now;
  constexpr int width = 30;
  const int filled = static_cast<int>(width * fraction);
  std::fprintf(stderr, "\r[%s%s] %3.0f %%  t = %.4g of %.4g s, remaining %s   ",
               std::string(filled, '#').c_str(), std::string(width - filled, '.').c_str(),
               100 * fraction, value, end_, minutes_and_seconds(remaining).c_str());
  std::fflush(stderr);
}

void ProgressBar::clear() {
  if (shown_ && terminal_) std::fprintf(stderr, "\r\033[K");
}

}  // namespace weft::sim
