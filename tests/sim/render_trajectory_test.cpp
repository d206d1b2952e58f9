#include "sim/view/render_trajectory.h"

#include <gtest/gtest.h>
#include <png.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "bsi/shapes.h"
#include "sim/trajectory/trajectory.h"
#include "tests/temporary_folder.h"

namespace weft::sim::render_trajectory_test {
namespace {

namespace files = std::filesystem;

// Tests with a PATH whose ffmpeg the test provides.
class RenderTrajectory : public testing::Test {
 protected:
  void SetUp() override {
    files::create_directory(folder_.path("programs"));
    old_path_ = std::getenv("PATH");
    setenv("PATH", folder_.path("programs").c_str(), 1);
  }
  void TearDown() override { setenv("PATH", old_path_.c_str(), 1); }

  // Installs a script in the place of ffmpeg. Its variable `movie` is the name of the movie, the
  // last argument of ffmpeg.
  void install_ffmpeg(const std::string& script) const {
    const files::path path = folder_.path("programs/ffmpeg");
    std::ofstream(path) << "#!/bin/sh\nfor movie; do :; done\n" << script << '\n';
    files::permissions(path, files::perms::owner_all);
  }

  // Writes a trajectory of a sheet that rises by its size over `frames` frames of 0.1 s, above a
  // floor.
  std::string write_trajectory(int frames, double height = 1.0, double floor_size = 200,
                               const std::string& case_text = "") const {
    const bsi::Surface sheet = bsi::make_rectangle(1, 1, 9, 9);
    const bsi::Surface floor = bsi::make_rectangle(floor_size, floor_size, 2, 2);
    std::vector<TrajectoryBody> bodies(2);
    bodies[0] = {"floor", floor.atlas, false, true, 0};
    bodies[1] = {"sheet", sheet.atlas, true, false, 1e-3};
    std::string path = folder_.path("run.h5");
    TrajectoryWriter writer(path, bodies, {}, {.case_text = case_text},
                            {floor.positions, sheet.positions});
    for (int frame = 0; frame < frames; ++frame) {
      std::vector<Vec3> positions = sheet.positions;
      for (Vec3& position : positions) position.z() += 0.05 + height * frame / frames;
      writer.write_frame(0.1 * frame, {floor.positions, positions}, {}, {});
    }
    return path;
  }

  // Writes 2 frames of a dome over a band of the same shape, which has no vertices to spare.
  std::string write_domes(double thickness) const {
    bsi::Surface lower = bsi::make_rectangle(1, 0.3, 2, 65);
    for (Vec3& p : lower.positions) p.z() = 0.3 * std::cos(3 * p.x()) * std::cos(2.5 * p.y());
    const bsi::Surface flat = bsi::make_rectangle(1.02, 1.02, 65, 65);
    std::vector<Vec3> upper;
    for (const Vec3& p : flat.positions) {
      upper.emplace_back(p.x(), p.y(), 0.3 * std::cos(3 * p.x()) * std::cos(2.5 * p.y()) + 3e-3);
    }
    std::vector<TrajectoryBody> bodies(2);
    bodies[0] = {"dome", lower.atlas, false, true, thickness};
    bodies[1] = {"sheet", flat.atlas, true, false, thickness};
    std::string path = folder_.path("domes.h5");
    TrajectoryWriter writer(path, bodies, {}, {}, {lower.positions, upper});
    for (int frame = 0; frame < 2; ++frame) {
      writer.write_frame(0.1 * frame, {lower.positions, upper}, {}, {});
    }
    return path;
  }

  std::string pictures() const { return folder_.path("pictures"); }
  int picture_count() const {
    int count = 0;
    for (const auto& entry : files::directory_iterator(pictures())) {
      count += entry.path().extension() == ".png";
    }
    return count;
  }

  TemporaryFolder folder_;
  std::string old_path_;
};

RenderOptions small_pictures() {
  RenderOptions options;
  options.width = 96;
  options.height = 72;
  return options;
}

struct Pixels {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};

Pixels read_png(const files::path& path) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&image, path.c_str()) == 0) return {};
  image.format = PNG_FORMAT_RGB;
  Pixels pixels{static_cast<int>(image.width), static_cast<int>(image.height),
                std::vector<std::uint8_t>(PNG_IMAGE_SIZE(image))};
  png_image_finish_read(&image, nullptr, pixels.rgb.data(), 0, nullptr);
  return pixels;
}

