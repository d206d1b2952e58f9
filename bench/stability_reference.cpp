#include "bench/stability_reference.h"

#include <cstdio>
#include <cstring>
#include <set>

#include "bench/child_runs.h"
#include "bench/reference_run.h"
#include "sim/accuracy/accuracy_choice.h"
#include "sim/case/case_reader.h"
#include "sim/case/case_text.h"

namespace weft::bench {

namespace {

using namespace sim;

constexpr double certainty = 1e-3;  // m

// A converged run, simulated once for all methods.
struct Work {
  std::vector<std::string> physics;
  std::set<double> times;  // s, at which cells end
  double size = 1;
};

std::vector<Work> works_of(std::span<const Cell> cells) {
  std::map<std::vector<std::string>, Work> works;
  for (const Cell& cell : cells) {
    if (cell.is_static) continue;
    Work& work = works[cell.physics()];
    work.physics = cell.physics();
    work.times.insert(cell.duration);
    work.size = std::max(work.size, cell.size);
  }
  std::vector<Work> list;
  for (auto& [physics, work] : works) list.push_back(std::move(work));
  return list;
}

// Serialises the agreement, then the positions at each time up to the horizon.
std::string bytes_of(const Reference& reference) {
  std::string bytes(sizeof(double), '\0');
  std::memcpy(bytes.data(), &reference.agreement, sizeof(double));
  for (const auto& positions : reference.positions) {
    const std::size_t count = positions.size();
    bytes.append(reinterpret_cast<const char*>(&count), sizeof count);
    bytes.append(reinterpret_cast<const char*>(positions.data()), count * sizeof(Vec3));
  }
  return bytes;
}

std::map<double, ConvergedEnd> ends_of(const std::string& bytes, const std::set<double>& times) {
  std::map<double, ConvergedEnd> ends;
  std::size_t at = 0;
  const auto read = [&](void* to, std::size_t size) {
    std::memcpy(to, bytes.data() + at, size);
    at += size;
  };
  double agreement = 0;
  read(&agreement, sizeof agreement);
  for (auto time = times.begin(); time != times.end() && at < bytes.size(); ++time) {
    std::size_t count = 0;
    read(&count, sizeof count);
    ConvergedEnd& end = ends[*time];
    end.agreement = agreement;
    end.position.resize(count);
    read(end.position.data(), count * sizeof(Vec3));
  }
  return ends;
}

std::string run_here(const Work& work, double tolerance, double budget) {
  // Messages are discarded: readers of the table can do nothing about a reference that does not
  // finish.
  if (std::freopen("/dev/null", "w", stderr) == nullptr) return "";
  std::vector<std::string> overrides(work.physics.begin() + 1, work.physics.end());
  overrides.push_back("time.duration=" + number_text(*work.times.rbegin()));
  try {
    Case source = read_case(WEFT_SOURCE_DIR "/" + work.physics.front(), overrides);
    choose_accuracy(source);
    return bytes_of(
        find_reference(source, {work.times.begin(), work.times.end()},
                       {.tolerance = tolerance, .certainty = certainty, .budget = budget}));
  } catch (const std::exception&) {
    return "";  // a case that is refused
  }
}

}  // namespace

void ConvergedEnds::find(std::span<const Cell> cells, double tolerance, double limit, int jobs) {
  const std::vector<Work> works = works_of(cells);
  run_children(
      works.size(), jobs, [&](std::size_t i) { return 10 + 4 * limit * works[i].size; },
      [&](std::size_t i) { return run_here(works[i], tolerance, limit * works[i].size); },
      [&](std::size_t i, const ChildEnd& end) {
        if (!end.is_well || end.result.empty()) return;
        by_physics_[works[i].physics] = ends_of(end.result, works[i].times);
      });
}

const ConvergedEnd* ConvergedEnds::at_end_of(const Cell& cell) const {
  if (cell.is_static) return nullptr;
  const auto physics = by_physics_.find(cell.physics());
  if (physics == by_physics_.end()) return nullptr;
  const auto end = physics->second.find(cell.duration);
  return end == physics->second.end() ? nullptr : &end->second;
}

}  // namespace weft::bench
