// A trajectory whose writer dies must stay readable. One test sends real SIGKILLs at random
// moments. The others cover every moment: they record the writes and, after each of them, open and
// read the file so far. A write counts page by page, since a kernel may cut it short at a page.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <random>
#include <sstream>
#include <thread>

#include "tests/sim/trajectory_fixture.h"

// The test is linked with --wrap for these two functions, to see the writer's calls of the kernel.
extern "C" {
ssize_t __real_pwrite(int file, const void* bytes, size_t count, off_t offset);
int __real_ftruncate(int file, off_t size);
ssize_t __wrap_pwrite(int file, const void* bytes, size_t count, off_t offset);
int __wrap_ftruncate(int file, off_t size);
}

namespace weft::sim {
namespace {

struct DiskOperation {
  std::string file;
  std::string bytes;  // empty: set the size to `offset`
  off_t offset = 0;
};

bool is_recording = false;
std::vector<DiskOperation> recording;

std::string name_of(int file) {
  const std::string link = "/proc/self/fd/" + std::to_string(file);
  return std::filesystem::read_symlink(link).filename().string();
}

}  // namespace
}  // namespace weft::sim

ssize_t __wrap_pwrite(int file, const void* bytes, size_t count, off_t offset) {
  using namespace weft::sim;
  if (is_recording) {
    recording.push_back({name_of(file), {static_cast<const char*>(bytes), count}, offset});
  }
  return __real_pwrite(file, bytes, count, offset);
}

int __wrap_ftruncate(int file, off_t size) {
  using namespace weft::sim;
  if (is_recording) recording.push_back({name_of(file), "", size});
  return __real_ftruncate(file, size);
}
// NOLINTEND(bugprone-reserved-identifier, readability-identifier-naming)

namespace weft::sim {
namespace {

class TrajectoryKill : public TrajectoryFolder {
 protected:
  static constexpr double never = 1e9;  // s: frames are committed by hand

  static std::vector<TrajectoryBody> make_scene(int size) {
    std::vector<TrajectoryBody> bodies = {
        make_body("cloth", {{.rows = size, .cols = size, .wrap_u = true}})};
    bodies[0].fields = {{"velocity", "m/s", "velocity", 3}, {"heat", "J", "warmth", 1}};
    return bodies;
  }
  // A number and a vector per frame.
  static std::vector<TrajectoryRecord> make_records() {
    return {{"reactions/cloth/pin_1/force", "N", "reactions", 3},
            {"body_energy/cloth/kinetic", "J", "body_energy", 1}};
  }
  static std::unique_ptr<TrajectoryWriter> make_writer(
      const std::string& file, const std::vector<TrajectoryBody>& bodies, int series_count,
      const TrajectoryWriter::Options& storage = {}) {
    const auto initial = scene_values(bodies, 0);
    std::vector<TrajectoryWriter::Series> series(static_cast<std::size_t>(series_count));
    for (int s = 0; s < series_count; ++s) series[s] = {"series" + std::to_string(s), "J"};
    return std::make_unique<TrajectoryWriter>(
        file, bodies, series,
        TrajectoryWriter::Options{.title = "kill",
                                  .force = true,
                                  .records = make_records(),
                                  .precision = storage.precision,
                                  .compression = storage.compression,
                                  .compression_error = storage.compression_error,
                                  .commit_interval = never},
        views(initial));
  }
  static void write_frame(TrajectoryWriter& writer, const std::vector<TrajectoryBody>& bodies,
                          int series_count, int frame) {
    const auto values = scene_values(bodies, frame);
    const std::vector<double> series(static_cast<std::size_t>(series_count), 2.0 * frame);
    const auto heats = scene_heats(bodies, frame);
    const std::vector<double> records(4, 3.0 * frame);
    writer.write_frame(0.5 * frame, views(values), {{{numbers_of(values[0]), heats[0]}}, records},
                       series);
  }

  // Checks that the file holds the first `committed` or the first `next` frames, all of them right,
  // by Weft's reader and, without it, through the virtual datasets of ParaView.
  static void expect_whole(const std::string& file, int committed, int next,
                           const std::vector<TrajectoryBody>& bodies) {
    int frames = 0;
    {
      const TrajectoryReader reader(file);
      if (reader.end()) {
        ASSERT_EQ(reader.end()->status, "failed");
        ASSERT_EQ(reader.end()->reason, "it broke");
      }
      ASSERT_TRUE(reader.frames() == committed || reader.frames() == next) << reader.frames();
      ASSERT_EQ(reader.bodies().size(), bodies.size());
      const std::vector<double> series = reader.series_values(reader.series().back().name);
      for (int f = 0; f < reader.frames(); ++f) {
        ASSERT_EQ(reader.time(f), 0.5 * f);
        ASSERT_EQ(series[f], 2.0 * f);
      }
      expect_channels(reader, bodies);
      frames = reader.frames();
    }
    expect_images(file, frames, bodies);
  }

