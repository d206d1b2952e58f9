// Input with false claims, deep nesting or odd names. It is refused in words, with the documented
// exit code, and leaves nothing behind.
#include <hdf5.h>
#include <sys/stat.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/case/case_reader.h"
#include "sim/case/memory_estimate.h"
#include "sim/command/run_command.h"
#include "sim/run/run_checkpoint.h"
#include "sim/scene/texel_file.h"
#include "sim/trajectory/trajectory.h"
#include "tests/sim/weft_process.h"

namespace weft::sim::command_bad_input_test {
namespace {

constexpr const char* sheet_case = R"(title = "A sheet"
time.duration = 0.05
contact.enabled = false
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [4, 5] }
)";

#ifdef WEFT_WITHOUT_GPU
constexpr bool can_render = false;
#else
constexpr bool can_render = true;
#endif

class CommandBadInput : public WeftCommand {
 protected:
  // A command that hangs is killed and fails the test.
  static void limit_time() { alarm(60); }

  void expect_refused(const WeftProcess::Arguments& arguments, int code,
                      const std::string& message) const {
    const Result result = weft(arguments, limit_time);
    EXPECT_EQ(result.code, code) << message;
    EXPECT_NE(result.err.find(message), std::string::npos) << message << "\nin\n" << result.err;
    EXPECT_EQ(result.out, "");
    EXPECT_FALSE(exists("out"));
  }
  // Runs the case by `check` and by `run`, which must give the same answer.
  void expect_case_refused(const WeftProcess::Arguments& more, const std::string& message) const {
    for (const char* command : {"check", "run"}) {
      WeftProcess::Arguments arguments{command};
      arguments.insert(arguments.end(), more.begin(), more.end());
      expect_refused(arguments, exit_code::bad_case, message);
    }
  }
  // Writes `trajectory.h5` of the sheet, or of another case.
  std::string write_trajectory(const std::string& text = sheet_case) const {
    write("trajectory.toml", text);
    EXPECT_EQ(weft({"run", "trajectory.toml", "--quiet", "-o", "."}).code, exit_code::done);
    return path("trajectory.h5").string();
  }
};

// Makes a dataset [rows, cols, 3] of float32 in which nothing is stored, optionally in chunks.
void write_claim(const std::string& path, hsize_t rows, hsize_t cols, bool chunked) {
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const std::array<hsize_t, 3> shape{rows, cols, 3}, chunk{64, 64, 3};
  const hid_t space = H5Screate_simple(3, shape.data(), nullptr);
  const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
  if (chunked) H5Pset_chunk(properties, 3, chunk.data());
  const hid_t dataset =
      H5Dcreate2(file, "positions", H5T_IEEE_F32LE, space, H5P_DEFAULT, properties, H5P_DEFAULT);
  EXPECT_GE(dataset, 0);
  H5Dclose(dataset);
  H5Pclose(properties);
  H5Sclose(space);
  H5Fclose(file);
}

// Changes a dataset of a file by `change`.
void change_dataset(const std::string& path, const std::string& name,
                    const std::function<herr_t(hid_t)>& change) {
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t dataset = H5Dopen2(file, name.c_str(), H5P_DEFAULT);
  EXPECT_GE(change(dataset), 0) << name;
  H5Dclose(dataset);
  H5Fclose(file);
}

TEST_F(CommandBadInput, RefusesAnOverrideThatIsNotUtf8) {
  write("sheet.toml", sheet_case);
  expect_case_refused({"sheet.toml", "--set", "title=\xff\xfe"},
                      "--set title=\\xff\\xfe: the value of \"title\" is not UTF-8\n"
                      "  expected text in UTF-8\n");
}

TEST_F(CommandBadInput, RefusesAResolutionBeyondTheMemory) {
  write("large.toml", R"(compute.memory_limit = 16000
contact.enabled = false
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [10000, 10000] }
[[obstacle]]
name = "floor"
shape = { type = "rectangle", size = [1, 1], resolution = [2, 2] }
)");
  expect_case_refused(
      {"large.toml"},
      "large.toml:5:59: the scene needs about 270 GiB of memory, more than the limit "
      "of 15.6 GiB\n"
      "  expected fewer vertices, or a larger compute.memory_limit\n");
}

