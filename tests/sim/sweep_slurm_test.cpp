// Sweeps that are submitted to Slurm, whose tools are scripts of this test. The script of CMake's
// test sim.sweep_by_slurm uses the real ones.
#include <cstdlib>
#include <ctime>

#include "sim/command/run_command.h"
#include "tests/sim/weft_process.h"

namespace weft::sim::sweep_slurm_test {
namespace {

namespace fs = std::filesystem;

class SweepSlurmTest : public WeftCommand {
 protected:
  SweepSlurmTest() {
    write("base.toml", R"([time]
duration = 0.02
[material.cotton]
density = 0.2
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [4, 4] }
)");
    write("sweep.toml", R"(case = "base.toml"
[factors]
"material.cotton.density" = { range = [0.1, 0.4], count = 7 }
)");
    fs::create_directory(path("bin"));
    write_tool("sbatch", "cp \"$2\" " + path("submitted.sh").string() + "; echo '42;cluster'");
    write_tool("squeue", "[ -e " + path("live").string() + " ] && echo '42 main'; exit 0");
    write_tool("scontrol", "echo 'MaxArraySize            = 5'");
  }

  void write_tool(const std::string& name, const std::string& text) const {
    write("bin/" + name, "#!/bin/sh\n" + text + "\n");
    fs::permissions(path("bin/" + name), fs::perms::owner_all);
  }
  // Runs a task of the script that was submitted, and returns its exit status.
  int run_task(const std::string& task) const {
    return std::system(("SLURM_ARRAY_TASK_ID=" + task + " bash " + path("submitted.sh").string() +
                        " > /dev/null 2>&1")
                           .c_str());
  }
  // Computes a slice of the list that was submitted, and none of the others.
  int run_slice(const std::string& slice) const {
    return weft({"sweep", "work", "out", "--list", "out/slurm/to_do.json", "--slice", slice,
                 "--only-slice"})
        .code;
  }
  Result submit(std::vector<std::string> more) const {
    std::vector<std::string> words{"sweep", "sweep.toml", "-o", "out", "--engine", "slurm"};
    words.insert(words.end(), more.begin(), more.end());
    const std::string search = path("bin").string() + ":" + std::getenv("PATH");
    return weft(words, [&] { setenv("PATH", search.c_str(), 1); });
  }
};

TEST_F(SweepSlurmTest, SubmitsOneArrayWhoseTasksComputeThePlan) {
  const Result result =
      submit({"--tasks", "3", "--tasks-at-a-time", "2", "--sbatch=--time=2:00:00"});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out,
            "job 42 of 3 tasks submitted for 7 runs; weft sweep status out tells how it goes\n");
  const std::string script = read_bytes(path("submitted.sh"));
  for (const char* line :
       {"#SBATCH --job-name=sweep\n", "#SBATCH --array=0-2%2\n", "#SBATCH --cpus-per-task=1\n",
        "#SBATCH --signal=B:USR1@90\n", "#SBATCH --time=2:00:00\n"})
    EXPECT_NE(script.find(line), std::string::npos) << script;
  for (const char* task : {"0", "1", "2"}) EXPECT_EQ(run_task(task), 0);
  const Result status = weft({"sweep", "status", "out"});
  EXPECT_EQ(status.out, "7 runs: 7 done\n");
  const Result again = submit({});
  EXPECT_EQ(again.out, "no run is to be done; nothing was submitted\n");
}

TEST_F(SweepSlurmTest, ASubmissionTakesTheRunsThatAreLeft) {
  ASSERT_EQ(submit({"--tasks", "7", "--sbatch=--no-requeue"}).code, exit_code::bad_case);
  ASSERT_EQ(submit({"--tasks", "4", "--retry", "2", "--fail-fast", "--wall-time", "1000"}).code, 0);
  const std::string script = read_bytes(path("submitted.sh"));
  EXPECT_NE(script.find(" --jobs 1 --threads 1 --retry 2 --fail-fast --wall-time 1000\n"),
            std::string::npos)
      << script;
  EXPECT_EQ(run_slice("1/4"), 0);  // two runs
  const Result second = submit({"--tasks", "5"});
  EXPECT_EQ(second.out,
            "job 42 of 5 tasks submitted for 5 runs; weft sweep status out tells how it goes\n");
  // Task 4 of the new list has a run, where the whole plan would give it one that is done.
  EXPECT_EQ(run_slice("4/5"), 0);
  EXPECT_EQ(weft({"sweep", "status", "out"}).out, "7 runs: 3 done, 4 not begun\n");
}

TEST_F(SweepSlurmTest, TasksStopBeforeTheirJobEnds) {
  write("sweep.toml", "case = \"base.toml\"\n[factors]\n\"time.duration\" = { list = [1e6] }\n");
  ASSERT_EQ(weft({"sweep", "plan", "sweep.toml", "-o", "out"}).code, 0);
  write_tool("squeue", "echo \"$*\" > " + path("asked").string() + "; echo $(($(date +%s) + 4))");
  const auto in_job = [&](const char* end) {
    const std::string search = path("bin").string() + ":" + std::getenv("PATH");
    // The run alone would take days.
    const Result result = weft({"sweep", "work", "out"}, [&] {
      setenv("PATH", search.c_str(), 1);
      setenv("SLURM_JOB_ID", "42", 1);
      setenv("SLURM_ARRAY_JOB_ID", "42", 1);
      setenv("SLURM_ARRAY_TASK_ID", "3", 1);
      if (end != nullptr) setenv("SLURM_JOB_END_TIME", end, 1);
    });
    EXPECT_EQ(result.code, 128 + SIGTERM) << result.err;
    EXPECT_NE(result.err.find("interrupted"), std::string::npos) << result.err;
  };
  in_job(nullptr);
  EXPECT_EQ(read_bytes(path("asked")), "--noheader --format=%e --jobs=42_3\n");
  in_job(std::to_string(std::time(nullptr) + 4).c_str());
}

TEST_F(SweepSlurmTest, RefusesASecondSubmissionOverALiveJob) {
  EXPECT_EQ(submit({}).code, 0);
  EXPECT_NE(read_bytes(path("submitted.sh")).find("--array=0-4\n"), std::string::npos);
  write("live", "");
  const Result second = submit({});
  EXPECT_EQ(second.code, exit_code::bad_case);
  EXPECT_NE(second.err.find("job 42 of this sweep has not ended"), std::string::npos) << second.err;
  fs::remove(path("live"));
  EXPECT_EQ(submit({}).code, 0);
}

TEST_F(SweepSlurmTest, RespectsTheClustersLimitsAndSaysWhatSbatchSaid) {
  const Result many = submit({"--tasks", "6"});
  EXPECT_EQ(many.code, exit_code::bad_case);
  EXPECT_NE(many.err.find("expected at most 5, its MaxArraySize"), std::string::npos) << many.err;
  write_tool("sbatch", "echo 'error: no such partition' >&2; exit 1");
  const Result refused = submit({});
  EXPECT_EQ(refused.code, exit_code::input_output);
  EXPECT_NE(refused.err.find("no such partition"), std::string::npos) << refused.err;
}

}  // namespace
}  // namespace weft::sim::sweep_slurm_test
