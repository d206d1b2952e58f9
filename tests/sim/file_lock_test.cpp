// A run locks its file while it lives, and no longer; readers can always read it.
#include "sim/trajectory/file_lock.h"

#include <hdf5.h>
#include <chrono>
#include <thread>

#include "sim/command/run_command.h"
#include "tests/sim/weft_process.h"

namespace weft::sim::file_lock_test {
namespace {

constexpr const char* long_case = R"(time.duration = 1e4
contact.enabled = false
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [4, 5] }
)";

const std::string busy =
    "out/sheet.h5: is being written by a run that has not ended; wait for it, or write to another "
    "folder (-o)\n";

class FileLock : public WeftCommand {
 protected:
  std::string file() const { return path("out/sheet.h5").string(); }

  // Opens the file like h5py, with HDF5's own locks. During a commit HDF5 calls the file truncated,
  // since it is as long as before; retries tell a commit, which is over soon, from a lock, which
  // stays.
  bool plain_hdf5_reads() const {
    for (int attempt = 0; attempt < 200; ++attempt) {
      const hid_t opened = H5Fopen(file().c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
      if (opened >= 0) {
        H5Fclose(opened);
        return true;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }
};

TEST_F(FileLock, RefusesASecondRunWhileTheFirstLives) {
  write("sheet.toml", long_case);
  // Processes of a test share the files of their streams, so the first one needs its own.
  std::filesystem::create_directory(path("first"));
  WeftProcess first(path("first"), {"run", "../sheet.toml", "--quiet", "-o", "../out"});
  wait_for_file("out/sheet.h5");
  EXPECT_TRUE(is_locked(file()));
  const Result second = weft({"run", "sheet.toml", "--force", "--set", "time.duration=0.02"});
  EXPECT_EQ(second.code, exit_code::input_output);
  EXPECT_EQ(second.err, busy);
  EXPECT_TRUE(plain_hdf5_reads());
  EXPECT_EQ(weft({"info", "out/sheet.h5"}).code, exit_code::done);

  first.send(SIGKILL);
  EXPECT_EQ(first.wait(), -SIGKILL);
  EXPECT_FALSE(is_locked(file()));
  const Result third = weft({"run", "sheet.toml", "--force", "--set", "time.duration=0.02"});
  EXPECT_EQ(third.code, exit_code::done) << third.err;
}

// However close together two runs begin, one is refused or starts after the other.
TEST_F(FileLock, LetsNoRunLoseItsFileInSilence) {
  write("sheet.toml", long_case);
  for (int trial = 0; trial < 3; ++trial) {
    std::vector<std::unique_ptr<WeftProcess>> runs;
    for (int i = 0; i < 3; ++i) {
      const std::string place = "place" + std::to_string(i);
      std::filesystem::create_directory(path(place));
      runs.push_back(std::make_unique<WeftProcess>(
          path(place), WeftProcess::Arguments{"run", "../sheet.toml", "--quiet", "--force", "-o",
                                              "../out", "--set", "time.duration=2"}));
    }
    int done = 0;
    for (const auto& run : runs) {
      const int code = run->wait();
      done += code == exit_code::done ? 1 : 0;
      EXPECT_TRUE(code == exit_code::done || run->err().ends_with(busy.substr(12))) << run->err();
    }
    EXPECT_GE(done, 1);
  }
}

TEST_F(FileLock, ARunSaysThatItsFileIsGone) {
  write("sheet.toml", long_case);
  for (const bool replaced : {false, true}) {
    WeftProcess run(folder(), {"run", "sheet.toml", "--quiet", "--force"});
    while (!is_locked(file())) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    std::filesystem::rename(file(), path("elsewhere.h5"));
    if (replaced) write("out/sheet.h5", "mine");
    run.send(SIGINT);
    EXPECT_EQ(run.wait(), exit_code::input_output);
    EXPECT_EQ(run.err(),
              "out/sheet.h5: is no longer the file of this run: it was moved, removed or replaced "
              "meanwhile\n");
    EXPECT_EQ(run.out(), "");
  }
  EXPECT_EQ(read_bytes(path("out/sheet.h5")), "mine");
}

TEST_F(FileLock, ReplacesALinkThatLeadsNowhere) {
  write("sheet.toml", long_case);
  std::filesystem::create_directory(path("out"));
  std::filesystem::create_symlink("nowhere", file());
  const Result result = weft({"run", "sheet.toml", "--force", "--set", "time.duration=0.02"});
  EXPECT_EQ(result.code, exit_code::done) << result.err;
}

}  // namespace
}  // namespace weft::sim::file_lock_test
