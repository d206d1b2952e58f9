// The library examples of README.md.
#include <cstdio>

#include "sim/case/case_reader.h"
#include "sim/run/make_simulation.h"
#include "sim/run/recorded_run.h"

namespace {

int look(const char* path) {
  auto cloth = weft::sim::make_simulation(weft::sim::read_case(path));
  if (const auto failure = cloth.advance(0.25)) {
    std::fprintf(stderr, "%s\n", failure->text.c_str());
    return 1;
  }
  const weft::sim::Vec3 corner = cloth.position("sheet").front();
  std::printf("%g s: %g %g %g m\n", cloth.time(), corner.x(), corner.y(), corner.z());
  return 0;
}

int record(const char* path, const char* trajectory) {
  weft::sim::RunOptions options;
  options.trajectory = trajectory;
  const auto report = weft::sim::run_simulation(weft::sim::read_case(path), options);
  return report.status == weft::sim::RunReport::Status::done ? 0 : 1;
}

}  // namespace

int main(int, char** arguments) { return look(arguments[1]) + record(arguments[1], arguments[2]); }
