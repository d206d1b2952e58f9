// The library example of README.md.
#include "sim/case/case_reader.h"
#include "sim/run/recorded_run.h"

int main(int, char** arguments) {
  const auto scene = weft::sim::build_scene(weft::sim::read_case(arguments[1]));
  weft::sim::RunOptions options;
  options.trajectory = arguments[2];
  const weft::sim::RunReport report = weft::sim::run_simulation(*scene, options);
  return report.status == weft::sim::RunReport::Status::done ? 0 : 1;
}
