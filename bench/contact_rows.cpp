#include "bench/contact_rows.h"

#include <stdexcept>
#include <string>

#include "bench/case_check.h"
#include "bench/dropped_shells.h"
#include "bench/medians.h"

namespace weft::bench {

namespace {

// Drops the shell of a case, with these images of its bodies.
struct DropCase {
  std::string name, case_name;
  std::vector<std::vector<int>> resolutions;  // of the first body
  std::vector<std::string> finer;             // of the second one, by image; empty: as in the case
};

void run_drop(const DropCase& drop, std::size_t index, const RowSink& done) {
  const std::vector<int>& resolution = drop.resolutions[index];
  CheckRow row{.check = drop.name,
               .case_path = "cases/benchmarks/" + drop.case_name + ".toml",
               .resolution = resolution,
               .points = resolution[0] * resolution[1],
               .quantity = "crossings",
               .scale = 1,
               .bound = Bound::at_most,
               .source = "exact predicates on triangles of the curved surface"};
  CheckRow cost = row;
  cost.check += ", cost";
  cost.quantity = "CPU s per simulated s";
  cost.bound = Bound::reported;
  cost.source = "CPU time of the simulation on this machine";
  try {
    CaseCheck check{.case_name = drop.case_name};
    if (!drop.finer.empty()) check.overrides.push_back(drop.finer[index]);
    const sim::Case source = case_of(check, {resolution});
    ShellDrop result;
    row.cpu_s = cpu_time_of([&] { result = drop_shell(source); });
    if (!result.touched) throw std::runtime_error("nothing was in contact");
    row.value = result.crossings;
    cost.value = result.cpu_s / source.time.duration;
    cost.cpu_s = result.cpu_s;
  } catch (const std::runtime_error& error) {
    row.failure = cost.failure = error.what();
  }
  done(row);
  done(cost);
}

}  // namespace

std::vector<TablePart> shell_drops() {
  const DropCase drops[] = {
      {"shell dropped on a sphere", "shell_on_sphere", {{9, 9}, {17, 17}}, {}},
      {"shell dropped on cloth",
       "shell_on_cloth",
       {{7, 9}, {13, 17}},
       {"body.cloth.shape.resolution=[13,13]", "body.cloth.shape.resolution=[25,25]"}}};
  std::vector<TablePart> parts;
  for (const DropCase& drop : drops) {
    parts.push_back({.checks = {drop.name, drop.name + ", cost"},
                     .case_name = drop.case_name,
                     .run = [drop](const RowSink& done) {
                       for (std::size_t i = 0; i < drop.resolutions.size(); ++i)
                         run_drop(drop, i, done);
                     }});
  }
  return parts;
}

}  // namespace weft::bench
