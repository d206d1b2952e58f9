#include "tests/moving/moving_run.h"

#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <exception>
#include <map>
#include <sstream>

#include "sim/base/process_time.h"
#include "sim/case/case_reader.h"
#include "sim/run/make_simulation.h"
#include "sim/simulation/cpu_limit.h"
#include "tests/sim/simulated_case.h"

namespace weft::moving {

namespace {

// Time (s) after which the kernel ends a child that hangs.
constexpr unsigned hung_after = 300;

// Steps through a scene and checks its states.
class Watched {
 public:
  explicit Watched(const MovingScene& scene)
      : scene_(scene),
        sim_(sim::make_simulation(sim::parse_case(scene.text, "moving.toml"))),
        limit_(run_limit),
        y_(sim_.state().size()) {
    sim_.set_reason_to_stop([this] { return too_long(); });
  }

  MovingOutcome run() {
    const double cpu_start = sim::process_cpu_time();
    look(0, sim_.state());
    while (next_time() <= scene_.end && outcome_.crossings == 0) {
      if (const auto failure = advance()) {
        outcome_.failure = failure->text;
        break;
      }
    }
    const sim::IntegratorCounts counts = sim_.counts();
    outcome_.steps = static_cast<long>(counts.steps);
    outcome_.vetoed = static_cast<long>(counts.vetoed_steps);
    outcome_.cpu_time = sim::process_cpu_time() - cpu_start;
    return outcome_;
  }

 private:
  std::optional<sim::Failure> too_long() {
    if (!limit_.is_passed()) return std::nullopt;
    return limit_.failure(sim_);
  }

  // Returns the time of the next check: frames until the motion starts, then states between them
  // too.
  double next_time() const {
    const double frame = 1 / sim_.scene().source.time.frames_per_second;
    const double whole = static_cast<double>(frame_) * frame;
    return whole + static_cast<double>(part_) * frame / (states_per_frame + 1);
  }
  void count_on() {
    const double frame = 1 / sim_.scene().source.time.frames_per_second;
    const bool moves = static_cast<double>(frame_ + 1) * frame > scene_.start;
    if (moves && ++part_ <= states_per_frame) return;
    part_ = 0;
    ++frame_;
  }

  std::optional<sim::Failure> advance() {
    if (auto failure = sim_.step()) return failure;
    const double now = sim_.time();
    for (; next_time() <= std::min(now, scene_.end) && outcome_.crossings == 0; count_on()) {
      if (auto failure = sim_.state_at(next_time(), y_)) return failure;
      look(next_time(), y_);
    }
    return too_long();
  }

  void look(double time, std::span<const double> state) {
    std::vector<sim::Vec3> position, velocity;
    sim_.dynamics().expand_all(time, state, position, velocity);
    ++outcome_.states;
    outcome_.crossings = sim::crossings(sim_.scene(), position);
    outcome_.crossing_time = time;
  }

  const MovingScene& scene_;
  sim::Simulation sim_;
  sim::CpuLimit limit_;
  std::vector<double> y_;
  long frame_ = 0;
  int part_ = 1;
  MovingOutcome outcome_;
};

std::string to_text(const MovingOutcome& outcome) {
  std::ostringstream out;
  out.precision(17);
  out << outcome.crossings << ' ' << outcome.crossing_time << ' ' << outcome.states << ' '
      << outcome.steps << ' ' << outcome.vetoed << ' ' << outcome.cpu_time << '\n'
      << outcome.failure;
  return out.str();
}

MovingOutcome from_text(const std::string& text) {
  MovingOutcome outcome;
  std::istringstream in(text);
  in >> outcome.crossings >> outcome.crossing_time >> outcome.states >> outcome.steps >>
      outcome.vetoed >> outcome.cpu_time;
  in.get();
  std::getline(in, outcome.failure, '\0');
  return outcome;
}

[[noreturn]] void run_as_child(const MovingScene& scene, int pipe_end) {
  alarm(hung_after);
  MovingOutcome outcome;
  try {
    outcome = run_scene(scene);
  } catch (const std::exception& error) {
    outcome.failure = std::string("not simulated: ") + error.what();
  }
  const std::string text = to_text(outcome);
  const bool written =
      write(pipe_end, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  _exit(written ? 0 : 1);
}

struct Child {
  std::size_t scene = 0;
  pid_t process = 0;
  std::string text;
};

// The child processes, by the end of the pipe that they write to.
class Children {
 public:
  void start(const MovingScene& scene, std::size_t index) {
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error("no pipe for a child");
    const pid_t process = fork();
    if (process < 0) throw std::runtime_error("no process for a child");
    if (process == 0) run_as_child(scene, ends[1]);
    close(ends[1]);
    by_pipe_[ends[0]] = {index, process, {}};
  }
  std::size_t size() const { return by_pipe_.size(); }

  // Reads available output; stores the outcome of each child that has ended.
  void wait(std::vector<MovingOutcome>& outcomes) {
    std::vector<pollfd> polled;
    for (const auto& [end, child] : by_pipe_) polled.push_back({end, POLLIN, 0});
    if (poll(polled.data(), polled.size(), -1) <= 0) return;
    for (const pollfd& one : polled) {
      if (one.revents == 0) continue;
      char buffer[4096];
      const ssize_t count = read(one.fd, buffer, sizeof buffer);
      if (count > 0) {
        by_pipe_[one.fd].text.append(buffer, static_cast<std::size_t>(count));
      } else {
        finish(one.fd, outcomes);
      }
    }
  }

 private:
  void finish(int end, std::vector<MovingOutcome>& outcomes) {
    const Child child = by_pipe_[end];
    by_pipe_.erase(end);
    close(end);
    int status = 0;
    waitpid(child.process, &status, 0);
    MovingOutcome& outcome = outcomes[child.scene];
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
      outcome = from_text(child.text);
    } else {
      outcome.failure = "crashed, or hung: wait status " + std::to_string(status);
    }
  }

  std::map<int, Child> by_pipe_;
};

}  // namespace

MovingOutcome run_scene(const MovingScene& scene) { return Watched(scene).run(); }

std::vector<MovingOutcome> run_scenes(const std::vector<MovingScene>& scenes, int jobs) {
  std::vector<MovingOutcome> outcomes(scenes.size());
  Children children;
  for (std::size_t next = 0; next < scenes.size() || children.size() > 0;) {
    while (next < scenes.size() && children.size() < static_cast<std::size_t>(jobs)) {
      children.start(scenes[next], next);
      ++next;
    }
    children.wait(outcomes);
  }
  return outcomes;
}

}  // namespace weft::moving