// Mean row and number of the pixels that are redder than the greys of floor and sky: those of the
// sheet, which takes the first colour of the palette.
struct RedPart {
  double mean_row = 0;
  int count = 0;
};
RedPart red_part(const Pixels& pixels) {
  RedPart part;
  for (int row = 0; row < pixels.height; ++row) {
    for (int col = 0; col < pixels.width; ++col) {
      const std::uint8_t* pixel = &pixels.rgb[3 * (std::size_t{1} * row * pixels.width + col)];
      if (pixel[0] < pixel[2] + 25) continue;
      part.mean_row += row;
      ++part.count;
    }
  }
  part.mean_row /= std::max(1, part.count);
  return part;
}

// Products of such coordinates exceed the range of the renderer's numbers.
TEST_F(RenderTrajectory, RefusesPositionsThatAreTooFarAway) {
  const bsi::Surface sheet = bsi::make_rectangle(1, 1, 9, 9);
  std::vector<TrajectoryBody> bodies(1);
  bodies[0] = {"sheet", sheet.atlas};
  for (const double distance : {1e308, 1e30, 1.1e9, 0.9e9}) {
    std::vector<Vec3> positions = sheet.positions;
    positions[40].y() = -distance;
    {
      TrajectoryWriter writer(folder_.path("far.h5"), bodies, {},
                              {.force = true, .precision = Precision::float64}, {positions});
      writer.write_frame(0, {positions}, {}, {});
    }
    std::string message = "drawn";
    try {
      RenderOptions options = small_pictures();
      options.movie = false;
      render_trajectory(folder_.path("far.h5"), pictures(), options);
    } catch (const std::runtime_error& error) {
      message = error.what();
    }
    EXPECT_EQ(message, distance > 1e9 ? "cannot draw frame 0: body 'sheet' has a position that is "
                                        "beyond 1e+09 m"
                                      : "drawn");
  }
}

TEST_F(RenderTrajectory, DrawsParticlesAsSpheres) {
  const bsi::Surface floor = bsi::make_rectangle(200, 200, 2, 2);
  std::vector<TrajectoryBody> bodies(2);
  bodies[0] = {"floor", floor.atlas, false, true, 0};
  bodies[1].name = "balls";
  bodies[1].atlas = bsi::Atlas::of_points(2);
  std::vector<int> counts;
  for (const double radius : {0.2, 0.4}) {
    const std::string path = folder_.path("balls.h5");
    bodies[1].radii = {radius, radius};
    {
      TrajectoryWriter writer(path, bodies, {}, {.force = true}, {floor.positions, {}});
      const std::vector<Vec3> centres{{-2, 0, 0.5}, {2, 0, 0.5}};
      writer.write_frame(0, {floor.positions, centres}, {}, {});
    }
    RenderOptions options = small_pictures();
    options.force = true;
    const RenderReport report = render_trajectory(path, pictures(), options);
    EXPECT_GT(report.triangles, 200);
    EXPECT_EQ(report.triangles, report.all_triangles);
    counts.push_back(red_part(read_png(files::path(pictures()) / "frame_00000.png")).count);
  }
  EXPECT_GT(counts[0], 10);
  // The camera sees little more of the larger balls, whose area is four times as large.
  EXPECT_GT(counts[1], 2 * counts[0]);
}

TEST_F(RenderTrajectory, DrawsEveryFrameFromOneCameraThatSeesTheMotion) {
  const std::string path = write_trajectory(4);
  std::vector<int> progress;
  RenderOptions options = small_pictures();
  options.progress = [&progress](int done, int of) { progress.push_back(10 * done + of); };
  const RenderReport report = render_trajectory(path, pictures(), options);
  EXPECT_EQ(report.pictures, 4);
  EXPECT_EQ(picture_count(), 4);
  EXPECT_EQ(progress, (std::vector<int>{4, 14, 24, 34, 44}));
  double last_row = 1e9;
  for (const char* name : {"frame_00000.png", "frame_00001.png", "frame_00003.png"}) {
    const Pixels pixels = read_png(files::path(pictures()) / name);
    ASSERT_EQ(pixels.width, 96);
    ASSERT_EQ(pixels.height, 72);
    const RedPart part = red_part(pixels);
    EXPECT_LT(part.mean_row, last_row) << "the sheet rises";
    last_row = part.mean_row;
    // The floor of 200 m does not make the sheet small.
    EXPECT_GT(part.count, 96 * 72 / 40) << name;
  }
}