  static void expect_channels(const TrajectoryReader& reader,
                              const std::vector<TrajectoryBody>& bodies) {
    ASSERT_EQ(reader.records(), make_records());
    for (const TrajectoryRecord& record : make_records()) {
      const std::vector<double> values = reader.record_values(record.path);
      ASSERT_EQ(static_cast<int>(values.size()), record.components * reader.frames());
      for (std::size_t i = 0; i < values.size(); ++i)
        ASSERT_EQ(values[i], 3.0 * static_cast<double>(i / record.components));
    }
    ASSERT_EQ(reader.bodies()[0].fields, bodies[0].fields);
    for (int f = 0; f < reader.frames(); f += std::max(1, reader.frames() - 1)) {
      ASSERT_EQ(reader.velocities(0, f), scene_values(bodies, f)[0]);
      ASSERT_EQ(reader.field_values(0, "heat", f), scene_heats(bodies, f)[0]);
    }
  }

  static void expect_images(const std::string& file, int frames,
                            const std::vector<TrajectoryBody>& bodies) {
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      const std::string home = "/body/" + bodies[b].name + "/position";
      const std::vector<float> all = read_numbers<float>(file, home);
      const std::size_t size = 3 * static_cast<std::size_t>(bodies[b].atlas.texel_count());
      ASSERT_GE(all.size(), size * static_cast<std::size_t>(frames));
      for (std::size_t i = 0; i < size * static_cast<std::size_t>(frames); ++i) {
        const Vec3 value = scene_value(b, i % size / 3, static_cast<int>(i / size));
        ASSERT_EQ(all[i], value[static_cast<int>(i % 3)]) << "frame " << i / size;
      }
      for (int f = 0; f < frames; f += std::max(1, frames - 1 - f)) {  // the first and the last
        const std::string home_of_frame =
            "/frame/0/" + std::to_string(f / 128) + "/" + std::to_string(f);
        ASSERT_EQ(read_numbers<float>(file, home_of_frame + "/position/" + bodies[b].name),
                  std::vector<float>(all.begin() + f * static_cast<long>(size),
                                     all.begin() + (f + 1) * static_cast<long>(size)));
        // The body is not sewn: its texels are its particles.
        const std::vector<double> heats = scene_heats(bodies, f)[b];
        ASSERT_EQ(read_numbers<float>(file, home_of_frame + "/heat/" + bodies[b].name),
                  std::vector<float>(heats.begin(), heats.end()));
      }
    }
  }

  // Records a run whose commits take these numbers of frames, and checks the file after each of its
  // writes.
  void expect_every_moment(const std::vector<int>& batches, int series_count,
                           const TrajectoryWriter::Options& storage = {});

