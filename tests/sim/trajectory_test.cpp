#include "sim/trajectory/trajectory.h"
#include "sim/scene/texel_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/lsan_interface.h>
#endif

#include <algorithm>
#include <chrono>
#include <csignal>
#include <ctime>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <thread>

#include "sim/run/recorded_run.h"
#include "sim/simulation/simulation.h"
#include "tests/sim/simulated_case.h"
#include "tests/sim/trajectory_fixture.h"

namespace weft::sim::trajectory_test {
namespace {

class Trajectory : public TrajectoryFolder {
 protected:
  // The scene has a wrapped cloth, a body of two sewn patches and a floor that stays.
  static std::vector<TrajectoryBody> make_scene() {
    std::vector<TrajectoryBody> bodies;
    bodies.push_back(make_body("cloth & <co>", {{.rows = 4, .cols = 5, .wrap_u = true}}));
    bodies.back().thickness = 0.125;
    // The right column of the first patch is the left column of the second.
    bodies.push_back(make_body("sewn", {{.rows = 2, .cols = 3}, {.rows = 2, .cols = 3}},
                               {0, 1, 2, 3, 4, 5, 2, 6, 7, 5, 8, 9}));
    bodies.push_back(make_body("floor", {{.rows = 2, .cols = 2}}));
    bodies.back().moves = false;
    bodies.back().is_obstacle = true;
    return bodies;
  }
  // The scene with a vector and a number per texel.
  static std::vector<TrajectoryBody> make_scene_with_fields() {
    std::vector<TrajectoryBody> bodies = make_scene();
    for (TrajectoryBody& body : bodies) {
      if (body.moves)
        body.fields = {{"velocity", "m/s", "velocity", 3}, {"heat", "J", "warmth", 1}};
    }
    return bodies;
  }
  static std::vector<TrajectoryWriter::Series> make_series() {
    return {{"time", "s"}, {"energy", "J"}};
  }
  static void write(const std::string& path, int frames, const TrajectoryWriter::Options& options,
                    bool with_fields = false) {
    const std::vector<TrajectoryBody> bodies =
        with_fields ? make_scene_with_fields() : make_scene();
    const auto initial = scene_values(bodies, 0);
    TrajectoryWriter writer(path, bodies, make_series(), options, views(initial));
    for (int f = 0; f < frames; ++f) {
      const auto positions = scene_values(bodies, f);
      const auto velocities = scene_values(bodies, -f);
      const auto heats = scene_heats(bodies, f);
      FrameChannels channels;
      for (std::size_t b = 0; b < bodies.size(); ++b)
        channels.fields.push_back({numbers_of(velocities[b]), heats[b]});
      std::vector<double> records;
      for (const TrajectoryRecord& record : options.records) {
        for (int k = 0; k < record.components; ++k) records.push_back(10 * f + k);
      }
      channels.records = records;
      const std::vector<double> series = {0.1 * f, 1.0 / (1 + f)};
      writer.write_frame(0.1 * f, views(positions), channels, series);
      EXPECT_EQ(writer.frames(), f + 1);
    }
  }
};

TEST_F(Trajectory, ComesBackAsItWasWritten) {
  const std::string file = path("run.h5");
  // More than HDF5 stores in a small attribute.
  const std::string case_text = "# " + std::string(100000, 'x') + "\n[scene]\n";
  write(file, 3, {.title = "Drapé", .case_text = case_text}, true);
  EXPECT_EQ(files(), (std::vector<std::string>{"run.h5", "run.xdmf"}));

  const TrajectoryReader reader(file);
  ASSERT_EQ(reader.frames(), 3);
  EXPECT_EQ(reader.title(), "Drapé");
  EXPECT_EQ(reader.case_text(), case_text);
  const std::vector<TrajectoryBody> scene = make_scene();
  ASSERT_EQ(reader.bodies().size(), scene.size());
  for (std::size_t b = 0; b < scene.size(); ++b) {
    const TrajectoryBody& body = reader.bodies()[b];
    EXPECT_EQ(body.name, scene[b].name);
    EXPECT_EQ(body.moves, scene[b].moves);
    EXPECT_EQ(body.is_obstacle, scene[b].is_obstacle);
    EXPECT_EQ(body.thickness, scene[b].thickness);
    ASSERT_EQ(body.atlas.patches().size(), scene[b].atlas.patches().size());
    for (std::size_t p = 0; p < body.atlas.patches().size(); ++p) {
      EXPECT_EQ(body.atlas.patches()[p].rows, scene[b].atlas.patches()[p].rows);
      EXPECT_EQ(body.atlas.patches()[p].cols, scene[b].atlas.patches()[p].cols);
      EXPECT_EQ(body.atlas.patches()[p].wrap_u, scene[b].atlas.patches()[p].wrap_u);
      EXPECT_EQ(body.atlas.patches()[p].wrap_v, scene[b].atlas.patches()[p].wrap_v);
    }
    for (int t = 0; t < body.atlas.texel_count(); ++t) {
      EXPECT_EQ(body.atlas.particle_of_texel(t), scene[b].atlas.particle_of_texel(t));
    }
    for (int f = 0; f < 3; ++f) {
      EXPECT_EQ(reader.time(f), 0.1 * f);
      const int shown = body.moves ? f : 0;
      EXPECT_EQ(reader.positions(static_cast<int>(b), f), scene_values(scene, shown)[b]);
      const auto velocities = reader.velocities(static_cast<int>(b), f);
      EXPECT_EQ(velocities, body.moves ? scene_values(scene, -f)[b] : std::vector<Vec3>{});
    }
  }
}

// A field has the shape of the positions, without the last axis for numbers; a record has a value
// per frame. Both name their channel.
TEST_F(Trajectory, ChannelsComeBackAsTheyWereWritten) {
  const std::string file = path("run.h5");
  const std::vector<TrajectoryRecord> records = {
      {"reactions/floor/force", "N", "reactions", 3},
      {"reactions/sewn/pin_1/force", "N", "reactions", 3},
      {"largest_stretch_place/row", "1", "largest_stretch_place", 1}};
  write(file, 3, {.records = records}, true);
  EXPECT_EQ(read_numbers<float>(file, "/body/sewn/heat").size(), 3 * 2 * 2 * 3);
  const TrajectoryReader reader(file);
  EXPECT_EQ(reader.records(), records);
  EXPECT_EQ(reader.record_values("reactions/sewn/pin_1/force"),
            (std::vector<double>{0, 1, 2, 10, 11, 12, 20, 21, 22}));
  EXPECT_EQ(reader.record_values("largest_stretch_place/row"), (std::vector<double>{0, 10, 20}));
  const std::vector<TrajectoryBody> scene = make_scene_with_fields();
  for (std::size_t b = 0; b < scene.size(); ++b) {
    EXPECT_EQ(reader.bodies()[b].fields, scene[b].fields);
    if (!scene[b].moves) continue;
    for (int f = 0; f < 3; ++f)
      EXPECT_EQ(reader.field_values(static_cast<int>(b), "heat", f), scene_heats(scene, f)[b]);
  }
  EXPECT_NE(message_of([&] { reader.field_values(0, "cold", 0); }).find("has no field cold"),
            std::string::npos);
  EXPECT_NE(message_of([&] { reader.record_values("reactions"); }).find("has no record"),
            std::string::npos);
}

TEST_F(Trajectory, SeriesKeepOrderUnitsAndValues) {
  write(path("run.h5"), 300, {});  // more than two chunks
  const TrajectoryReader reader(path("run.h5"));
  ASSERT_EQ(reader.series().size(), 2);
  EXPECT_EQ(reader.series()[0].name, "time");
  EXPECT_EQ(reader.series()[1].units, "J");
  const std::vector<double> energy = reader.series_values("energy");
  ASSERT_EQ(energy.size(), 300);
  for (int f = 0; f < 300; ++f) EXPECT_EQ(energy[f], 1.0 / (1 + f));
  EXPECT_NE(message_of([&] { reader.series_values("heat"); }).find("no series heat"),
            std::string::npos);
  EXPECT_TRUE(reader.velocities(0, 0).empty());
}

TEST_F(Trajectory, CanBeReadWhileItIsWritten) {
  const std::vector<TrajectoryBody> bodies = make_scene();
  const auto values = scene_values(bodies, 0);
  TrajectoryWriter writer(path("run.h5"), bodies, {}, {}, views(values));
  EXPECT_EQ(TrajectoryReader(path("run.h5")).frames(), 0);
  writer.write_frame(0.5, views(values), {}, {});
  const TrajectoryReader reader(path("run.h5"));
  ASSERT_EQ(reader.frames(), 1);
  writer.write_frame(1.0, views(values), {}, {});
  EXPECT_EQ(reader.frames(), 1);
  EXPECT_EQ(reader.positions(0, 0), values[0]);
}

TEST_F(Trajectory, FramesWaitForTheirCommit) {
  const std::vector<TrajectoryBody> bodies = make_scene();
  const auto values = scene_values(bodies, 0);
  const auto there = [&] { return TrajectoryReader(path("run.h5")).frames(); };
  {
    TrajectoryWriter writer(path("run.h5"), bodies, {}, {.commit_interval = 1000}, views(values));
    const auto write = [&] { writer.write_frame(writer.frames(), views(values), {}, {}); };
    for (int frame = 0; frame < 4; ++frame) write();
    EXPECT_EQ(there(), 0);
    EXPECT_EQ(writer.frames(), 4);
    EXPECT_FALSE(writer.is_due(1));
    EXPECT_TRUE(writer.is_due(1000));
    writer.commit();
    EXPECT_EQ(there(), 4);
    EXPECT_FALSE(writer.is_due(1000));
    write();
    EXPECT_EQ(there(), 4);
    writer.commit();
    EXPECT_EQ(there(), 5);
    write();
  }
  EXPECT_EQ(there(), 6);
}

// After each call, every frame older than the interval is on disk.
TEST_F(Trajectory, AKillLosesNoMoreThanTheInterval) {
  using Clock = std::chrono::steady_clock;
  constexpr double interval = 0.05;
  const std::vector<TrajectoryBody> bodies = {make_body("cloth", {{.rows = 2, .cols = 2}})};
  const auto values = scene_values(bodies, 0);
  TrajectoryWriter writer(path("run.h5"), bodies, {}, {.commit_interval = interval}, views(values));
  const Clock::time_point start = Clock::now();
  const auto now = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  std::vector<double> written;  // when
  std::set<int> sizes;
  while (now() < 8 * interval) {
    const double before = now();
    writer.write_frame(before, views(values), {}, {});
    written.push_back(now());
    const auto old = std::count_if(written.begin(), written.end(),
                                   [&](double time) { return time <= before - interval; });
    const int there = TrajectoryReader(path("run.h5")).frames();
    ASSERT_GE(there, old);
    sizes.insert(there);
  }
  EXPECT_GE(sizes.size(), 2);
  EXPECT_LE(static_cast<double>(sizes.size()), now() / interval + 1);
}

TEST_F(Trajectory, FramesThatWaitTakeBoundedMemory) {
  const std::vector<TrajectoryBody> bodies = {make_body("cloth", {{.rows = 1000, .cols = 1000}})};
  const auto values = scene_values(bodies, 0);
  TrajectoryWriter writer(path("run.h5"), bodies, {}, {.commit_interval = 1000}, views(values));
  std::vector<int> there;
  for (int frame = 0; frame < 8; ++frame) {
    writer.write_frame(frame, views(values), {}, {});
    there.push_back(TrajectoryReader(path("run.h5")).frames());
  }
  // 12 MB each: six are more than 64 MiB.
  EXPECT_EQ(there, (std::vector<int>{0, 0, 0, 0, 0, 6, 6, 6}));
}

// Returns everything in a file, by name: the shapes and the bytes of datasets.
std::map<std::string, std::string> all_data(const std::string& file_name) {
  std::map<std::string, std::string> data;
  const hid_t file = H5Fopen(file_name.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const auto add = [](hid_t root, const char* name, const H5O_info_t* info, void* all) {
    std::string& bytes = (*static_cast<std::map<std::string, std::string>*>(all))[name];
    if (info->type != H5O_TYPE_DATASET || std::string_view(name) == "case") return herr_t{0};
    const hid_t dataset = H5Dopen2(root, name, H5P_DEFAULT);
    const hid_t space = H5Dget_space(dataset);
    const hid_t type = H5Dget_type(dataset);
    hsize_t shape[5] = {};
    const int rank = H5Sget_simple_extent_dims(space, shape, nullptr);
    for (int axis = 0; axis < rank; ++axis) bytes += std::to_string(shape[axis]) + " ";
    const std::size_t header = bytes.size();
    bytes.resize(header +
                 static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)) * H5Tget_size(type));
    const herr_t result =
        H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data() + header);
    H5Tclose(type);
    H5Sclose(space);
    H5Dclose(dataset);
    return result;
  };
  EXPECT_GE(H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_INC, add, &data, H5O_INFO_BASIC), 0);
  H5Fclose(file);
  return data;
}