TEST_F(CommandBadInput, RefusesListsOfContactBeyondTheMemory) {
  write("wide.toml", R"([compute]
memory_limit = 60
[contact]
range = 1.5
[[body]]
name = "upper"
shape = { type = "rectangle", size = [1, 1], resolution = [33, 33] }
[[body]]
name = "lower"
position = [0, 0, -0.1]
shape = { type = "rectangle", size = [1, 1], resolution = [33, 33] }
)");
  expect_case_refused(
      {"wide.toml"},
      "wide.toml:8:1: the pairs of triangles and edges near each other of \"upper\" and "
      "\"lower\" take more memory than the limit of 60 MiB: thickness, contact.range or "
      "contact.search_slack is many edges long\n"
      "  expected fewer vertices, shorter distances, or a larger compute.memory_limit\n");
}

// A thickness in mm for one in m: the lists of such a scene would take gigabytes.
TEST_F(CommandBadInput, RefusesAThicknessInTheWrongUnitAtOnce) {
  write("thick.toml", R"([compute]
memory_limit = 40
[[body]]
name = "sheet"
thickness = 2
shape = { type = "rectangle", size = [1, 1], resolution = [33, 33] }
[[obstacle]]
name = "ball"
position = [0, 0, -0.1]
shape = { type = "sphere", radius = 0.05, resolution = [33] }
)");
  expect_case_refused(
      {"thick.toml"},
      "thick.toml:7:1: the initial state cannot be simulated: no gap is left between the features "
      "at body \"sheet\", row 0, column 0 and obstacle \"ball\", patch 0, row 1, column 0 (gap "
      "-0.280588 m)\n  move the bodies apart, or make thickness smaller\n");
}

TEST_F(CommandBadInput, TakesASceneJustBelowTheMemoryLimit) {
  write("sheet.toml", sheet_case);
  Case source = read_case(path("sheet.toml").string());
  const double needed = estimate_memory(source, size_of_case(source)) / (1 << 20);
  const auto limit = [](double mebibytes) {
    return "compute.memory_limit=" + std::to_string(mebibytes);
  };
  const Result check = weft({"check", "sheet.toml", "--set", limit(1.001 * needed)});
  EXPECT_EQ(check.code, exit_code::done) << check.err;
  EXPECT_NE(check.out.find("memory    about 16.06 MiB of at most 16.07 MiB\n"), std::string::npos)
      << check.out;
  expect_case_refused({"sheet.toml", "--set", limit(0.999 * needed)},
                      "sheet.toml:6:63: the scene needs about 16.06 MiB of memory, more than the "
                      "limit of 16.04 MiB\n");
}

// Compares the estimate with the resident size of real runs.
TEST_F(CommandBadInput, EstimatesTheMemoryWithinAFactorOfTwo) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the address sanitizer keeps memory of its own";
#endif
  constexpr const char* fall = R"(time.duration = 1e-4
time.frames_per_second = 1e4
material.m.bending_stiffness = 1e-6
[[body]]
name = "sheet"
position = [0, 0, 0.0022]
shape = { type = "rectangle", size = [1, 1], resolution = [97, 97] }
[[obstacle]]
name = "floor"
shape = { type = "rectangle", size = [1.1, 1.1], resolution = [65, 65] }
)";
  write("fall.toml", fall);
  constexpr const char* plate = R"(time.duration = 1e-5
