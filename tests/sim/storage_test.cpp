// Precision, compression and parts of the images in a trajectory, and the times of its frames.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <random>

#include "bsi/shapes.h"
#include "sim/case/frame_times.h"
#include "sim/run/recorded_run.h"
#include "sim/scene/recorded_bodies.h"
#include "sim/trajectory/image_storage.h"
#include "sim/view/output_description.h"
#include "sim/view/scene_description.h"
#include "sim/view/trajectory_info.h"
#include "tests/sim/simulated_case.h"
#include "tests/sim/trajectory_fixture.h"

namespace weft::sim::storage_test {
namespace {

template <class Number>
Number rounded(const Rounding& rounding, Number number) {
  rounding.apply(std::span(&number, 1));
  return number;
}

constexpr double infinity = std::numeric_limits<double>::infinity();

template <class Number>
void expect_bounded(double error) {
  const Rounding rounding(error);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> exponent(-12, 9), sign(-1, 1);
  double most = 0;
  for (int i = 0; i < 20000; ++i) {
    const auto value =
        static_cast<Number>(std::copysign(std::pow(10, exponent(random)), sign(random)));
    const Number result = rounded(rounding, value);
    const double change = std::abs(static_cast<double>(result) - static_cast<double>(value));
    ASSERT_LE(change, error) << value;
    ASSERT_EQ(rounded(rounding, result), result);
    most = std::max(most, change);
  }
  // The bound is used, at least up to its half.
  EXPECT_GT(most, 0.25 * error);
}

TEST(Rounding, ChangesNoNumberByMoreThanTheBound) {
  for (const double error : {1e-9, 1e-6, 0.000123, 0.25, 0.3}) {
    expect_bounded<double>(error);
    if (error > 1e-8) expect_bounded<float>(error);
  }
}

TEST(Rounding, KeepsWhatItCannotRound) {
  const Rounding fine(1e-6), none;
  for (const double value : {infinity, -infinity, 1e300, std::numeric_limits<double>::max(), 0.0}) {
    EXPECT_EQ(rounded(fine, value), value);
    EXPECT_EQ(rounded(Rounding(1e-300), value), value);
  }
  EXPECT_TRUE(std::isnan(rounded(fine, std::numeric_limits<double>::quiet_NaN())));
  EXPECT_EQ(rounded(none, 0.1), 0.1);
  // The spacing of floats is 2 m there.
  EXPECT_EQ(rounded(fine, 2e7F), 2e7F);
}

TEST(FrameTimes, AreTheStartTheMultiplesOfTheIntervalAndTheEnd) {
  Case source;
  source.time.duration = 0.25;
  source.time.frames_per_second = 10;
  const FrameTimes frames(source);
  EXPECT_EQ(frames.count(), 4);
  EXPECT_EQ(frames.at(0), 0);
  EXPECT_EQ(frames.at(1), 0.1);
  EXPECT_EQ(frames.at(3), 0.25);
  EXPECT_FALSE(frames.at(4));
  EXPECT_TRUE(frames.are_between(0.09, 0.11));
  EXPECT_FALSE(frames.are_between(0.11, 0.19));
  EXPECT_TRUE(frames.are_between(0.21, 0.25));
  // An end that is a multiple of the interval is one frame.
  source.time.duration = 0.3;
  EXPECT_EQ(FrameTimes(source).count(), 4);
  EXPECT_FALSE(FrameTimes(source).at(4));
}

TEST(FrameTimes, AreThoseListedAlone) {
  Case source;
  source.output.frame_times = {0.2, 0.5};
  const FrameTimes frames(source);
  EXPECT_EQ(frames.count(), 2);
  EXPECT_EQ(frames.at(0), 0.2);
  EXPECT_EQ(frames.at(1), 0.5);
  EXPECT_FALSE(frames.at(2));
  EXPECT_FALSE(frames.are_between(0, 0.1));
  EXPECT_TRUE(frames.are_between(0.1, 0.2));
  EXPECT_FALSE(frames.are_between(0.2, 0.4));
  EXPECT_FALSE(frames.are_between(0.5, 2));
}

class Storage : public TrajectoryFolder {
 protected:
  // Writes 20 frames of a smooth sheet of 33 x 33 vertices, with a field, and returns the bytes
  // that its positions take.
  hsize_t write(const std::string& name, const TrajectoryWriter::Options& options) const {
    std::vector<TrajectoryBody> bodies = {make_body("sheet", {{.rows = 33, .cols = 33}})};
    bodies[0].fields = {{"heat", "J", "heat", 1}};
    {
      TrajectoryWriter writer(path(name), bodies, {}, options, {sheet(0)});
      for (int f = 0; f < frames; ++f) {
        const std::vector<Vec3> positions = sheet(f);
        writer.write_frame(0.1 * f, {positions}, {{{heats(positions)}}, {}}, {});
      }
    }
    const hid_t file = H5Fopen(path(name).c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    const hid_t dataset = H5Dopen2(file, "/body/sheet/position", H5P_DEFAULT);
    const hsize_t size = H5Dget_storage_size(dataset);
    H5Dclose(dataset);
    H5Fclose(file);
    return size;
  }
  static std::vector<Vec3> sheet(int frame) {
    std::vector<Vec3> positions;
    for (int i = 0; i < 33 * 33; ++i) {
      const double x = (i % 33) / 32.0, y = (i / 33) / 32.0;
      positions.emplace_back(x + 0.01 * std::sin(5 * y + frame), y,
                             0.2 * std::sin(3 * x + 0.3 * frame) * std::cos(4 * y));
    }
    return positions;
  }
  static std::vector<double> heats(const std::vector<Vec3>& positions) {
    std::vector<double> values;
    for (const Vec3& position : positions) values.push_back(100 * position.z());
    return values;
  }
  static constexpr int frames = 20;
};

TEST_F(Storage, KeepsEveryBitOfAFloat64) {
  write("run.h5", {.precision = Precision::float64});
  {
    const TrajectoryReader reader(path("run.h5"));
    for (int f = 0; f < frames; ++f) EXPECT_EQ(reader.positions(0, f), sheet(f));
  }
  // ParaView reads them as such, through views of the same type.
  std::ifstream file(path("run.xdmf"));
  const std::string xml{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(xml.find("Precision=\"8\" Dimensions=\"1089 3\">run.h5:/frame/0/0/3/position/sheet<"),
            std::string::npos);
  EXPECT_NE(xml.find("Precision=\"4\" Dimensions=\"1089\">run.h5:/frame/0/0/3/heat/sheet<"),
            std::string::npos);
  const hid_t h5 = H5Fopen(path("run.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  for (const char* name : {"/body/sheet/position", "/frame/0/0/3/position/sheet"}) {
    const hid_t dataset = H5Dopen2(h5, name, H5P_DEFAULT);
    const hid_t type = H5Dget_type(dataset);
    EXPECT_EQ(H5Tget_size(type), 8) << name;
    H5Tclose(type);
    H5Dclose(dataset);
  }
  H5Fclose(h5);
}

TEST_F(Storage, CompressesWithoutLoss) {
  const auto plain = write("plain.h5", {});
  const auto small = write("small.h5", {.compression = Compression::lossless});
  EXPECT_LT(small, 0.95 * static_cast<double>(plain));
  for (const char* name : {"/body/sheet/position", "/body/sheet/heat", "/frame/0/0/7/heat/sheet",
                           "/frame/0/0/19/position/sheet"}) {
    EXPECT_EQ(read_numbers<float>(path("small.h5"), name),
              read_numbers<float>(path("plain.h5"), name))
        << name;
  }
}

TEST_F(Storage, CompressesWithinABound) {
  const auto lossless = write("lossless.h5", {.compression = Compression::lossless});
  auto larger = lossless;
  for (const double error : {1e-6, 1e-5, 1e-4}) {
    const auto size = write(
        "run.h5", {.force = true, .compression = Compression::bounded, .compression_error = error});
    EXPECT_LT(size, larger) << error;
    larger = size;
    const std::vector<float> kept =
        read_numbers<float>(path("lossless.h5"), "/body/sheet/position");
    const std::vector<float> rounded = read_numbers<float>(path("run.h5"), "/body/sheet/position");
    ASSERT_EQ(kept.size(), rounded.size());
    double most = 0;
    for (std::size_t i = 0; i < kept.size(); ++i)
      most = std::max(most, std::abs(static_cast<double>(kept[i]) - rounded[i]));
    EXPECT_LE(most, error);
    EXPECT_GT(most, 0.25 * error);
    // Fields keep every bit.
    EXPECT_EQ(read_numbers<float>(path("run.h5"), "/body/sheet/heat"),
              read_numbers<float>(path("lossless.h5"), "/body/sheet/heat"));
  }
}

// A sheet that hangs, above a floor.
constexpr const char* hanging_case = R"(
[time]
duration = 0.1
frames_per_second = 50
[material.cloth]
bending_stiffness = 1e-5
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [9, 13] }
[[body.pin]]
corners = ["last_first", "last_last"]
[[obstacle]]
name = "drum"
shape = { type = "cylinder", radius = 0.2, length = 1, resolution = [5, 12] }
position = [0, 0, -1]
)";

class RecordedStorage : public TrajectoryFolder {
 protected:
  RunReport run(const std::string& name, const Overrides& overrides,
                const std::string& text = hanging_case) const {
    const Case source = parse_case(text, "test.toml", overrides);
    RunOptions options;
    options.trajectory = path(name);
    RunReport report = run_simulation(source, options);
    EXPECT_EQ(report.status, RunReport::Status::done) << report.reason;
    return report;
  }
};

TEST_F(RecordedStorage, HoldsAPartOfABodyAndItsFields) {
  run("whole.h5", {"output.channels=[\"velocity\", \"membrane_strain\"]"});
  run("part.h5",
      {"output.channels=[\"velocity\", \"membrane_strain\"]", "output.bodies=[\"drum\", \"sheet\"]",
       "output.part=[{ body = \"sheet\", rows = [2, -1], cols = [1, 8], every = 3 },"
       "{ body = \"drum\", every = 2 }]"});
  const TrajectoryReader whole(path("whole.h5")), part(path("part.h5"));
  ASSERT_EQ(part.frames(), whole.frames());
  const std::vector<int> rows{2, 5, 8}, cols{1, 4, 7, 8};
  EXPECT_EQ(part.bodies()[0].part_rows, rows);
  EXPECT_EQ(part.bodies()[0].part_cols, cols);
  EXPECT_FALSE(whole.bodies()[0].is_part());
  for (int f = 0; f < part.frames(); ++f) {
    const auto positions = part.positions(0, f), all = whole.positions(0, f);
    const auto strains = part.field_values(0, "membrane_strain_direction", f);
    const auto all_strains = whole.field_values(0, "membrane_strain_direction", f);
    for (std::size_t r = 0; r < rows.size(); ++r) {
      for (std::size_t c = 0; c < cols.size(); ++c) {
        const std::size_t at = 4 * r + c, from = 13 * std::size_t(rows[r]) + std::size_t(cols[c]);
        EXPECT_EQ(positions[at], all[from]);
        for (int k = 0; k < 3; ++k) EXPECT_EQ(strains[3 * at + k], all_strains[3 * from + k]);
      }
    }
  }
  // Extremes have their place in the whole image.
  for (const FieldSummary& field : field_extremes(part)) {
    if (field.magnitude) continue;
    const FieldExtreme& most = field.maximum;
    EXPECT_EQ(whole.field_values(0, field.name, most.frame)[13 * most.texel.row + most.texel.col],
              most.value)
        << field.name;
  }
  // Every second of 12 columns around: the surface stays closed.
  const bsi::Patch& drum = part.bodies()[1].atlas.patches()[0];
  EXPECT_TRUE(drum.wrap_u);
  EXPECT_EQ(drum.cols, 6);
  EXPECT_EQ(drum.rows, 3);
  EXPECT_EQ(part.bodies()[1].atlas.quad_count(), 2 * 6);
  // A part says nothing of surfaces that pass through each other.
  try {
    count_crossings(path("part.h5"));
    ADD_FAILURE();
  } catch (const FileError& error) {
    EXPECT_NE(std::string(error.what())
                  .find("crossings cannot be counted: only a part of body \"sheet\" is recorded"),
              std::string::npos)
        << error.what();
  }
  EXPECT_NE(to_text(summarise_trajectory(path("part.h5")))
                .find("part: 3 rows from 2 to 8, 4 columns from 1 to 8"),
            std::string::npos);
}

TEST_F(RecordedStorage, LeavesOutBodiesThatAreNotListed) {
  const std::string text = hanging_case + std::string(R"(
[[body]]
name = "other"
shape = { type = "rectangle", size = [1, 1], resolution = [5, 5] }
position = [0, 3, 0]
velocity = [1, 2, 3]
)");
  run("whole.h5", {"output.velocity=true"}, text);
  run("run.h5", {"output.bodies=[\"drum\", \"other\"]", "output.velocity=true"}, text);
  const TrajectoryReader whole(path("whole.h5")), reader(path("run.h5"));
  ASSERT_EQ(whole.bodies().size(), 3);
  // The order is that of the case.
  ASSERT_EQ(reader.bodies().size(), 2);
  EXPECT_EQ(reader.bodies()[0].name, "other");
  EXPECT_EQ(reader.bodies()[1].name, "drum");
  ASSERT_EQ(reader.frames(), 6);
  EXPECT_EQ(reader.positions(0, 5), whole.positions(1, 5));
  EXPECT_EQ(reader.velocities(0, 5), whole.velocities(1, 5));
  EXPECT_EQ(reader.positions(1, 0), whole.positions(2, 0));
}

// The particles of a sewn body stay sewn in its part.
TEST(ImagePart, KeepsSeams) {
  const bsi::Surface sphere = bsi::make_sphere(1, 9);
  OutputPartCase choice;
  choice.every = 3;
  const ImagePart part = make_part(sphere.atlas, choice);
  EXPECT_EQ(part.rows, (std::vector<int>{0, 3, 6, 8}));
  EXPECT_EQ(part.atlas.patches().size(), 6);
  // 4 x 4 on each side of a cube: 8 corners, 12 edges of 2 more, 6 sides of 4 more.
  const int closed = 8 + 12 * 2 + 6 * 4;
  EXPECT_GE(part.atlas.particle_count(), closed);
  EXPECT_LT(part.atlas.particle_count(), 6 * 16);
  for (int t = 0; t < part.atlas.texel_count(); ++t) {
    const auto [patch, row, col] = part.atlas.texel_address(t);
    EXPECT_EQ(part.particles[part.atlas.particle_of_texel(t)],
              sphere.atlas.particle(patch, part.rows[row], part.cols[col]));
  }
  choice.every = 4;  // 0, 4, 8: the same from both ends of a seam
  EXPECT_EQ(make_part(sphere.atlas, choice).atlas.particle_count(), 8 + 12 + 6);
}

TEST_F(RecordedStorage, HasFramesAtTheTimesOfTheCaseAlone) {
  run("rate.h5", {});
  const RunReport report = run("times.h5", {"output.frame_times=[0.02, 0.033, 0.0801]"});
  // The run goes on to its end, with the same steps; those after the last frame are not recorded.
  EXPECT_EQ(report.simulated_time, 0.1);
  EXPECT_EQ(report.frames, 3);
  const std::vector<float> steps = read_numbers<float>(path("times.h5"), "/steps/time");
  std::vector<float> all = read_numbers<float>(path("rate.h5"), "/steps/time");
  EXPECT_LT(steps.size(), all.size());
  all.resize(steps.size());
  EXPECT_EQ(steps, all);
  EXPECT_GT(steps.back(), 0.0801);
  const TrajectoryReader rate(path("rate.h5")), times(path("times.h5"));
  ASSERT_EQ(times.frames(), 3);
  EXPECT_EQ(times.time(0), 0.02);
  EXPECT_EQ(times.time(1), 0.033);
  EXPECT_EQ(times.time(2), 0.0801);
  EXPECT_EQ(times.positions(0, 0), rate.positions(0, 1));
}

TEST_F(RecordedStorage, MayListTheStartAndTheEnd) {
  run("run.h5", {"output.frame_times=[0, 0.1]"});
  const TrajectoryReader reader(path("run.h5"));
  ASSERT_EQ(reader.frames(), 2);
  EXPECT_EQ(reader.time(0), 0);
  EXPECT_EQ(reader.time(1), 0.1);
}

// Compares what 180 more frames add to the file: the views, the images and 45 series.
TEST_F(RecordedStorage, HasAboutTheSizeThatIsForetold) {
  for (const std::string resolution : {"[9, 13]", "[65, 65]"}) {
    const Overrides common{"body.sheet.shape.resolution=" + resolution,
                           "output.channels=[\"velocity\", \"membrane_strain\"]",
                           "time.duration=0.02", "time.method=\"verlet\""};
    std::array<double, 2> foretold{}, found{};
    for (int i = 0; i < 2; ++i) {
      Overrides overrides = common;
      overrides.push_back("time.frames_per_second=" + std::to_string(i == 0 ? 1000 : 10000));
      const Case source = parse_case(hanging_case, "test.toml", overrides);
      foretold[i] = image_bytes(*build_scene(source));
      run(std::to_string(i) + resolution + ".h5", overrides);
      found[i] = static_cast<double>(
          std::filesystem::file_size(path(std::to_string(i) + resolution + ".h5")));
    }
    EXPECT_NEAR(foretold[1] - foretold[0], found[1] - found[0], 0.2 * (found[1] - found[0]))
        << resolution;
  }
}

TEST_F(RecordedStorage, IsForetoldByWeftCheck) {
  const std::string text = describe_scene(*build_scene(
      parse_case(hanging_case, "test.toml",
                 {"output.part=[{ body = \"sheet\", every = 4 }]", "output.precision=\"float64\"",
                  "output.compression=\"bounded\"", "output.frame_times=[0.05, 0.1]"})));
  EXPECT_NE(text.find("file      images of about 0.004852 MiB before compression within 1e-06 m: "
                      "2 frames, of \"sheet\" 3 x 4 vertices, positions in float64\n"
                      "  skipped channels beside the positions: output.channels lists none\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("time      0.1 s, CVODE"), std::string::npos) << text;
}

}  // namespace
}  // namespace weft::sim::storage_test