TEST_F(Trajectory, CommitsDoNotChangeWhatIsInTheFile) {
  write(path("frames.h5"), 300, {}, true);
  write(path("batches.h5"), 300, {.commit_interval = 0.003}, true);
  write(path("batch.h5"), 300, {.commit_interval = 1000}, true);
  const auto data = all_data(path("frames.h5"));
  EXPECT_GT(data.size(), 900);
  EXPECT_TRUE(data == all_data(path("batches.h5")));
  EXPECT_TRUE(data == all_data(path("batch.h5")));
  const std::string sidecar = contents(path("frames.xdmf"));
  for (const char* name : {"batches", "batch"}) {
    std::string other = contents(path(std::string(name) + ".xdmf"));
    for (auto at = other.find(name + std::string(".h5")); at != std::string::npos;
         at = other.find(name + std::string(".h5"), at)) {
      other.replace(at, std::string_view(name).size(), "frames");
    }
    EXPECT_TRUE(sidecar == other) << name;
  }
}

TEST_F(Trajectory, SameRunMakesTheSameBytes) {
  write(path("a.h5"), 3, {});
  // By default HDF5 stores creation times in whole seconds, so the second write waits for another
  // second.
  const std::time_t second = std::time(nullptr);
  while (std::time(nullptr) == second) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  write(path("b.h5"), 3, {});
  EXPECT_EQ(contents(path("a.h5")), contents(path("b.h5")));
}

