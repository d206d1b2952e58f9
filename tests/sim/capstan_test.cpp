// A strip of cloth around a fixed cylinder against the capstan equation.
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "tests/sim/simulated_case.h"
#include "tests/temporary_folder.h"

namespace weft::sim::capstan_test {
namespace {

constexpr double radius = 0.1;       // m, of the cylinder
constexpr double width = 0.01;       // m, of the strip
constexpr double lead = 0.06;        // m, of the straight parts
constexpr double edge = 2.65e-3;     // m, of the mesh along the strip, nearly
constexpr double load = 0.01;        // N, the tension of the end that is not pulled
constexpr double thickness = 1e-3;   // m
constexpr double range = 1e-3;       // m
constexpr double pull_speed = 0.02;  // m/s

// A strip along the arc length s from its pulled end: straight up to `lead`, then around the y axis
// by `angle` (rad), then straight again.
class WoundStrip {
 public:
  explicit WoundStrip(double angle)
      : angle_(angle),
        length_(2 * lead + distance_ * angle),
        columns_(std::lround(length_ / edge)) {}

  Vec3 at(double s) const {
    const double turned = std::clamp((s - lead) / distance_, 0.0, angle_);
    return distance_ * Vec3(std::sin(turned), 0, std::cos(turned)) +
           (s - lead - distance_ * turned) * along(turned);
  }
  Vec3 direction_of_load() const { return along(angle_); }

  // Writes the strip as a dataset "strip" of two rows.
  void write(const std::string& path) const {
    std::vector<double> values;
    for (const double y : {-0.5 * width, 0.5 * width}) {
      for (long i = 0; i < columns_; ++i) {
        const Vec3 x = at(length_ * static_cast<double>(i) / static_cast<double>(columns_ - 1));
        values.insert(values.end(), {x.x(), y, x.z()});
      }
    }
    const std::array<hsize_t, 3> size{2, static_cast<hsize_t>(columns_), 3};
    const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t space = H5Screate_simple(3, size.data(), nullptr);
    const hid_t dataset =
        H5Dcreate2(file, "strip", H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Dclose(dataset);
    H5Sclose(space);
    H5Fclose(file);
  }

 private:
  static Vec3 along(double turned) { return {std::cos(turned), 0, -std::sin(turned)}; }

  static constexpr double distance_ = radius + thickness + 0.95 * range;
  double angle_, length_;
  long columns_;
};

std::string number(double value) {
  std::ostringstream text;
  text.precision(17);
  text << value;
  return text.str();
}

// Returns the case of a strip that write() has written to `path`.
std::string pulled_strip(const WoundStrip& strip, const std::string& path, double friction) {
  const Vec3 force = 0.5 * load * strip.direction_of_load();  // on each vertex of the end
  return "[time]\nduration = 10\nposition_tolerance = 5e-7\n[world]\ngravity = [0, 0, 0]\n"
         "[contact]\nrange = " +
         number(range) + "\nfriction_speed = 1e-3\n" +
         "[[contact.pair]]\nbetween = [\"strip\", \"post\"]\nfriction = " + number(friction) +
         "\n[material.cloth]\nstiffness_damping = 1e-3\n"
         "[[body]]\nname = \"strip\"\nself_contact = false\n"
         "shape = { type = \"file\", path = \"" +
         path +
         "\", dataset = \"strip\" }\n"
         "[[body.pin]]\nedges = [\"first_col\"]\nmotion = { velocity = [" +
         number(-pull_speed) + ", 0, 0] }\n[[load]]\nbody = \"strip\"\nedges = [\"last_col\"]\n" +
         "force = [" + number(force.x()) + ", 0, " + number(force.z()) +
         "]\n[[obstacle]]\nname = \"post\"\nrotation_deg = [90, 0, 0]\n"
         "shape = { type = \"cylinder\", radius = " +
         number(radius) + ", length = 0.03, resolution = [2, 361] }\n";
}

// Returns the mean force (N) that pulls the strip, over `count` states.
double mean_pull(SimulatedCase& sim, double from, double to, int count) {
  double sum = 0;
  ForceParts parts;
  for (int i = 0; i < count; ++i) {
    const double time = from + (to - from) * i / (count - 1);
    sim.dynamics().find_force_parts(time, sim.advance_to(time), parts);
    for (const Vec3& force : parts.support) sum -= force.x();
  }
  return sum / count;
}

// The tension grows by exp(mu angle) where all of the strip slides (Euler 1769).
TEST(Capstan, TensionGrowsExponentiallyWithTheAngle) {
  const TemporaryFolder folder;
  for (const double degrees : {90.0, 180.0, 360.0}) {
    const double angle = degrees * std::numbers::pi / 180;
    const WoundStrip strip(angle);
    const std::string path = folder.path("strip_" + number(degrees) + ".h5");
    strip.write(path);
    for (const double friction : {0.3, 0.6}) {
      SimulatedCase sim(pulled_strip(strip, path, friction));
      const double ratio = mean_pull(sim, 0.5, 0.8, 61) / load;
      EXPECT_NEAR(ratio / std::exp(friction * angle), 1, 0.01)
          << degrees << " degrees, friction " << friction;
    }
  }
}

}  // namespace
}  // namespace weft::sim::capstan_test
