// Files with flipped bytes. HDF5 1.10 crashes on about one in thirty of them. The command must
// report every one, and not wait.
#include <array>
#include <memory>
#include <random>

#include "sim/base/reading_process.h"
#include "sim/command/run_command.h"
#include "tests/sim/weft_process.h"

namespace weft::sim::damaged_file_test {
namespace {

class DamagedFile : public WeftCommand {
 protected:
  std::string write_trajectory() const {
    write("sheet.toml", R"(time.duration = 0.02
contact.enabled = false
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [3, 3] }
[[body]]
name = "ball"
shape = { type = "sphere", radius = 0.1, resolution = [3] }
)");
    EXPECT_EQ(weft({"run", "sheet.toml", "--quiet"}).code, exit_code::done);
    return read_bytes(path("out/sheet.h5"));
  }

  // Replaces a few bytes, of metadata or of anything.
  static std::string damaged(std::string bytes, std::mt19937& random) {
    const std::size_t flips = 1 + random() % 4;
    for (std::size_t i = 0; i < flips; ++i) {
      std::size_t place = random() % bytes.size();
      // Most of a paged file is empty.
      for (int tries = 0; bytes[place] == 0 && tries < 20; ++tries) place = random() % bytes.size();
      bytes[place] = static_cast<char>(bytes[place] ^ (1 + random() % 255));
    }
    return bytes;
  }

  // Runs the command on damaged copies of a file, each in a separate folder, a few at a time.
  void expect_words(const std::string& bytes, int files, const std::vector<int>& codes,
                    const WeftProcess::Arguments& arguments, const std::string& more = "") const {
    constexpr int at_a_time = 4;
    std::mt19937 random(20261122);
    for (int first = 0; first < files; first += at_a_time) {
      std::array<std::unique_ptr<WeftProcess>, at_a_time> processes;
      for (int i = 0; i < at_a_time; ++i) {
        const std::filesystem::path place = path("place" + std::to_string(i));
        std::filesystem::create_directories(place);
        const std::filesystem::path file = write_into(place, "file.h5", damaged(bytes, random));
        if (!more.empty()) write_into(place, "case.toml", more);
        // An old time of change says that no run writes the file, so the command does not retry.
        std::filesystem::last_write_time(
            file, std::filesystem::file_time_type::clock::now() - std::chrono::hours(1));
        processes[i] = std::make_unique<WeftProcess>(place, arguments, [] { alarm(60); });
      }
      for (int i = 0; i < at_a_time; ++i) {
        const int code = processes[i]->wait();
        const std::string err = processes[i]->err();
        EXPECT_NE(std::ranges::find(codes, code), codes.end()) << first + i << ": " << code << err;
        EXPECT_EQ(code == exit_code::done, err.empty()) << first + i << ": " << code << err;
        crashes_ += err.find("HDF5 crashed") != std::string::npos ? 1 : 0;
      }
    }
  }
  int crashes() const { return crashes_; }

 private:
  static std::filesystem::path write_into(const std::filesystem::path& folder,
                                          const std::string& name, const std::string& text) {
    std::ofstream(folder / name, std::ios::binary) << text;
    return folder / name;
  }
  mutable int crashes_ = 0;
};

// Under the sanitizers, each process takes ten times as long.
#ifdef __SANITIZE_ADDRESS__
constexpr int damages = 60;
#else
constexpr int damages = 300;
#endif

TEST_F(DamagedFile, InfoSaysWhatIsWrong) {
  expect_words(write_trajectory(), damages, {exit_code::done, exit_code::input_output},
               {"info", "file.h5"});
  RecordProperty("crashes", crashes());
}

TEST_F(DamagedFile, TheRefereeSaysWhatIsWrong) {
  expect_words(write_trajectory(), 60, {exit_code::done, exit_code::input_output},
               {"info", "--crossings", "file.h5"});
}

TEST_F(DamagedFile, ACaseWithItsShapeSaysWhatIsWrong) {
  expect_words(write_trajectory(), 90, {exit_code::done, exit_code::bad_case},
               {"check", "case.toml"}, R"(contact.enabled = false
[[body]]
name = "ball"
shape = { type = "file", path = "file.h5", dataset = "body/ball/triangles" }
)");
}

#ifndef WEFT_WITHOUT_GPU
TEST_F(DamagedFile, RenderSaysWhatIsWrong) {
  const std::string bytes = write_trajectory();
  std::mt19937 random(7);
  for (int trial = 0; trial < 8; ++trial) {
    write("file.h5", damaged(bytes, random));
    const Result result =
        weft({"render", "file.h5", "--width", "16", "--height", "16"}, [] { alarm(60); });
    EXPECT_TRUE(result.code == exit_code::done || result.code == exit_code::input_output)
        << result.code << result.err;
  }
}
#endif

// The calling process survives any crash of HDF5.
TEST(ReadingProcess, SurvivesACrash) {
  const ProcessEnd crashed = run_in_process([] {
    raise(SIGSEGV);
    return 0;
  });
  EXPECT_EQ(crashed.signal, SIGSEGV);
  EXPECT_EQ(describe_crash("run.h5", crashed.signal),
            "run.h5: is damaged: HDF5 crashed on reading it (Segmentation fault)");
  EXPECT_EQ(run_in_process([] { return 3; }).code, 3);
  EXPECT_EQ(run_in_process([] { return 3; }, {}, 1).code, 3);
  EXPECT_EQ(run_in_process([]() -> int { throw 1; }).signal, SIGABRT);
}

TEST(ReadingProcess, EndsWorkThatComesToNoEnd) {
  const auto work = [] {
    volatile bool goes_on = true;
    while (goes_on) {
    }
    return 0;
  };
  const ProcessEnd endless = run_in_process(work, {}, 0.5);
  EXPECT_EQ(endless.signal, SIGXCPU);
  EXPECT_EQ(describe_crash("run.h5", endless.signal),
            "run.h5: is damaged: HDF5 comes to no end of reading it");
}

}  // namespace
}  // namespace weft::sim::damaged_file_test
