// The sidecar of a trajectory on a full disk.
#include "sim/trajectory/xdmf_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <string>

#include "tests/sim/trajectory_fixture.h"

namespace weft::sim::xdmf_file_test {
namespace {

using Sidecar = TrajectoryFolder;

// A full disk cuts off what is appended. The sidecar then is as it was before.
TEST_F(Sidecar, StaysWholeOnAFullDisk) {
  XdmfSurface surface;
  surface.name = "sheet";
  surface.points = 4;
  XdmfFile sidecar;
  sidecar.begin("run.h5", {});
  sidecar.create(path("run.xdmf"));
  sidecar.append(sidecar.describe(0, {surface}));
  const std::string before = contents(path("run.xdmf"));
  const auto append_within = [&](std::size_t bytes) {
    rlimit limit{};
    getrlimit(RLIMIT_FSIZE, &limit);
    const rlimit small{bytes, limit.rlim_max};
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &small);
    const std::string message = message_of([&] { sidecar.append(sidecar.describe(1, {surface})); });
    setrlimit(RLIMIT_FSIZE, &limit);
    std::signal(SIGXFSZ, handler);
    return message;
  };
  for (const std::size_t more : {0, 1, 100}) {
    const std::string message = append_within(before.size() + more);
    EXPECT_NE(message.find("run.xdmf: cannot write: "), std::string::npos) << message;
    EXPECT_EQ(contents(path("run.xdmf")), before) << more;
  }
  sidecar.append(sidecar.describe(1, {surface}));
  EXPECT_GT(contents(path("run.xdmf")).size(), before.size());
}

}  // namespace
}  // namespace weft::sim::xdmf_file_test