TEST_F(Trajectory, OverwritesOnlyByForce) {
  write(path("run.h5"), 2, {.title = "first"});
  const auto again = [&] { write(path("run.h5"), 1, {.title = "second"}); };
  EXPECT_NE(message_of(again).find("run.h5: exists already"), std::string::npos);
  EXPECT_EQ(TrajectoryReader(path("run.h5")).title(), "first");
  write(path("run.h5"), 1, {.title = "second", .force = true});
  EXPECT_EQ(TrajectoryReader(path("run.h5")).title(), "second");

  std::filesystem::remove(path("run.h5"));
  EXPECT_NE(message_of(again).find("run.xdmf: exists already"), std::string::npos);
  EXPECT_EQ(files(), std::vector<std::string>{"run.xdmf"});
  EXPECT_NE(message_of([&] { write(path("run.xdmf"), 1, {.force = true}); }).find(".xdmf"),
            std::string::npos);
}

TEST_F(Trajectory, SaysWhyAFileCannotBeMade) {
  const std::string nowhere = path("missing/run.h5");
  EXPECT_EQ(message_of([&] { write(nowhere, 1, {}); }),
            nowhere + ": cannot create: No such file or directory");
  std::ofstream(path("file")) << "text";
  EXPECT_NE(message_of([&] { write(path("file/run.h5"), 1, {}); }).find("Not a directory"),
            std::string::npos);
  ASSERT_EQ(mkfifo(path("pipe.h5").c_str(), 0600), 0);
  EXPECT_NE(message_of([&] { write(path("pipe.h5"), 1, {.force = true}); }).find("is no file"),
            std::string::npos);
  std::filesystem::create_directory(path("folder.h5"));
  EXPECT_NE(
      message_of([&] { write(path("folder.h5"), 1, {.force = true}); }).find("is a directory"),
      std::string::npos);
}