// A floor of 2 m is seen whole, and the sheet appears smaller. Of a floor of 200 m, only a part
// hardly larger than the sheet is seen.
TEST_F(RenderTrajectory, SeesObstaclesWholeThatAreNotTooLarge) {
  std::array<int, 2> sheet{};
  for (const bool is_huge : {false, true}) {
    const std::string path = write_trajectory(2, 1.0, is_huge ? 200 : 2);
    render_trajectory(path, pictures(), small_pictures());
    files::remove(path);
    files::remove(folder_.path("run.xdmf"));
    sheet[is_huge] = red_part(read_png(files::path(pictures()) / "frame_00000.png")).count;
  }
  EXPECT_LT(1.3 * sheet[0], sheet[1]);
}

TEST_F(RenderTrajectory, DrawsFewerTrianglesWithinPixels) {
  const std::string path = write_domes(0);
  const RenderReport full = render_trajectory(path, pictures(), small_pictures());
  EXPECT_EQ(full.triangles, full.all_triangles);
  EXPECT_EQ(full.all_triangles, 2 * 2 * (64 * 64 + 64));
  const RedPart whole = red_part(read_png(files::path(pictures()) / "frame_00001.png"));
  std::int64_t more = full.all_triangles;
  for (const double pixels : {0.2, 1.0}) {
    RenderOptions options = small_pictures();
    options.detail_pixels = pixels;
    const RenderReport report = render_trajectory(path, pictures(), options);
    EXPECT_EQ(report.pictures, 2);
    EXPECT_EQ(report.all_triangles, full.all_triangles);
    EXPECT_LT(2 * report.triangles, more);
    more = report.triangles;
    const RedPart part = red_part(read_png(files::path(pictures()) / "frame_00001.png"));
    EXPECT_NEAR(part.count, whole.count, 0.05 * whole.count) << pixels;
    EXPECT_NEAR(part.mean_row, whole.mean_row, pixels) << pixels;
  }
}

// Bodies 2 mm thick lie 3 mm apart along z; five pixels of error, some 7 cm, would mix them.
TEST_F(RenderTrajectory, KeepsBodiesInContactApart) {
  const std::string path = write_domes(2e-3);
  render_trajectory(path, pictures(), small_pictures());
  const RedPart whole = red_part(read_png(files::path(pictures()) / "frame_00000.png"));
  RenderOptions options = small_pictures();
  options.detail_pixels = 5;
  const RenderReport report = render_trajectory(path, pictures(), options);
  EXPECT_LT(2 * report.triangles, report.all_triangles);
  const RedPart part = red_part(read_png(files::path(pictures()) / "frame_00000.png"));
  EXPECT_NEAR(part.count, whole.count, 0.02 * whole.count);
}

TEST_F(RenderTrajectory, DrawsTheSurfaceOfALevel) {
  const std::string path = write_domes(0);
  std::int64_t fewer = 0;
  for (const int level : {0, 2, 4}) {
    RenderOptions options = small_pictures();
    options.surface_of_level = level;
    const RenderReport report = render_trajectory(path, pictures(), options);
    EXPECT_LT(fewer, report.triangles) << level;
    fewer = report.triangles;
  }
  RenderOptions options = small_pictures();
  options.surface_of_level = 20;
  const RenderReport whole = render_trajectory(path, pictures(), options);
  EXPECT_LT(fewer, whole.triangles);
  EXPECT_EQ(whole.triangles, whole.all_triangles);
}

// Counts pixels in the red of touching spheres; the palest body colour is far from it.
int touching_pixels(const Pixels& pixels) {
  int count = 0;
  for (std::size_t i = 0; i + 2 < pixels.rgb.size(); i += 3) {
    const int red = pixels.rgb[i], green = pixels.rgb[i + 1], blue = pixels.rgb[i + 2];
    if (red > 90 && 3 * green < red && 3 * blue < red) ++count;
  }
  return count;
}

// The floor is one sphere of 0.7 m, which the sheet leaves.
TEST_F(RenderTrajectory, DrawsTheSpheresOfALevelAndThoseThatTouchInRed) {
  const std::string path = write_trajectory(2, 4.0, 1.0);
  RenderOptions options = small_pictures();
  options.spheres_of_level = 3;
  const RenderReport report = render_trajectory(path, pictures(), options);
  EXPECT_GT(report.triangles, report.all_triangles);
  EXPECT_GT(touching_pixels(read_png(files::path(pictures()) / "frame_00000.png")), 100);
  EXPECT_EQ(touching_pixels(read_png(files::path(pictures()) / "frame_00001.png")), 0);
}

