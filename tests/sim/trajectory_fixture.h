// A folder for one test, and a small scene whose positions are a formula of body, particle and
// frame.
#pragma once

#include <gtest/gtest.h>
#include <hdf5.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <span>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

#include "sim/base/file_error.h"
#include "sim/trajectory/trajectory.h"
#include "tests/temporary_folder.h"

namespace weft::sim {

class TrajectoryFolder : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_.path(name); }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
      names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }
  static std::string message_of(const std::function<void()>& action) {
    try {
      action();
    } catch (const FileError& error) {
      return error.what();
    }
    return "no error";
  }
  static std::string contents(const std::string& file) {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
  }

 private:
  TemporaryFolder folder_;
};

inline TrajectoryBody make_body(const std::string& name, std::vector<bsi::Patch> patches,
                                std::vector<int> texel_to_particle = {}) {
  TrajectoryBody body;
  body.name = name;
  body.atlas = bsi::Atlas(std::move(patches), std::move(texel_to_particle));
  return body;
}

// The value of a particle in a frame. All values are small dyadic numbers, which float32 holds
// exactly.
inline Vec3 scene_value(std::size_t body, std::size_t particle, int frame) {
  const auto p = static_cast<double>(particle);
  return {p * 0.25, static_cast<double>(body) - 0.5 * p, 100.0 * frame + p};
}

inline std::vector<std::vector<Vec3>> scene_values(const std::vector<TrajectoryBody>& bodies,
                                                   int frame) {
  std::vector<std::vector<Vec3>> values;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    auto& list = values.emplace_back();
    for (int p = 0; p < bodies[b].atlas.particle_count(); ++p) {
      list.push_back(scene_value(b, static_cast<std::size_t>(p), frame));
    }
  }
  return values;
}

// One number per particle.
inline std::vector<std::vector<double>> scene_heats(const std::vector<TrajectoryBody>& bodies,
                                                    int frame) {
  std::vector<std::vector<double>> values;
  for (const std::vector<Vec3>& of_body : scene_values(bodies, frame)) {
    auto& list = values.emplace_back();
    for (const Vec3& value : of_body) list.push_back(0.5 * value.x() - value.z());
  }
  return values;
}

inline std::vector<std::span<const Vec3>> views(const std::vector<std::vector<Vec3>>& values) {
  return {values.begin(), values.end()};
}

// Reads a dataset like any other program: by plain HDF5, without Weft's code.
template <typename Number>
std::vector<Number> read_numbers(const std::string& file_name, const std::string& name) {
  static_assert(std::is_same_v<Number, float> || std::is_same_v<Number, int>);
  const hid_t file = H5Fopen(file_name.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t dataset = H5Dopen2(file, name.c_str(), H5P_DEFAULT);
  EXPECT_GE(dataset, 0) << file_name << ": " << name;
  if (dataset < 0) return {};
  const hid_t space = H5Dget_space(dataset);
  std::vector<Number> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
  const hid_t type = std::is_same_v<Number, float> ? H5T_NATIVE_FLOAT : H5T_NATIVE_INT;
  EXPECT_GE(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0);
  H5Sclose(space);
  H5Dclose(dataset);
  H5Fclose(file);
  return values;
}

}  // namespace weft::sim