// The sidecar has the longest name while it is made.
TEST_F(Trajectory, LeavesNothingWhereTheNameOfTheSidecarIsTooLong) {
  const std::size_t longest = 255, added = (".xdmf." + std::to_string(getpid()) + ".tmp").size();
  const std::string long_stem(longest - added + 1, 'x'), stem(longest - added, 'x');
  const std::string message = message_of([&] { write(path(long_stem + ".h5"), 1, {}); });
  EXPECT_NE(message.find("File name too long"), std::string::npos) << message;
  EXPECT_EQ(files(), std::vector<std::string>{});
  write(path(stem + ".h5"), 1, {});
  EXPECT_EQ(files(), (std::vector<std::string>{stem + ".h5", stem + ".xdmf"}));
}

// A limit on the size of files simulates a full disk: in both cases write() fails with an error.
TEST_F(Trajectory, KeepsWhatIsThereWhenTheDiskIsFull) {
  const std::vector<TrajectoryBody> bodies = {make_body("cloth", {{.rows = 20, .cols = 20}})};
  rlimit before;
  getrlimit(RLIMIT_FSIZE, &before);
  const auto restore = [&] { setrlimit(RLIMIT_FSIZE, &before); };
  std::signal(SIGXFSZ, SIG_IGN);
  // The limits vary, so that every kind of write is the first to fail.
  for (rlim_t limit = 60000; limit < 200000; limit += 1777) {
    const std::string file = path("run.h5");
    int written = 0;
    std::string message, second;
    rlimit small = before;
    small.rlim_cur = limit;
    setrlimit(RLIMIT_FSIZE, &small);
    try {
      const auto initial = scene_values(bodies, 0);
      TrajectoryWriter writer(file, bodies, {}, {.force = true}, views(initial));
      const auto next = [&] {
        const auto values = scene_values(bodies, written);
        writer.write_frame(written, views(values), {}, {});
        ++written;
      };
      message = message_of([&] {
        while (written < 1000) next();
      });
      second = message_of(next);
    } catch (const FileError& error) {
      restore();
      FAIL() << "limit " << limit << ": " << error.what();
    }
    restore();
    EXPECT_NE(message.find("File too large"), std::string::npos) << message;
    EXPECT_NE(second.find("no frame can follow"), std::string::npos) << second;
    ASSERT_GT(written, 0);
    EXPECT_EQ(H5Fget_obj_count(static_cast<hid_t>(H5F_OBJ_ALL), H5F_OBJ_ALL), 0);
    const TrajectoryReader reader(file);
    ASSERT_EQ(reader.frames(), written);
    for (int f = 0; f < written; ++f) EXPECT_EQ(reader.positions(0, f), scene_values(bodies, f)[0]);
  }
  std::signal(SIGXFSZ, SIG_DFL);
}

