// HDF5 files whose datasets, links and sizes are not as Weft writes them. They are refused in words
// before memory is allocated or another file is opened.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <array>
#include <fstream>
#include <functional>
#include <string_view>

#include "sim/scene/texel_file.h"
#include "sim/view/trajectory_info.h"
#include "tests/sim/trajectory_fixture.h"

namespace weft::sim::untrusted_file_test {
namespace {

class UntrustedFile : public TrajectoryFolder {
 protected:
  void SetUp() override {
    std::vector<TrajectoryBody> bodies = {make_body("cloth", {{.rows = 3, .cols = 4}}),
                                          make_body("floor", {{.rows = 2, .cols = 2}})};
    bodies[0].fields = {{"heat", "K", "heat", 1}};
    bodies[1].moves = false;
    bodies[1].is_obstacle = true;
    const auto values = scene_values(bodies, 0);
    const std::vector<double> heat = scene_heats(bodies, 0)[0];
    TrajectoryWriter writer(path("run.h5"), bodies, {{"energy", "J"}},
                            {.force = true, .sewn = {{0, 0, 0, 3}}}, views(values));
    writer.write_frame(0, views(values), {{{heat}, {}}, {}}, std::vector<double>{1});
  }
  // Changes the file by plain HDF5.
  void change(const std::function<void(hid_t file)>& by) const {
    const hid_t file = H5Fopen(path("run.h5").c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    ASSERT_GE(file, 0);
    by(file);
    H5Fclose(file);
  }
  // Puts another dataset of doubles in the place of `name`, with the attributes of the old one.
  // `prepare` sets its creation properties.
  static void replace(hid_t file, const std::string& name, const std::vector<hsize_t>& shape,
                      const std::function<void(hid_t properties)>& prepare) {
    ASSERT_GE(H5Lmove(file, name.c_str(), file, "before", H5P_DEFAULT, H5P_DEFAULT), 0);
    const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
    const std::vector<hsize_t> limits(shape.size(), H5S_UNLIMITED);
    prepare(properties);
    const bool grows = H5Pget_layout(properties) == H5D_CHUNKED;
    const hid_t space = H5Screate_simple(static_cast<int>(shape.size()), shape.data(),
                                         grows ? limits.data() : nullptr);
    hid_t made =
        H5Dcreate2(file, name.c_str(), H5T_IEEE_F64LE, space, H5P_DEFAULT, properties, H5P_DEFAULT);
    ASSERT_GE(made, 0) << name;
    const hid_t before = H5Dopen2(file, "before", H5P_DEFAULT);
    H5Aiterate2(before, H5_INDEX_NAME, H5_ITER_INC, nullptr, copy_text, &made);
    for (const hid_t id : {before, made}) H5Dclose(id);
    H5Sclose(space);
    H5Pclose(properties);
  }
  std::string refusal() const {
    try {
      summarise_trajectory(path("run.h5"));
      return "accepted";
    } catch (const FileError& error) {
      return error.what();
    }
  }
  void expect_refusal(const std::string& part) const {
    EXPECT_NE(refusal().find(part), std::string::npos) << refusal();
  }

 private:
  static herr_t copy_text(hid_t from, const char* name, const H5A_info_t*, void* to) {
    const hid_t attribute = H5Aopen(from, name, H5P_DEFAULT);
    const hid_t type = H5Aget_type(attribute), space = H5Screate(H5S_SCALAR);
    char* text = nullptr;
    EXPECT_GE(H5Aread(attribute, type, &text), 0);
    const hid_t copy =
        H5Acreate2(*static_cast<const hid_t*>(to), name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    EXPECT_GE(H5Awrite(copy, type, &text), 0);
    H5free_memory(text);
    for (const hid_t id : {attribute, copy}) H5Aclose(id);
    H5Tclose(type);
    H5Sclose(space);
    return 0;
  }
};

TEST_F(UntrustedFile, IsReadAsItWasWritten) { EXPECT_EQ(refusal(), "accepted"); }

TEST_F(UntrustedFile, MayNotTakeNumbersFromOtherFiles) {
  std::ofstream(path("numbers")) << std::string(4096, 'a');
  const std::vector<hsize_t> image{1, 3, 4, 3}, heat{1, 3, 4};
  for (const auto& [name, shape] :
       {std::pair("body/cloth/position", image), std::pair("body/cloth/heat", heat),
        std::pair("time", std::vector<hsize_t>{1}),
        std::pair("series/energy", std::vector<hsize_t>{1})}) {
    SetUp();
    change([&, name = name, shape = shape](hid_t file) {
      replace(file, name, shape, [&](hid_t properties) {
        H5Pset_external(properties, path("numbers").c_str(), 0, H5F_UNLIMITED);
      });
    });
    expect_refusal("takes its numbers from elsewhere (external storage)");
  }
}

TEST_F(UntrustedFile, MayNotTakeNumbersFromOtherDatasets) {
  const auto take_from = [](const std::vector<hsize_t>& shape, const char* file) {
    return [shape, file](hid_t properties) {
      const hid_t space = H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr);
      H5Pset_virtual(properties, space, file, "source", space);
      H5Sclose(space);
    };
  };
  change([&](hid_t file) {
    // A shape of 3 GB of memory, in a file of a few kilobytes.
    const std::vector<hsize_t> shape{11000, 11000, 3};
    replace(file, "body/floor/position", shape, take_from(shape, "other.h5"));
  });
  expect_refusal("takes its numbers from elsewhere (virtual storage)");
  EXPECT_THROW(read_texels(path("run.h5"), "/body/floor/position"), FileError);
  SetUp();
  change([&](hid_t file) {
    replace(file, "body/cloth/heat", {1, 3, 4}, take_from({1, 3, 4}, "."));
  });
  expect_refusal("dataset heat takes its numbers from elsewhere (virtual storage)");
}

// A pipe at the end of a link would be waited for.
TEST_F(UntrustedFile, HasNoLinksToOtherFiles) {
  ASSERT_EQ(mkfifo(path("pipe.h5").c_str(), 0600), 0);
  for (const char* name : {"body", "body/cloth", "body/cloth/position", "series", "time", "sewn"}) {
    SetUp();
    change([&](hid_t file) {
      H5Lmove(file, name, file, "before", H5P_DEFAULT, H5P_DEFAULT);
      H5Lcreate_external("pipe.h5", "/any", file, name, H5P_DEFAULT, H5P_DEFAULT);
    });
    expect_refusal("cannot open ");
    if (!std::string_view(name).starts_with("body")) continue;
    EXPECT_THROW(read_texels(path("run.h5"), "/body/cloth/position"), FileError);
  }
}

TEST_F(UntrustedFile, ClaimsNoMorePairsThanItStores) {
  const auto chunked = [](hid_t properties) {
    const std::array<hsize_t, 2> chunk{16, 4};
    H5Pset_chunk(properties, 2, chunk.data());
  };
  // Four times 2^62 is 0 in 64 bits.
  for (const hsize_t pairs : {hsize_t{1} << 62, hsize_t{1} << 61, hsize_t{1} << 40}) {
    SetUp();
    change([&](hid_t file) { replace(file, "sewn", {pairs, 4}, chunked); });
    expect_refusal(" bytes and stores 0");
  }
}

// HDF5 reads whole chunks. This one takes 3.2 GB of memory and a few megabytes of the file, for a
// single number.
TEST_F(UntrustedFile, HasNoChunksMuchLargerThanTheirBytes) {
  change([&](hid_t file) {
    replace(file, "series/energy", {1}, [](hid_t properties) {
      const hsize_t chunk = 400'000'000;
      H5Pset_chunk(properties, 1, &chunk);
      H5Pset_deflate(properties, 9);
    });
    // Bytes that inflate to less than the chunk, as a damaged or a hostile file may have them.
    const hid_t dataset = H5Dopen2(file, "series/energy", H5P_DEFAULT);
    const std::array<char, 100> bytes{};
    const hsize_t start = 0;
    EXPECT_GE(H5Dwrite_chunk(dataset, H5P_DEFAULT, 0, &start, bytes.size(), bytes.data()), 0);
    H5Dclose(dataset);
  });
  expect_refusal("dataset series/energy claims 3200000000 bytes and stores 100");
}

}  // namespace
}  // namespace weft::sim::untrusted_file_test