  // Returns the number of frames that the sidecar lists; -1 if it does not end as XML does.
  static int sidecar_frames(const std::string& file) {
    std::ifstream stream(file);
    std::ostringstream text;
    text << stream.rdbuf();
    const std::string xml = text.str();
    if (!xml.ends_with("</Xdmf>\n")) return -1;
    int found = 0;
    for (auto at = xml.find("<Time"); at != std::string::npos; at = xml.find("<Time", at + 1)) {
      ++found;
    }
    return found;
  }
};

// Splits operations at pages: one write reaches the file page by page.
std::vector<DiskOperation> split_at_pages(const std::vector<DiskOperation>& operations,
                                          std::vector<std::size_t>& marks) {
  constexpr off_t page = 4096;
  std::vector<DiskOperation> result;
  std::size_t mark = 0;
  for (std::size_t i = 0; i <= operations.size(); ++i) {
    for (; mark < marks.size() && marks[mark] == i; ++mark) marks[mark] = result.size();
    if (i == operations.size()) break;
    const DiskOperation& whole = operations[i];
    if (whole.bytes.empty()) result.push_back(whole);
    for (off_t done = 0; done < static_cast<off_t>(whole.bytes.size());) {
      const off_t at = whole.offset + done;
      const auto count = static_cast<std::size_t>(page - at % page);
      result.push_back({whole.file, whole.bytes.substr(static_cast<std::size_t>(done), count), at});
      done += static_cast<off_t>(result.back().bytes.size());
    }
  }
  return result;
}

void TrajectoryKill::expect_every_moment(const std::vector<int>& batches, int series_count,
                                         const TrajectoryWriter::Options& storage) {
  const std::vector<TrajectoryBody> bodies = make_scene(3);
  std::vector<int> frames{0};  // after each commit
  recording.clear();
  is_recording = true;
  std::vector<std::size_t> marks;  // operations done when the file got its name, and after commits
  {
    const auto writer = make_writer(path("run.h5"), bodies, series_count, storage);
    marks.push_back(recording.size());
    for (const int batch : batches) {
      frames.push_back(frames.back() + batch);
      for (int f = frames.end()[-2]; f < frames.back(); ++f) {
        write_frame(*writer, bodies, series_count, f);
      }
      writer->commit();
      marks.push_back(recording.size());
    }
    writer->finish({.status = "failed", .reason = "it broke", .bill = {}});
  }
  is_recording = false;
  const std::vector<DiskOperation> operations = split_at_pages(recording, marks);
  ASSERT_GT(operations.size(), marks.back());  // closing writes too
  ASSERT_GT(marks.back(), marks.front() + 10 * batches.size());

  std::filesystem::remove(path("run.h5"));
  const std::string copy = path("copy.h5");
  std::fstream file(copy, std::ios::binary | std::ios::in | std::ios::out | std::ios::trunc);
  int commits = -1;  // -1: the file does not have its name yet
  for (std::size_t i = 0; i < operations.size(); ++i) {
    while (commits + 1 < static_cast<int>(marks.size()) && marks[commits + 1] <= i + 1) ++commits;
    const DiskOperation& operation = operations[i];
    if (operation.file.starts_with("run.xdmf")) continue;
    if (operation.bytes.empty()) {
      std::filesystem::resize_file(copy, static_cast<std::uintmax_t>(operation.offset));
    } else {
      file.seekp(operation.offset);
      file.write(operation.bytes.data(), static_cast<long>(operation.bytes.size()));
      file.flush();
    }
    if (commits < 0) continue;
    const bool is_last = commits + 1 == static_cast<int>(frames.size());
    expect_whole(copy, frames[commits], frames[is_last ? commits : commits + 1], bodies);
    if (HasFailure()) FAIL() << "after write " << i << " of " << operations.size();
  }
  EXPECT_TRUE(TrajectoryReader(copy).end());
}

// The run exceeds the first pieces of all structures: 128 values of a series, 128 frames of a
// group, the inner nodes of chunk indices.
TEST_F(TrajectoryKill, EveryMomentOfManyFramesLeavesAWholeFile) {
  expect_every_moment(std::vector<int>(132, 1), 1);
}

// A batch is in the file as a whole or not at all.
TEST_F(TrajectoryKill, EveryMomentOfBatchesLeavesAWholeFile) {
  expect_every_moment({6, 40, 1, 70, 2, 16}, 1);
}

// Compressed frames have chunks of any size. The values are multiples of 1/4, which a bound of 0.1
// keeps.
TEST_F(TrajectoryKill, EveryMomentOfCompressedFramesLeavesAWholeFile) {
  expect_every_moment({1, 40, 1, 70, 2, 16, 3}, 1,
                      {.precision = Precision::float64, .compression = Compression::lossless});
  expect_every_moment({1, 16, 3}, 1,
                      {.compression = Compression::bounded, .compression_error = 0.1});
}

// One batch that fills groups and makes others.
TEST_F(TrajectoryKill, EveryMomentOfALargeBatchLeavesAWholeFile) {
  expect_every_moment({132, 3}, 1);
}

// There is so much metadata that some would cross page borders.
TEST_F(TrajectoryKill, EveryMomentOfManySeriesLeavesAWholeFile) {
  expect_every_moment(std::vector<int>(8, 1), 30);
  expect_every_moment({4, 4}, 30);
}

TEST_F(TrajectoryKill, SurvivesSigkill) {
  const std::vector<TrajectoryBody> bodies = make_scene(9);
  std::mt19937 random(20240607);
  int most = 0;
  int torn_sidecars = 0;
  for (int trial = 0; trial < 30; ++trial) {
    int pipe_ends[2];
    ASSERT_EQ(pipe(pipe_ends), 0);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      const auto writer = make_writer(path("run.h5"), bodies, 2);
      for (int f = 0;; ++f) {
        write_frame(*writer, bodies, 2, f);
        writer->commit();
        if (write(pipe_ends[1], "x", 1) != 1) _exit(1);
      }
    }
    close(pipe_ends[1]);
    char byte = 0;
    ASSERT_EQ(read(pipe_ends[0], &byte, 1), 1);  // the first frame is there
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 60000));
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));
    int committed = 1;
    while (read(pipe_ends[0], &byte, 1) == 1) ++committed;
    close(pipe_ends[0]);

    // A kill may come between the commit of a frame and its report.
    ASSERT_NO_THROW(expect_whole(path("run.h5"), committed, committed + 1, bodies))
        << "trial " << trial;
    ASSERT_FALSE(HasFailure()) << "trial " << trial;
    const int listed = sidecar_frames(path("run.xdmf"));
    torn_sidecars += listed < 0 ? 1 : 0;
    if (listed >= 0) {
      EXPECT_GE(listed, committed);
      EXPECT_LE(listed, committed + 1);
    }
    most = std::max(most, committed);
  }
  EXPECT_GT(most, 5);
  // Unlike the HDF5 file, the sidecar may be cut between two memory pages of its last write, though
  // rarely.
  EXPECT_LE(torn_sidecars, 3);
}

}  // namespace
}  // namespace weft::sim