TEST_F(Trajectory, SaysWhatIsWrongWithAFile) {
  const auto error_of = [&](const std::string& name) {
    return message_of([&] { const TrajectoryReader reader(path(name)); });
  };
  EXPECT_EQ(error_of("none.h5"), path("none.h5") + ": no such file");
  EXPECT_NE(error_of("").find("is a directory"), std::string::npos);
  { const std::ofstream empty(path("empty.h5")); }
  std::ofstream(path("text.h5")) << std::string(5000, 'a');
  for (const char* name : {"empty.h5", "text.h5"}) {
    EXPECT_NE(error_of(name).find("cannot open as an HDF5 file"), std::string::npos)
        << error_of(name);
  }
}

// An incomplete copy is refused with a reason; nothing crashes.
TEST_F(Trajectory, RefusesTruncatedFiles) {
  write(path("run.h5"), 3, {});
  const std::string whole = contents(path("run.h5"));
  for (std::size_t size = 0; size < whole.size(); size += 1009) {
    std::ofstream(path("cut.h5"), std::ios::binary) << whole.substr(0, size);
    const std::string message = message_of([&] { const TrajectoryReader reader(path("cut.h5")); });
    EXPECT_EQ(message.find(path("cut.h5") + ": "), 0) << message;
  }
}