std::vector<std::uint8_t> border(const Pixels& pixels) {
  std::vector<std::uint8_t> border;
  for (int row = 0; row < pixels.height; ++row) {
    for (int col = 0; col < pixels.width; ++col) {
      if (row % (pixels.height - 1) != 0 && col % (pixels.width - 1) != 0) continue;
      const auto* pixel = &pixels.rgb[3 * (std::size_t{1} * row * pixels.width + col)];
      border.insert(border.end(), pixel, pixel + 3);
    }
  }
  return border;
}

// The background depends on the size of the picture alone. Bodies are surrounded by it.
TEST_F(RenderTrajectory, SeesTheSpheresOfALevelWhole) {
  const std::string path = write_trajectory(2, 1.0, 1.0);
  render_trajectory(path, pictures(), small_pictures());
  const files::path last = files::path(pictures()) / "frame_00001.png";
  const std::vector<std::uint8_t> background = border(read_png(last));
  for (const int level : {0, 1, 2}) {
    RenderOptions options = small_pictures();
    options.spheres_of_level = level;
    render_trajectory(path, pictures(), options);
    const Pixels pixels = read_png(last);
    EXPECT_EQ(border(pixels), background) << level;
    EXPECT_GT(red_part(pixels).count, 96 * 72 / 40) << level;
  }
}

TEST_F(RenderTrajectory, LeavesOutFramesAndRemovesLeftOvers) {
  const std::string path = write_trajectory(5);
  render_trajectory(path, pictures(), small_pictures());
  EXPECT_EQ(picture_count(), 5);
  RenderOptions options = small_pictures();
  for (const int every : {2, 3}) {
    options.every = every;
    EXPECT_EQ(render_trajectory(path, pictures(), options).pictures, 3);
    EXPECT_EQ(picture_count(), 3);
    // Pictures have the numbers of their frames, and the last frame is among them.
    for (const std::string frame : {"0", every == 2 ? "2" : "3", "4"})
      EXPECT_TRUE(files::exists(files::path(pictures()) / ("frame_0000" + frame + ".png")));
  }
}