contact.enabled = false
world.gravity = [0, 0, 0]
[material.m]
model = "shell"
youngs_modulus = 1e6
poisson_ratio = 0.3
shell_thickness = 0.01
volume_density = 100
[[body]]
name = "plate"
shape = { type = "rectangle", size = [2, 1], resolution = [65, 33] }
)";
  write("plate.toml", plate);
  const std::pair<std::string, WeftProcess::Arguments> runs[] = {
      {"fall.toml", {"--set", "contact.enabled=false", "--set", "time.method=verlet"}},
      {"fall.toml", {"--set", "contact.enabled=false", "--set", "material.m.bending_stiffness=0"}},
      {"fall.toml", {"--set", "contact.enabled=false"}},
      {"fall.toml", {}},
      {"plate.toml", {}},
      {WEFT_CASES_DIR "/benchmarks/scordelis_lo.toml",
       {"--set", "body.roof.shape.resolution=[33,33]"}}};
  for (const auto& [file, overrides] : runs) {
    WeftProcess::Arguments run{"run", file, "--quiet", "--json", "--force", "-o", "out"};
    run.insert(run.end(), overrides.begin(), overrides.end());
    const Result result = weft(run, limit_time);
    ASSERT_EQ(result.code, exit_code::done) << result.err;
    const double used =
        1024 * 1024 * nlohmann::json::parse(result.out).at("peak_memory_mib").get<double>();
    EXPECT_GT(used, 1e6);
    std::vector<std::string> keys;
    for (std::size_t i = 1; i < overrides.size(); i += 2) keys.push_back(overrides[i]);
    const Case source = read_case((folder() / file).string(), keys);
    const double needed = estimate_memory(source, size_of_case(source));
    EXPECT_GT(needed, used / 2) << file << ' ' << testing::PrintToString(overrides);
    EXPECT_LT(needed, used * 2) << file << ' ' << testing::PrintToString(overrides);
  }
}

TEST_F(CommandBadInput, RefusesAShapeFileThatStoresLessThanItClaims) {
  write("file.toml", R"(contact.enabled = false
[[body]]
name = "sheet"
shape = { type = "file", path = "claim.h5", dataset = "positions" }
)");
  for (const bool chunked : {false, true}) {
    write_claim(path("claim.h5").string(), 32768, 32768, chunked);
    EXPECT_LT(std::filesystem::file_size(path("claim.h5")), 4000U);
    expect_case_refused({"file.toml"},
                        "file.toml:4:9: claim.h5: dataset positions claims 12884901888 bytes and "
                        "stores 0\n");
  }
}