// While it lives, the leak sanitizer ignores allocations of this thread: HDF5 1.10 does not free
// headers that it has read with a wrong checksum. Handles are counted instead.
class HeadersThatHdf5Loses {
 public:
#if defined(__SANITIZE_ADDRESS__)
  HeadersThatHdf5Loses() { __lsan_disable(); }
  ~HeadersThatHdf5Loses() { __lsan_enable(); }
#else
  HeadersThatHdf5Loses() {}
#endif
  HeadersThatHdf5Loses(const HeadersThatHdf5Loses&) = delete;
  HeadersThatHdf5Loses& operator=(const HeadersThatHdf5Loses&) = delete;
};

// A piece that its writer was just replacing during the read is whole the next time.
TEST_F(Trajectory, LooksAgainAtAPieceThatIsBeingReplaced) {
  const HeadersThatHdf5Loses lost;
  write(path("run.h5"), 3, {});
  const std::string whole = contents(path("run.h5"));
  // The byte is in the header of the first object in the file.
  const std::size_t inside = whole.find("OHDR") + 24;
  ASSERT_LT(inside, whole.size());
  const auto put = [&](char byte) {
    std::fstream file(path("run.h5"), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(inside));
    file.put(byte);
  };
  put(static_cast<char>(~whole[inside]));
  const auto start = std::chrono::steady_clock::now();
  const std::string message = message_of([&] { const TrajectoryReader reader(path("run.h5")); });
  EXPECT_NE(message.find("checksum"), std::string::npos) << message;
  EXPECT_GT(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(100));
  EXPECT_EQ(H5Fget_obj_count(H5F_OBJ_ALL, H5F_OBJ_ALL), 0);
  std::thread writer([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    put(whole[inside]);
  });
  const TrajectoryReader reader(path("run.h5"));
  writer.join();
  EXPECT_EQ(reader.frames(), 3);
}

TEST_F(Trajectory, SidecarListsEveryFrameAndBody) {
  write(path("run.h5"), 2, {}, true);
  const std::string xml = contents(path("run.xdmf"));
  const auto count = [&](const std::string& what) {
    int found = 0;
    for (auto at = xml.find(what); at != std::string::npos; at = xml.find(what, at + 1)) ++found;
    return found;
  };
  EXPECT_EQ(count("<Time Value="), 2);
  EXPECT_EQ(count("<Time Value=\"0.10000000000000001\"/>"), 1);
  EXPECT_EQ(count("<Grid Name=\"cloth &amp; &lt;co&gt;\">"), 2);
  EXPECT_EQ(count("Dimensions=\"20 3\">run.h5:/frame/0/0/1/position/cloth &amp; &lt;co&gt;<"), 1);
  EXPECT_EQ(count("Dimensions=\"12 3\">run.h5:/frame/0/0/0/velocity/sewn<"), 1);
  // A surface at rest is described once, after those that move, and included by later frames.
  EXPECT_EQ(count("Dimensions=\"4 3\">run.h5:/body/floor/position<"), 1);
  EXPECT_GT(xml.find("<Grid Name=\"floor\">"), xml.find("<Grid Name=\"sewn\">"));
  EXPECT_EQ(count("<xi:include "), 1);
  EXPECT_EQ(count("xpointer(/Xdmf/Domain/Grid/Grid[1]/Grid[position()&gt;2])"), 1);
  EXPECT_EQ(count("<Grid"), count("</Grid>"));
  EXPECT_EQ(xml.substr(xml.size() - 8), "</Xdmf>\n");
}