std::string text_of(const files::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Nothing is drawn, so no folder holds half of two renderings.
TEST_F(RenderTrajectory, RefusesToOverwriteWhatItDidNotMake) {
  const std::string path = write_trajectory(3);
  install_ffmpeg("echo \"$@\" > \"$movie\"");
  for (const char* name : {"frame_00002.png", "movie.mp4"}) {
    files::remove_all(pictures());
    files::create_directory(pictures());
    const files::path mine = files::path(pictures()) / name;
    std::ofstream(mine) << "mine";
    try {
      render_trajectory(path, pictures(), small_pictures());
      ADD_FAILURE() << name;
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(error.what(), mine.string() +
                                  ": was not made by weft render, and is only overwritten by force "
                                  "(--force)");
    }
    EXPECT_EQ(text_of(mine), "mine");
    EXPECT_FALSE(files::exists(files::path(pictures()) / "frame_00000.png"));
    RenderOptions options = small_pictures();
    options.force = true;
    EXPECT_EQ(render_trajectory(path, pictures(), options).pictures, 3);
    EXPECT_NE(text_of(mine), "mine");
    // Now both files are its own.
    EXPECT_EQ(render_trajectory(path, pictures(), small_pictures()).pictures, 3);
    EXPECT_NE(text_of(files::path(pictures()) / "movie.mp4").find("comment=made by weft render"),
              std::string::npos);
  }
}

TEST_F(RenderTrajectory, NeverReplacesTheTrajectory) {
  const std::string path = write_trajectory(3);
  const std::string before = text_of(path);
  files::create_directory(pictures());
  RenderOptions options = small_pictures();
  options.force = true;
  options.every = 1000;
  for (const char* name : {"frame_00000.png", "frame_00002.png", "movie.mp4"}) {
    const files::path there = files::path(pictures()) / name;
    files::copy_file(path, there);
    EXPECT_THROW(render_trajectory(there.string(), pictures(), options), RenderUsageError) << name;
    EXPECT_EQ(text_of(there), before) << name;
    files::remove(there);
    EXPECT_EQ(picture_count(), 0) << name;
  }
  // It has the name of what a killed rendering leaves.
  const files::path there = files::path(pictures()) / "frame_00001.png.2147483647.tmp";
  files::copy_file(path, there);
  EXPECT_EQ(render_trajectory(there.string(), pictures(), options).pictures, 2);
  EXPECT_EQ(text_of(there), before);
}

TEST_F(RenderTrajectory, LeavesPicturesOfOthersBehindItsOwn) {
  render_trajectory(write_trajectory(5), pictures(), small_pictures());
  const files::path mine = files::path(pictures()) / "frame_00003.png";
  std::ofstream(mine) << "mine";
  files::remove(folder_.path("run.h5"));
  files::remove(folder_.path("run.xdmf"));
  const RenderReport report = render_trajectory(write_trajectory(2), pictures(), small_pictures());
  EXPECT_EQ(report.pictures, 2);
  EXPECT_EQ(picture_count(), 3);
  EXPECT_EQ(text_of(mine), "mine");
}

TEST_F(RenderTrajectory, SaysThatThereIsNoFfmpeg) {
  const RenderReport report = render_trajectory(write_trajectory(2), pictures(), small_pictures());
  EXPECT_EQ(report.movie, "");
  EXPECT_EQ(report.why_no_movie, "ffmpeg not found: no movie");
  EXPECT_EQ(picture_count(), 2);
}

TEST_F(RenderTrajectory, SlowsTheMovieByTheTimeScale) {
  const std::string path =
      write_trajectory(3, 1.0, 200,
                       "[time]\nscale = 0.25\n[[body]]\nname = \"sheet\"\n"
                       "shape = { type = \"rectangle\", size = [1, 1], resolution = [9, 9] }\n");
  EXPECT_NEAR(render_trajectory(path, pictures(), small_pictures()).frames_per_second, 2.5, 1e-9);
}

// Files that the case names need not be there any more.
TEST_F(RenderTrajectory, SlowsMoviesOfShapesFromFiles) {
  const std::string path =
      write_trajectory(3, 1.0, 200,
                       "[time]\nscale = 0.25\n[[body]]\nname = \"sheet\"\n"
                       "shape = { type = \"file\", path = \"gone.h5\", dataset = \"/x\" }\n");
  EXPECT_NEAR(render_trajectory(path, pictures(), small_pictures()).frames_per_second, 2.5, 1e-9);
}

TEST_F(RenderTrajectory, HandsThePicturesToFfmpegInRealTime) {
  install_ffmpeg("echo \"$@\" > arguments; echo movie > \"$movie\"");
  const RenderReport report = render_trajectory(write_trajectory(3), pictures(), small_pictures());
  EXPECT_EQ(report.why_no_movie, "");
  EXPECT_EQ(report.movie, pictures() + "/movie.mp4");
  EXPECT_TRUE(files::exists(report.movie));
  EXPECT_NEAR(report.frames_per_second, 10, 1e-9);
  std::string arguments;
  std::getline(std::ifstream(files::path(pictures()) / "arguments"), arguments);
  for (const char* part :
       {"-framerate 10.000000 ", "-i .movie_frames/%d.png ", "-pix_fmt yuv420p ", "libx264"}) {
    EXPECT_NE(arguments.find(part), std::string::npos) << part << "in " << arguments;
  }
}

// The links are numbered without gaps, in the order of the frames, and last while ffmpeg runs.
TEST_F(RenderTrajectory, HandsFfmpegThePicturesThatItDrew) {
  install_ffmpeg(
      "for link in .movie_frames/*; do echo \"$link $(readlink \"$link\")\"; done > links;"
      "echo movie > \"$movie\"");
  // Programs of the test's own, and the system's readlink.
  setenv("PATH", (folder_.path("programs") + ":/usr/bin:/bin").c_str(), 1);
  RenderOptions options = small_pictures();
  options.every = 3;
  render_trajectory(write_trajectory(6), pictures(), options);
  EXPECT_EQ(text_of(files::path(pictures()) / "links"),
            ".movie_frames/0.png ../frame_00000.png\n"
            ".movie_frames/1.png ../frame_00003.png\n"
            ".movie_frames/2.png ../frame_00005.png\n");
  EXPECT_FALSE(files::exists(files::path(pictures()) / ".movie_frames"));
}

// A rendering that was killed leaves links behind, which do no harm.
TEST_F(RenderTrajectory, RemovesNothingButItsLinksFromTheirFolder) {
  install_ffmpeg("echo movie > \"$movie\"");
  const files::path links = files::path(pictures()) / ".movie_frames";
  files::create_directories(links);
  files::create_symlink("../frame_00007.png", links / "0.png");
  std::ofstream(links / "mine") << "mine";
  const RenderReport report = render_trajectory(write_trajectory(2), pictures(), small_pictures());
  EXPECT_EQ(report.why_no_movie, "");
  EXPECT_EQ(text_of(links / "mine"), "mine");
  EXPECT_FALSE(files::is_symlink(links / "0.png"));
}

TEST_F(RenderTrajectory, KeepsThePicturesWhenFfmpegFails) {
  install_ffmpeg("echo 'Unknown encoder libx264' >&2; exit 3");
  const RenderReport report = render_trajectory(write_trajectory(2), pictures(), small_pictures());
  EXPECT_EQ(report.movie, "");
  EXPECT_EQ(report.why_no_movie, "ffmpeg failed (exit code 3): Unknown encoder libx264");
  EXPECT_EQ(picture_count(), 2);
}

// With force, only a complete movie replaces a file that no rendering made.
TEST_F(RenderTrajectory, NeverRemovesAMovieOfOthers) {
  const std::string path = write_trajectory(2);
  RenderOptions options = small_pictures();
  options.force = true;
  files::create_directory(pictures());
  const files::path mine = files::path(pictures()) / "movie.mp4";
  std::ofstream(mine) << "mine";
  EXPECT_EQ(render_trajectory(path, pictures(), options).why_no_movie,
            "ffmpeg not found: no movie");
  EXPECT_EQ(text_of(mine), "mine");
  install_ffmpeg("echo half > \"$movie\"; exit 1");
  EXPECT_EQ(render_trajectory(path, pictures(), options).why_no_movie,
            "ffmpeg failed (exit code 1)");
  EXPECT_EQ(text_of(mine), "mine");
  const files::directory_iterator left(pictures());
  EXPECT_EQ(std::distance(begin(left), end(left)), 3) << "two pictures and the movie";
  install_ffmpeg("echo \"$@\" > \"$movie\"");
  EXPECT_EQ(render_trajectory(path, pictures(), options).movie, mine.string());
  EXPECT_NE(text_of(mine), "mine");
}

// A movie of an earlier rendering does not match the new pictures.
TEST_F(RenderTrajectory, RemovesItsOlderMovie) {
  const std::string path = write_trajectory(2);
  install_ffmpeg("echo \"$@\" > \"$movie\"");
  const std::string movie = render_trajectory(path, pictures(), small_pictures()).movie;
  EXPECT_TRUE(files::exists(movie));
  install_ffmpeg("exit 1");
  render_trajectory(path, pictures(), small_pictures());
  EXPECT_FALSE(files::exists(movie));
}

// No process has the largest number that a temporary file can have.
TEST_F(RenderTrajectory, RemovesWhatKilledRenderingsLeft) {
  files::create_directory(pictures());
  const std::string killed = ".2147483647.tmp";
  for (const std::string name : {"frame_00001.png", "movie.mp4", "mine.png"})
    std::ofstream(files::path(pictures()) / (name + killed)) << "half";
  render_trajectory(write_trajectory(2), pictures(), small_pictures());
  EXPECT_FALSE(files::exists(files::path(pictures()) / ("frame_00001.png" + killed)));
  EXPECT_FALSE(files::exists(files::path(pictures()) / ("movie.mp4" + killed)));
  EXPECT_TRUE(files::exists(files::path(pictures()) / ("mine.png" + killed)));
}

TEST_F(RenderTrajectory, RefusesWhatCannotBeDrawn) {
  EXPECT_THROW(render_trajectory(folder_.path("missing.h5"), pictures(), small_pictures()),
               FileError);
  EXPECT_THROW(render_trajectory(write_trajectory(0), pictures(), small_pictures()),
               std::runtime_error);
}

TEST_F(RenderTrajectory, SaysWhichFolderCannotBeMade) {
  folder_.write("file", "");
  const std::string file = folder_.path("file");
  try {
    render_trajectory(write_trajectory(1), file, small_pictures());
    ADD_FAILURE();
  } catch (const FileError& error) {
    EXPECT_EQ(error.what(), file + ": cannot create: Not a directory");
  }
}

TEST_F(RenderTrajectory, NamesTheBodyThatIsNotFinite) {
  const std::string path = write_trajectory(3, std::numeric_limits<double>::infinity());
  try {
    render_trajectory(path, pictures(), small_pictures());
    ADD_FAILURE();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("frame 0: body 'sheet'"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace weft::sim::render_trajectory_test