TEST_F(CommandBadInput, RefusesAShapeFileBeyondTheMemory) {
  write_trajectory();
  write("file.toml", R"(contact.enabled = false
[[body]]
name = "sheet"
shape = { type = "file", path = "trajectory.h5", dataset = "body/sheet/triangles" }
)");
  expect_case_refused({"file.toml"}, "must be numbers shaped [rows, cols, 3]");
  write_claim(path("image.h5").string(), 64, 64, true);
  change_dataset(path("image.h5").string(), "positions", [](hid_t dataset) {
    std::vector<float> values(std::size_t{64} * 64 * 3);
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = std::sin(0.1F * static_cast<float>(i * (i % 3 + 1)));
    return H5Dwrite(dataset, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  });
  const auto shape = [](const char* limit) {
    return WeftProcess::Arguments{"file.toml",
                                  "--set",
                                  "body.sheet.shape.path=image.h5",
                                  "--set",
                                  "body.sheet.shape.dataset=positions",
                                  "--set",
                                  std::string("compute.memory_limit=") + limit};
  };
  try {
    read_texels(path("image.h5").string(), "positions", 50000);
    ADD_FAILURE();
  } catch (const FileError& error) {
    EXPECT_EQ(error.what(), path("image.h5").string() +
                                ": dataset positions takes 0.09375 MiB of memory, more than the "
                                "limit of 0.04768 MiB");
  }
  expect_case_refused(shape("20"),
                      "file.toml:4:9: the scene needs about 27.33 MiB of memory, more "
                      "than the limit of 20 MiB\n");
}

TEST_F(CommandBadInput, RefusesATrajectoryThatClaimsFramesItDoesNotStore) {
  const std::string file = write_trajectory();
  const std::string whole = read_bytes(file);
  const auto claim = [&](hsize_t frames) {
    write("trajectory.h5", whole);  // rewritten, since HDF5 takes minutes to shrink a claimed size
    change_dataset(file, "time", [&](hid_t time) { return H5Dset_extent(time, &frames); });
  };
  const std::vector<const char*> commands =
      can_render ? std::vector{"info", "render"} : std::vector{"info"};
  for (const char* command : commands) {
    claim(hsize_t{1} << 40);
    expect_refused({command, "trajectory.h5"}, exit_code::input_output,
                   "trajectory.h5: dataset time claims more frames than can be numbered\n");
    claim(hsize_t{1} << 30);
    expect_refused({command, "trajectory.h5"}, exit_code::input_output,
                   "trajectory.h5: dataset time claims 8589934592 bytes and stores 1024\n");
  }
}

TEST_F(CommandBadInput, RefusesAMapOfParticlesThatIsNoSurface) {
  const std::string file = write_trajectory(R"(time.duration = 0.02
contact.enabled = false
[[body]]
name = "ball"
shape = { type = "sphere", radius = 0.1, resolution = [3] }
)");
  change_dataset(file, "body/ball/particle", [](hid_t dataset) {
    std::array<int, 54> particles{};
    H5Dread(dataset, H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, particles.data());
    std::copy(particles.begin(), particles.begin() + 9, particles.begin() + 9);
    for (std::size_t i = 0; i < particles.size(); ++i) particles[i] = static_cast<int>(i % 9);
    return H5Dwrite(dataset, H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, particles.data());
  });
  const std::string message = "the image is not an orientable surface: the quad at patch 1, row 0";
  expect_refused({"info", "--crossings", "trajectory.h5"}, exit_code::input_output, message);
  if (!can_render) return;
  expect_refused({"render", "trajectory.h5"}, exit_code::input_output, message);
  EXPECT_FALSE(exists("pictures/frame_00000.png"));
}

TEST_F(CommandBadInput, RefusesToJudgePositionsThatAreNotFinite) {
  const std::string file = write_trajectory();
  change_dataset(file, "body/sheet/position", [](hid_t dataset) {
    const std::vector<float> nothing(std::size_t{4} * 4 * 5 * 3, std::nanf(""));
    return H5Dwrite(dataset, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, nothing.data());
  });
  expect_refused(
      {"info", "--crossings", "trajectory.h5"}, exit_code::input_output,
      "trajectory.h5: crossings cannot be counted: frame 0, body \"sheet\", patch 0 row 0 "
      "col 0 has a position that is not finite\n");
}

TEST_F(CommandBadInput, RefusesToDrawOverPicturesOfOthers) {
  if (!can_render) GTEST_SKIP() << "a build without gpu/ draws nothing";
  write_trajectory();
  std::filesystem::create_directory(path("pictures"));
  write("pictures/frame_00002.png", "mine");
  const WeftProcess::Arguments render{"render", "trajectory.h5", "--width", "16", "--height", "16"};
  expect_refused(
      render, exit_code::input_output,
      "pictures/frame_00002.png: was not made by weft render, and is only overwritten by "
      "force (--force)\n");
  EXPECT_EQ(read_bytes(path("pictures/frame_00002.png")), "mine");
  EXPECT_FALSE(exists("pictures/frame_00000.png"));
  WeftProcess::Arguments by_force = render;
  by_force.push_back("--force");
  EXPECT_EQ(weft(by_force, limit_time).code, exit_code::done);
  EXPECT_EQ(weft(render, limit_time).code, exit_code::done);
}

TEST_F(CommandBadInput, RefusesAPipe) {
  ASSERT_EQ(mkfifo(path("pipe.h5").c_str(), 0600), 0);
  expect_refused({"info", "pipe.h5"}, exit_code::input_output, "pipe.h5: is not a regular file\n");
  if (!can_render) return;
  expect_refused({"render", "pipe.h5"}, exit_code::input_output,
                 "pipe.h5: is not a regular file\n");
}

// Opening a pipe waits until another process writes to it.
TEST_F(CommandBadInput, RefusesPipesInAllPlacesOfFiles) {
  ASSERT_EQ(mkfifo(path("pipe").c_str(), 0600), 0);
  expect_case_refused({"pipe"}, "pipe: is not a regular file\n");
  write("include.toml", sheet_case + std::string("[[include]]\npath = \"pipe\"\n"));
  expect_case_refused({"include.toml"}, "include.toml:8:8: \"pipe\" is not a regular file\n");
  write("shape.toml",
        "[[body]]\nname = \"sheet\"\nshape = { type = \"file\", path = \"pipe\", dataset = \"x\" "
        "}\n");
  expect_case_refused({"shape.toml"}, "shape.toml:3:33: no file \"pipe\"\n");
  write("sheet.toml", sheet_case);
  write("sweep.toml", "case = \"pipe\"\n[factors]\n\"contact.friction\" = { list = [0.1] }\n");
  expect_refused({"sweep", "sweep.toml", "--dry-run"}, exit_code::bad_case,
                 "sweep.toml:1:8: \"pipe\" is not a regular file\n"
                 "  expected a case file, here pipe\n");
  expect_refused({"sweep", "pipe", "--dry-run"}, exit_code::bad_case,
                 "pipe: is not a regular file\n  expected a sweep file\n");
  const WeftProcess::Arguments run{"run", "sheet.toml", "--quiet", "-o", "made"};
  ASSERT_EQ(weft(run, limit_time).code, exit_code::done);
  std::filesystem::rename(path("pipe"), path("made/sheet.checkpoint"));
  expect_refused({"run", "sheet.toml", "--resume", "-o", "made"}, exit_code::input_output,
                 "made/sheet.checkpoint: is not a regular file\n");
}

TEST_F(CommandBadInput, RefusesOutputPathsThatCannotBeAccessed) {
  write("sheet.toml", sheet_case);
  std::filesystem::create_symlink("b", path("a"));
  std::filesystem::create_symlink("a", path("b"));
  const std::string loop = "a/sheet.h5: cannot be accessed: Too many levels of symbolic links";
  for (const WeftProcess::Arguments& more :
       {WeftProcess::Arguments{}, {"--force"}, {"--resume"}, {"--extend", "1"}}) {
    WeftProcess::Arguments arguments{"run", "sheet.toml", "-o", "a"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    expect_refused(arguments, exit_code::input_output, loop + "\n");
  }
  const Result json = weft({"run", "sheet.toml", "-o", "a", "--json"}, limit_time);
  EXPECT_EQ(json.code, exit_code::input_output);
  EXPECT_EQ(nlohmann::json::parse(json.out).at("reason"), loop);
  expect_refused({"modes", "sheet.toml", "-o", "a"}, exit_code::input_output,
                 "a/sheet_modes.h5: cannot be accessed: Too many levels of symbolic links\n");
  const std::string long_name(300, 'x');
  expect_refused({"run", "sheet.toml", "-o", long_name}, exit_code::input_output,
                 long_name + "/sheet.h5: cannot be accessed: File name too long\n");
  expect_refused(
      {"check", "sheet.toml", "--fix-initial", long_name, "--set", "contact.enabled=true"},
      exit_code::input_output, long_name + ": cannot be accessed: File name too long\n");
  if (can_render)
    expect_refused({"check", "sheet.toml", "--picture", long_name}, exit_code::input_output,
                   long_name + ": cannot be accessed: File name too long\n");
}

// The name of the trajectory is short enough, but not those of all files beside it.
TEST_F(CommandBadInput, RefusesACaseOfTooLongAName) {
  const std::string stem(245, 'x');
  write(stem + ".toml", sheet_case);
  expect_refused({"run", stem + ".toml"}, exit_code::input_output,
                 ": cannot create: File name too long\n");
  // The name of an unfinished checkpoint may be the longest one. No folder is made for it.
  const auto trajectory = path("new/" + std::string(241, 'x') + ".h5").string();
  EXPECT_THROW(refuse_foreign_checkpoint(trajectory, false), FileError);
}

TEST_F(CommandBadInput, SaysWhyAFileCannotBeRead) {
  std::filesystem::create_symlink("b.h5", path("a.h5"));
  std::filesystem::create_symlink("a.h5", path("b.h5"));
  const std::string loop = "a.h5: cannot be accessed: Too many levels of symbolic links\n";
  expect_refused({"info", "a.h5"}, exit_code::input_output, loop);
  expect_refused({"outputs", "a.h5"}, exit_code::input_output, loop);
  if (!can_render) return;
  expect_refused({"render", "a.h5"}, exit_code::input_output, loop);
  write_trajectory();
  expect_refused({"render", "trajectory.h5", "-o", "a.h5"}, exit_code::input_output,
                 "a.h5/frame_00000.png: cannot be accessed: Too many levels of symbolic links\n");
}

// Root may do everything, so the commands run as another user.
TEST_F(CommandBadInput, SaysWhatIsNotPermitted) {
  const auto become_nobody = [] {
    limit_time();
    constexpr uid_t nobody = 65534;
    if (geteuid() == 0 && (setgid(nobody) != 0 || setuid(nobody) != 0)) _exit(126);
  };
  write("sheet.toml", sheet_case);
  std::filesystem::permissions(folder(), std::filesystem::perms(0755));
  if (weft({"--version"}, become_nobody).code != exit_code::done)
    GTEST_SKIP() << "the command is in a folder that is closed to other users";
  write_trajectory();
  std::filesystem::permissions(path("trajectory.h5"), std::filesystem::perms::none);
  std::filesystem::create_directory(path("closed"));
  std::filesystem::permissions(path("closed"), std::filesystem::perms::none);
  const Result info = weft({"info", "trajectory.h5"}, become_nobody);
  EXPECT_EQ(info.code, exit_code::input_output);
  EXPECT_EQ(info.err, "trajectory.h5: cannot be read: Permission denied\n");
  const Result run = weft({"run", "sheet.toml", "-o", "closed"}, become_nobody);
  EXPECT_EQ(run.code, exit_code::input_output);
  EXPECT_EQ(run.err, "closed/sheet.h5: cannot be accessed: Permission denied\n");
  std::filesystem::permissions(path("closed"), std::filesystem::perms::owner_all);
}

TEST_F(CommandBadInput, RefusesALongKeyAtOnce) {
  const auto refusal = [&](std::size_t length) {
    write("key.toml", std::string(length, 'a') + " = 1\n" + sheet_case);
    const Result result = weft({"check", "key.toml"}, limit_time);
    EXPECT_EQ(result.code, exit_code::bad_case);
    return result.err;
  };
  EXPECT_EQ(refusal(30'000'000),
            "key.toml: is longer than 8 MiB\n"
            "  expected a case file; large shapes belong into HDF5 files (type = \"file\")\n");
  const std::string message = refusal(1'000'000);
  EXPECT_TRUE(message.starts_with("key.toml:1:1: unknown key \"" + std::string(80, 'a') +
                                  "...\" (1000000 bytes) in the case\n  expected one of \"title\""))
      << message.substr(0, 300);
}

// The character marks places of overrides within Weft.
TEST_F(CommandBadInput, TakesFilesOfOddNames) {
  const std::string name = "\x1e.toml";
  write(name, "title = 1\n");
  expect_case_refused({name}, "\\x1e.toml:1:9: \"title\" is a whole number\n");
}

// The sidecar would not be XML.
TEST_F(CommandBadInput, WritesNoSidecarOfANameThatXmlCannotHold) {
  for (const std::string& name : {std::string("caf\xe9"), std::string("a\x01")}) {
    write(name + ".toml", sheet_case);
    const Result run = weft({"run", name + ".toml", "--quiet", "--set", "time.duration=0.01"});
    EXPECT_EQ(run.code, exit_code::done) << run.err;
    EXPECT_NE(run.err.find("no .xdmf is written: XML cannot hold the name"), std::string::npos)
        << run.err;
    EXPECT_TRUE(exists("out/" + name + ".h5"));
    EXPECT_FALSE(exists("out/" + name + ".xdmf"));
  }
  write("caf\xc3\xa9.toml", sheet_case);
  EXPECT_EQ(weft({"run", "caf\xc3\xa9.toml", "--quiet", "--set", "time.duration=0.01"}).code,
            exit_code::done);
  EXPECT_TRUE(exists("out/caf\xc3\xa9.xdmf"));
}

// A comparison of two such names would take 80 GB of memory.
TEST_F(CommandBadInput, RefusesLongNamesOfWhatIsNotThere) {
  const std::string name(100'000, 'm');
  write("names.toml",
        sheet_case + ("material = \"" + name + "x\"\n") + "[material." + name + "]\n");
  expect_case_refused({"names.toml"}, "names.toml:7:12: ");
}

TEST_F(CommandBadInput, RefusesDeepKeysAndLongFiles) {
  std::string deep = "a";
  for (int part = 0; part < 1'000'000; ++part) deep += ".a";
  write("deep.toml", "title = \"x\"\n  " + deep + " = 1\n");
  expect_case_refused({"deep.toml"}, "deep.toml:2:1: a key of more than 1000 parts\n");
  write("sheet.toml", sheet_case);
  expect_case_refused({"sheet.toml", "--set", "title={" + deep.substr(0, 100'000) + "=1}"},
                      "a key of too many parts in the value\n");
  expect_case_refused({"/dev/zero"}, "/dev/zero: is not a regular file\n");
}

TEST_F(CommandBadInput, RefusesMoreThreadsThanThereCanBe) {
  write("sheet.toml", sheet_case);
  expect_case_refused({"sheet.toml", "--set", "compute.threads=1000000000"},
                      "--set compute.threads=1000000000: \"threads\" is 1000000000\n"
                      "  expected a whole number >= 1 and <= 1024 or \"auto\"\n");
}

// 2 n - 1 rows of this many columns exceed the range of an int.
TEST_F(CommandBadInput, RefusesABlobBeyondAnyNumber) {
  write("blob.toml", R"([[body]]
name = "blob"
shape = { type = "blob", radius = 1, resolution = [1073741829] }
)");
  expect_case_refused({"blob.toml"},
                      "blob.toml:3:51: too many vertices\n  expected at most 100000000\n");
}

// The case is refused late, when its contact search is set up.
TEST_F(CommandBadInput, LeavesNoFolderOfACaseThatIsRefusedLate) {
  write("sheet.toml", sheet_case);
  const Result result = weft({"run", "sheet.toml", "-o", "new/folder", "--set",
                              "contact.enabled=true", "--set", "compute.backend=gpu"},
                             [] { setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/dev/null", 1); });
  EXPECT_EQ(result.code, exit_code::bad_case) << result.err;
  EXPECT_NE(result.err.find("sheet.toml: compute.backend is \"gpu\": "), std::string::npos)
      << result.err;
  EXPECT_FALSE(exists("new"));
}

// True if the text has characters that a terminal obeys: all control characters except line ends.
bool has_control_characters(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto code = static_cast<unsigned char>(text[i]);
    const bool upper = code == 0xc2 && i + 1 < text.size() && (text[i + 1] & 0x60) == 0;
    if ((code < 0x20 && code != '\n') || code == 0x7f || upper) return true;
  }
  return false;
}

TEST_F(CommandBadInput, EscapesWhatTerminalsObey) {
  const std::string evil =
      "\x1b]0;mine\a\xc2\x9b"
      "2J\x7f\r\n";
  const std::string name = "\x1b[31mred";
  write(name + ".toml", "title = \"\\u001b]0;mine\\u0007\\u009b2J\\u007f\\r\\n\"\n" +
                            std::string(sheet_case).substr(18));
  write("bad.toml", "\"\\u001b[2J\" = 1\n");
  write("value.toml", "title = \"x\"\ntime.method = \"\\u001b[2J\\u009b\"\n");
  const std::string red = name + ".toml";
  const std::string output = "out/" + name + ".h5";
  const std::vector<std::pair<WeftProcess::Arguments, int>> commands = {
      {{"check", red}, exit_code::done},
      {{"check", "bad.toml"}, exit_code::bad_case},
      {{"check", "value.toml"}, exit_code::bad_case},
      {{"check", red, "--set", evil + "=1"}, exit_code::bad_case},
      {{"check", red, "--set", "time.method=" + evil}, exit_code::bad_case},
      {{"check", name}, exit_code::bad_case},
      {{"run", red}, exit_code::done},
      {{"run", red}, exit_code::input_output},
      {{"run", red, "--force", "--json"}, exit_code::done},
      {{"run", red, "--json", "-o", "\xff"}, exit_code::done},
      {{"info", output}, exit_code::done},
      {{"info", output, "--json"}, exit_code::done},
      {{"info", output, "--crossings"}, exit_code::done},
      {{"info", name}, exit_code::input_output},
      {{"info", evil, "--" + name}, exit_code::bad_case},
      {{name}, exit_code::bad_case}};
  for (const auto& [arguments, code] : commands) {
    const Result result = weft(arguments, limit_time);
    const std::string all = result.out + result.err;
    EXPECT_EQ(result.code, code) << testing::PrintToString(arguments) << all;
    EXPECT_FALSE(has_control_characters(all)) << testing::PrintToString(arguments) << all;
  }
  EXPECT_EQ(weft({"check", red}).out.substr(0, 34), "\\x1b]0;mine\\x07\\xc2\\x9b2J\\x7f\\r\\n\n");
  const Result json = weft({"info", output, "--json"});
  EXPECT_EQ(nlohmann::json::parse(json.out).at("title"), evil);
}

}  // namespace
}  // namespace weft::sim::command_bad_input_test