// The text of a place in the sidecar, without its escapes.
std::string unescaped(std::string text) {
  for (const auto& [escape, character] :
       {std::pair{"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&amp;", "&"}}) {
    for (auto at = text.find(escape); at != std::string::npos; at = text.find(escape, at + 1))
      text.replace(at, std::string(escape).size(), character);
  }
  return text;
}

// Every place that the sidecar names is a dataset of the stated size, and the view of a frame has
// the numbers of this frame.
TEST_F(Trajectory, SidecarNamesEveryFieldOfEveryFrame) {
  constexpr int frames = 3;
  write(path("run.h5"), frames, {}, true);
  const std::string xml = contents(path("run.xdmf"));
  const std::regex item(R"re(Dimensions="([0-9 ]+)">run\.h5:([^<]+)<)re");
  std::set<std::string> views;
  for (std::sregex_iterator found(xml.begin(), xml.end(), item), end; found != end; ++found) {
    const std::string place = unescaped((*found)[2]);
    std::istringstream sizes((*found)[1]);
    std::size_t count = 1;
    for (std::size_t size; sizes >> size;) count *= size;
    if (!place.starts_with("/frame/")) {
      EXPECT_EQ(read_numbers<int>(path("run.h5"), place).size(), count) << place;
      continue;
    }
    views.insert(place);
    const std::string of_frame = place.substr(std::string("/frame/0/0/").size());
    const int frame = std::stoi(of_frame);
    const std::size_t name = of_frame.find('/') + 1, body = of_frame.find('/', name) + 1;
    const std::vector<float> all =
        read_numbers<float>(path("run.h5"), "/body/" + of_frame.substr(body) + '/' +
                                                of_frame.substr(name, body - 1 - name));
    ASSERT_EQ(all.size(), frames * count) << place;
    const auto first = all.begin() + static_cast<std::ptrdiff_t>(frame * count);
    EXPECT_EQ(read_numbers<float>(path("run.h5"), place),
              std::vector<float>(first, first + static_cast<std::ptrdiff_t>(count)))
        << place;
  }
  // Positions, velocities and heats of two bodies that move.
  EXPECT_EQ(views.size(), 3 * 2 * frames);
  const std::string heat =
      "     <Attribute Name=\"heat\" AttributeType=\"Scalar\" Center=\"Node\">\n"
      "      <DataItem Format=\"HDF\" NumberType=\"Float\" Precision=\"4\" Dimensions=\"12\">"
      "run.h5:/frame/0/0/2/heat/sewn</DataItem>\n     </Attribute>\n";
  EXPECT_NE(xml.find(heat), std::string::npos);
  EXPECT_NE(xml.find("<Attribute Name=\"velocity\" AttributeType=\"Vector\" Center=\"Node\">"),
            std::string::npos);
}

TEST_F(Trajectory, ReadsFileShapes) {
  write(path("run.h5"), 1, {});
  const TexelFile floor = read_texels(path("run.h5"), "/body/floor/position");
  EXPECT_EQ(floor.patches, 1);
  EXPECT_EQ(floor.rows, 2);
  EXPECT_EQ(floor.cols, 2);
  EXPECT_EQ(floor.texels, scene_values(make_scene(), 0)[2]);
  // One frame of one patch has the shape of several patches.
  const TexelFile frame = read_texels(path("run.h5"), "/body/cloth & <co>/position");
  EXPECT_EQ(frame.patches, 1);
  EXPECT_EQ(frame.texels, scene_values(make_scene(), 0)[0]);
  write(path("long.h5"), 3, {});
  EXPECT_NE(message_of([&] {
              read_texels(path("long.h5"), "/body/cloth & <co>/position");
            }).find("has the 3 frames of a run"),
            std::string::npos);
  for (const char* name : {"/time", "/body/sewn/position", "/body/sewn/triangles", "/case"}) {
    EXPECT_NE(message_of([&] { read_texels(path("run.h5"), name); }).find("must be numbers shaped"),
              std::string::npos)
        << name;
  }
  EXPECT_EQ(message_of([&] { read_texels(path("run.h5"), "/body/floor/positon"); }),
            path("run.h5") +
                ": has no dataset \"/body/floor/positon\"; did you mean \"/body/floor/position\"?");
  EXPECT_NE(message_of([&] {
              read_texels(path("run.h5"), "/none");
            }).find("has no dataset \"/none\"; expected one of \"/body/"),
            std::string::npos);
}

// ParaView draws closed surfaces: every edge is used once in each direction.
TEST_F(Trajectory, TrianglesOfWrappedSurfacesClose) {
  const std::vector<TrajectoryBody> bodies = {
      make_body("torus", {{.rows = 4, .cols = 3, .wrap_u = true, .wrap_v = true}})};
  const auto values = scene_values(bodies, 0);
  { const TrajectoryWriter writer(path("run.h5"), bodies, {}, {}, views(values)); }
  const std::vector<int> corners = read_numbers<int>(path("run.h5"), "/body/torus/triangles");
  ASSERT_EQ(corners.size(), 3 * 24);
  std::set<std::pair<int, int>> edges;
  for (std::size_t c = 0; c < corners.size(); ++c) {
    const std::size_t next = c % 3 == 2 ? c - 2 : c + 1;
    EXPECT_TRUE(edges.emplace(corners[c], corners[next]).second);
  }
  for (const auto& [from, to] : edges) EXPECT_TRUE(edges.contains({to, from}));
}

// A watched simulation of the same case has the same energies after its steps. Without the key,
// the file has none.
TEST_F(Trajectory, HoldsEnergiesOfStepsOnRequest) {
  class Watcher final : public StepObserver {
   public:
    void after_step(const Simulation& simulation) override {
      energies.push_back(static_cast<float>(simulation.energies().total()));
    }
    std::vector<float> energies;
  } watcher;
  const auto scene_with = [](const std::string& requested) {
    return build_scene(parse_case(
        hanging_sheet, "test.toml",
        {"time.method=verlet", "time.duration=0.02", "output.step_energies=" + requested}));
  };
  const auto recorded_to = [&](const Scene& scene, const std::string& name) {
    RunOptions options;
    options.trajectory = path(name);
    return run_simulation(scene, options).status;
  };
  const auto scene = scene_with("true");
  ASSERT_EQ(recorded_to(*scene, "with.h5"), RunReport::Status::done);
  Simulation simulation(*scene);
  simulation.add_observer(watcher);
  while (simulation.time() < 0.02) ASSERT_FALSE(simulation.step());
  EXPECT_GT(watcher.energies.size(), 10U);
  EXPECT_EQ(read_numbers<float>(path("with.h5"), "/steps/energy_total"), watcher.energies);

  ASSERT_EQ(recorded_to(*scene_with("false"), "without.h5"), RunReport::Status::done);
  const hid_t file = H5Fopen(path("without.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  EXPECT_GT(H5Lexists(file, "/steps/step_size", H5P_DEFAULT), 0);
  EXPECT_EQ(H5Lexists(file, "/steps/energy_total", H5P_DEFAULT), 0);
  H5Fclose(file);
}

}  // namespace
}  // namespace weft::sim::trajectory_test
