#include "tests/moving/moving_scenes.h"

#include <hdf5.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <numbers>
#include <random>
#include <stdexcept>

#include "tests/moving/moving_table.h"

namespace weft::moving {

namespace {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using std::numbers::pi;

constexpr double density = 0.2;                    // kg/m^2
constexpr double range = 4e-3, thickness = 1e-3;   // m
constexpr double least_stiffness = 1e6;            // of contact, N/m^3
constexpr double reserve = 3;                      // factor of contact's strength if it must hold
constexpr double easing = 1.875;                   // largest speed between two keyframes / its mean
constexpr double settling = 0.03;                  // s, after the last movement
constexpr double longest_rest_of_fixed_steps = 2;  // s
constexpr int most_explicit_steps_of_rest = 2000;
constexpr double layers_apart = 0.03;   // m, of a folded sheet
constexpr double clear_of_pins = 0.03;  // m
constexpr std::array methods{"cvode", "arkode", "euler", "euler-step", "euler-linear", "verlet"};

std::string print(const char* format, ...) {
  char buffer[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof buffer, format, arguments);
  va_end(arguments);
  return buffer;
}
std::string text_of(const Vec3& v) { return print("[%.9g, %.9g, %.9g]", v.x(), v.y(), v.z()); }
Vec3 degrees(const Vec3& rotation) { return rotation * (180 / pi); }
Vec3 rotation_vector(const Mat3& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.axis() * turn.angle();
}

// Random numbers that are the same with every library.
class Random {
 public:
  explicit Random(unsigned seed) : source_(seed) {}
  double between(double low, double high) {
    return low + (high - low) * std::ldexp(static_cast<double>(source_() >> 11), -53);
  }
  bool coin(double share) { return between(0, 1) < share; }
  Vec3 direction() {
    for (;;) {
      const Vec3 v(between(-1, 1), between(-1, 1), between(-1, 1));
      if (v.norm() > 0.1 && v.norm() < 1) return v.normalized();
    }
  }

 private:
  std::mt19937_64 source_;
};

// A body in the frame of the sheet: u along its columns, v along its rows, n normal to it.
struct Body {
  Thing thing = Thing::ball;
  std::string shape;
  Vec3 half{0, 0, 0};  // extents of its own box
  Mat3 turn = Mat3::Identity();
  Vec3 centre{0, 0, 0};
  double side = 1;     // of the sheet, on which it starts
  double reach_u = 0;  // from its centre, along the sheet
  double top_v = 0;    // largest v at which it meets the sheet
  double depth = 0;    // beyond the sheet's plane
  std::string motion;

  double extent(const Vec3& along) const {
    if (thing == Thing::ball) return half.x();
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += half[k] * std::abs(turn.col(k).dot(along));
    return sum;
  }
  double radius() const { return thing == Thing::ball ? half.x() : half.norm(); }
};

class Maker {
 public:
  Maker(int number, int seed, const std::string& folder)
      : row_(scene_table()[static_cast<std::size_t>(number)]),
        random_(static_cast<unsigned>(1000 * number + seed)),
        folder_(folder) {
    scene_.number = number;
    scene_.seed = seed;
    scene_.name = row_.name;
    choose_method();
    if (hangs()) frame_ = Eigen::AngleAxisd(pi / 2, Vec3::UnitX()).toRotationMatrix();
  }

  MovingScene make() {
    size_ = random_.between(0.45, 0.55);
    rows_ = 9 + 2 * static_cast<int>(random_.between(0, 3));
    const double rest = row_.rest * random_.between(0.5, 1);
    scene_.start = is_adaptive() ? rest : std::min(rest, longest_rest());
    for (std::size_t i = 0; i < row_.things.size(); ++i) add_thing(i);
    move_pins();
    judge();
    scene_.end += settling;
    scene_.text = time_text() + world_text() + sheet_text() + things_text();
    return scene_;
  }

 private:
  bool hangs() const { return row_.sheet == Sheet::hanging || row_.sheet == Sheet::corners; }
  bool is_adaptive() const {
    return scene_.method == "cvode" || scene_.method == "arkode" || scene_.method == "euler";
  }
  bool is_explicit() const { return scene_.method == "verlet"; }
  // The longest rest. Fixed steps, and steps limited by stability, are not longer at rest.
  double longest_rest() const {
    return is_explicit() ? most_explicit_steps_of_rest * explicit_step(row_.speed + row_.pin_speed)
                         : longest_rest_of_fixed_steps;
  }
  // Returns a step (s) that resolves the range by forty steps at this approach speed (m/s, or
  // turns/s of a body of some 0.2 m). Verlet follows the limit of stability by itself, but that
  // does not depend on approaches.
  double explicit_step(double speed) const {
    const bool turns = row_.course == Course::sweep || row_.course == Course::spin ||
                       row_.pins == Pins::twist || row_.pins == Pins::turn;
    return std::min(2e-5, range / (40 * (turns ? 2 * pi * 0.2 * speed : speed)));
  }
  // Verlet needs motion without damping, and without damping hanging sheets do not come to rest.
  void choose_method() {
    scene_.method = methods[static_cast<std::size_t>(scene_.number + scene_.seed) % methods.size()];
    if (is_explicit() && hangs()) scene_.method = "cvode";
  }

  double depth_of_course() const {
    if (row_.course == Course::creep) return 0.03;
    if (row_.course == Course::clamp) return 0.02;
    const double share = row_.things.size() > 1 && row_.both_sides ? 0.5 : 1;
    switch (row_.sheet) {
      case Sheet::pinned:
        return 0.08 * share;
      case Sheet::hanging:
        return 0.15 * share;
      default:
        return 0.1 * share;
    }
  }

  void shape(Body& body, double scale) {
    switch (body.thing) {
      case Thing::ball: {
        const double radius = 0.07 * scale;
        body.half = Vec3::Constant(radius);
        body.shape = print(R"({ type = "sphere", radius = %.9g, resolution = [5] })", radius);
        return;
      }
      case Thing::paddle:
        return rectangle(body, 0.2 * scale, 0.08 * scale, 3, 5);
      case Thing::plate:
        return rectangle(body, 0.26 * scale, 0.26 * scale, 7, 7);
      case Thing::wall:
        return rectangle(body, 0.8, 0.8, 7, 7);
      case Thing::needle: {
        const double radius = random_.between(0.002, 0.004), length = 0.24 * scale;
        body.half = Vec3(radius, radius, length / 2);
        body.shape =
            print(R"({ type = "cylinder", radius = %.9g, length = %.9g, resolution = [7, 6] })",
                  radius, length);
        return;
      }
      case Thing::torus: {
        const double major = 0.08 * scale, minor = 0.02 * scale;
        body.half = Vec3(major + minor, major + minor, minor);
        body.shape = print(R"({ type = "torus", major_radius = %.9g, minor_radius = %.9g, )"
                           R"(resolution = [16, 8] })",
                           major, minor);
        return;
      }
    }
  }
  static void rectangle(Body& body, double x, double y, int rows, int columns) {
    body.half = Vec3(x / 2, y / 2, 0);
    body.shape = print(R"({ type = "rectangle", size = [%.9g, %.9g], resolution = [%d, %d] })", x,
                       y, rows, columns);
  }

  // Flat bodies meet the sheet with their face or an edge; those on an arm with their face.
  void orient(Body& body) {
    const Mat3 upright = Eigen::AngleAxisd(pi / 2, Vec3::UnitX()).toRotationMatrix();
    if (row_.course == Course::sweep) {
      const bool is_flat = body.thing == Thing::paddle || body.thing == Thing::plate;
      if (is_flat) body.turn = upright;
      return;
    }
    if (body.thing != Thing::wall && random_.coin(0.3)) body.turn = upright;
    const double tilt = row_.course == Course::clamp ? 0 : random_.between(0, 0.35);
    body.turn = Eigen::AngleAxisd(tilt, random_.direction()).toRotationMatrix() * body.turn;
  }

  void add_thing(std::size_t index) {
    const std::size_t count = row_.things.size();
    Body body;
    body.thing = row_.things[index];
    shape(body, random_.between(0.85, 1.15) * (count > 1 ? 0.5 : 1));
    orient(body);
    const double place =
        count == 1 ? random_.between(-0.03, 0.03)
        : row_.course == Course::clamp
            ? 0
            : 0.26 * static_cast<double>(index) / static_cast<double>(count - 1) - 0.13;
    body.centre = Vec3(place, random_.between(-0.03, 0.03) - (hangs() ? 0.06 : 0), 0);
    body.side = row_.both_sides && index % 2 == 1 ? -1 : 1;
    body.depth = depth_of_course();
    const double delay = index == 0 ? 0 : random_.between(0, 0.01);
    const double clearance = row_.course == Course::creep ? 0.006 : random_.between(0.008, 0.03);
    const double speed = row_.speed * random_.between(0.8, 1);
    const double start = scene_.start + delay;
    const double half_fold = row_.sheet == Sheet::folded ? layers_apart / 2 : 0;
    switch (row_.course) {
      case Course::sweep:
        sweep(body, start, speed);
        break;
      case Course::spin:
        spin(body, start, speed, clearance + half_fold);
        break;
      default:
        push(body, start, speed, clearance + half_fold);
        break;
    }
    bodies_.push_back(body);
  }

  Vec3 world(const Vec3& local) const { return frame_ * local; }
  void finish_at(double time) { scene_.end = std::max(scene_.end, time); }
  void note_speed(double speed) { scene_.fastest = std::max(scene_.fastest, speed); }

  // Moves a body straight across the sheet's plane: at once, eased, there and back, or to and fro.
  void push(Body& body, double start, double speed, double clearance) {
    const Vec3 across(0, 0, -body.side);
    body.centre.z() = body.side * (body.extent(Vec3::UnitZ()) + clearance);
    body.reach_u = body.extent(Vec3::UnitX());
    body.top_v = body.centre.y() + body.extent(Vec3::UnitY());
    const double travel = clearance + body.depth;
    note_speed(speed);
    if (row_.course == Course::through || row_.course == Course::creep ||
        row_.course == Course::clamp) {
      const double stop = start + travel / speed;
      body.motion = print("velocity = %s\nstart_time = %.9g\nstop_time = %.9g\n",
                          text_of(world(across * speed)).c_str(), start, stop);
      return finish_at(stop);
    }
    const std::vector<double> places = row_.course == Course::eased ? std::vector<double>{0, 1}
                                       : row_.course == Course::back
                                           ? std::vector<double>{0, 1, 0}
                                           : std::vector<double>{0, 1, 0.5, 1, 0.5, 1, 0};
    const double longest = easing * travel / speed;  // s
    body.motion = "keyframes = [";
    double time = start;
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (i > 0) time += longest * std::abs(places[i] - places[i - 1]);
      body.motion += print("{ time = %.9g, translation = %s },", time,
                           text_of(world(across * (travel * places[i]))).c_str());
    }
    body.motion += "]\n";
    finish_at(time);
  }

  // Moves a body on an arm about an axis beside the sheet, at `rate` turns per second.
  void sweep(Body& body, double start, double rate) {
    constexpr double arm = 0.12;
    const double far = std::hypot(arm + body.extent(Vec3::UnitZ()), body.extent(Vec3::UnitY()));
    const double above = far - body.depth;
    Vec3 axis_place = body.centre;
    axis_place.z() = body.side * above;
    body.centre.z() = body.side * (above + arm);
    body.reach_u = body.extent(Vec3::UnitX());
    body.top_v = body.centre.y() + std::sqrt(far * far - above * above);
    const double stop = start + std::clamp(0.2 * rate, 0.75, 2.0) / rate;
    const double way = random_.coin(0.5) ? 1 : -1;
    body.motion =
        print("centre = %s\nangular_velocity_deg = %s\nstart_time = %.9g\nstop_time = %.9g\n",
              text_of(world(axis_place)).c_str(),
              text_of(world(Vec3(way * rate * 360, 0, 0))).c_str(), start, stop);
    note_speed(2 * pi * rate * std::hypot(far, 0.0));
    finish_at(stop);
  }

  // Spins a body about its own axis while it approaches at 1 m/s.
  void spin(Body& body, double start, double rate, double clearance) {
    constexpr double approach = 1;  // m/s
    const double radius = body.radius();
    body.centre.z() = body.side * (radius + clearance);
    body.reach_u = radius;
    body.top_v = body.centre.y() + radius;
    const double stop = start + (clearance + body.depth) / approach;
    const Vec3 axis = random_.direction();
    body.motion =
        print("velocity = %s\nangular_velocity_deg = %s\nstart_time = %.9g\nstop_time = %.9g\n",
              text_of(world(Vec3(0, 0, -body.side * approach))).c_str(),
              text_of(world(axis * (rate * 360))).c_str(), start, stop);
    note_speed(approach + 2 * pi * rate * radius);
    finish_at(stop);
  }

  struct PinMotion {
    std::string vertices;                    // the keys that select them
    Vec3 shift{0, 0, 0}, rotation{0, 0, 0};  // m, rad: how far they go
    bool returns = false;
  };

  void move_pins() {
    const double radius = size_ / 2 * std::sqrt(2.0);
    const Vec3 vertical = random_.coin(0.5) ? Vec3::UnitZ() : Vec3::UnitX();
    switch (row_.pins) {
      case Pins::still:
        return;
      case Pins::twist: {
        const double half = random_.between(25, 35) * pi / 180;
        pins_ = {{"first_col", {0, 0, 0}, {-half, 0, 0}}, {"last_col", {0, 0, 0}, {half, 0, 0}}};
        scene_.stretch = std::hypot(1, std::sin(half)) - 1;
        return time_pins(easing * half / (2 * pi * row_.pin_speed),
                         2 * pi * row_.pin_speed * size_ / 2);
      }
      case Pins::turn: {
        const Vec3 axis = hangs() ? Vec3::UnitY() : vertical;
        pins_ = {{pinned_edges(), {0, 0, 0}, 2 * pi * axis}};
        return time_pins(easing / row_.pin_speed, 2 * pi * row_.pin_speed * radius);
      }
      case Pins::jerk: {
        const double way = random_.between(0.03, 0.06);
        pins_ = {
            {pinned_edges(), hangs() ? Vec3(0, 0, way) : way * Vec3(0, 0.6, 0.8), {0, 0, 0}, true}};
        return time_pins(easing * way / row_.pin_speed, row_.pin_speed);
      }
      case Pins::pull: {
        pins_ = {{"first_col", {0, 0, 0}, {0, 0, 0}}, {"last_col", {size_ / 2, 0, 0}, {0, 0, 0}}};
        scene_.stretch = 0.5;
        return time_pins(easing * size_ / 2 / row_.pin_speed, row_.pin_speed);
      }
    }
  }
  void time_pins(double duration, double speed) {
    pin_duration_ = duration;
    note_speed(speed);
    for (const PinMotion& pin : pins_) {
      finish_at(scene_.start + (pin.returns ? 2 : 1) * pin_duration_);
    }
  }
  std::string pinned_edges() const { return hangs() ? "last_row" : R"(first_col", "last_col)"; }

  void judge() {
    const double motion_energy = density * scene_.fastest * scene_.fastest / 2;  // J/m^2
    contact_stiffness_ = row_.strength < 1
                             ? row_.strength * motion_energy / (range * range)
                             : std::max(least_stiffness, reserve * motion_energy / (range * range));
    scene_.strength = contact_stiffness_ * range * range / motion_energy;
    scene_.is_trapped = row_.course == Course::clamp;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const Body& body = bodies_[i];
      if (row_.sheet == Sheet::pinned) {
        scene_.is_trapped |= std::abs(body.centre.x()) + body.reach_u > size_ / 2 - clear_of_pins;
      }
      if (hangs()) scene_.is_trapped |= body.top_v > size_ / 2 - clear_of_pins;
      for (std::size_t j = 0; j < i; ++j) {
        const double apart = std::abs(body.centre.x() - bodies_[j].centre.x());
        scene_.is_trapped |= body.side != bodies_[j].side &&
                             apart < body.reach_u + bodies_[j].reach_u + 2 * (range + thickness);
      }
    }
    if (row_.sheet == Sheet::pinned) {
      scene_.stretch = (1 + scene_.stretch) * way_round() / size_ - 1;
    }
  }

  // Length of the path from pin to pin along what stands out of the sheet's plane, m.
  double way_round() const {
    std::vector<std::pair<double, double>> corners{{-size_ / 2, 0}, {size_ / 2, 0}};
    for (const Body& body : bodies_) {
      corners.emplace_back(body.centre.x() - body.reach_u, -body.side * body.depth);
      corners.emplace_back(body.centre.x() + body.reach_u, -body.side * body.depth);
    }
    std::sort(corners.begin(), corners.end());
    double length = 0;
    for (std::size_t i = 1; i < corners.size(); ++i) {
      length += std::hypot(corners[i].first - corners[i - 1].first,
                           corners[i].second - corners[i - 1].second);
    }
    return length;
  }

  std::string time_text() const {
    const double speed = scene_.fastest;
    std::string text = "# " + scene_.name + "\n[time]\nmethod = \"" +
                       (is_adaptive() || is_explicit() ? scene_.method : "euler") + "\"\n";
    text += print("duration = %.9g\nframes_per_second = %d\n", scene_.end, speed < 5 ? 60 : 240);
    if (is_explicit()) text += print("step = %.3g\n", explicit_step(row_.speed + row_.pin_speed));
    if (scene_.method.starts_with("euler-")) {
      text += print("step = %.3g\nnewton = %d\n", std::clamp(5e-3 / speed, 1e-4, 1e-3),
                    scene_.method == "euler-linear" ? 1 : 0);
    }
    return text;
  }

  std::string world_text() {
    const bool is_damped = hangs() || (!is_explicit() && random_.coin(0.5));
    std::string text = hangs() ? "" : "[world]\ngravity = [0, 0, 0]\n";
    text += print("[contact]\nrange = %.9g\nstiffness = %.9g\n", range, contact_stiffness_);
    if (is_explicit()) {
      text += "damping_time = 0\n";
    } else {
      // A damping time longer than an approach would outweigh the barrier.
      text += print("damping_time = %.3g\n", std::min(1e-3, range / scene_.fastest));
      if (random_.coin(0.3)) text += "friction = 0.3\n";
    }
    text += print("[material.cloth]\ndensity = %.9g\nmembrane_stiffness = %.9g\n", density,
                  std::max(1000.0, 10 * density * scene_.fastest * scene_.fastest));
    text += "bending_stiffness = 1e-5\n";
    if (is_damped) text += "stiffness_damping = 1e-3\n";
    if (hangs()) text += "mass_damping = 1\n";
    return text;
  }

  std::string sheet_text() {
    std::string text =
        "[[body]]\nname = \"sheet\"\nrotation_deg = " + text_of(degrees(rotation_vector(frame_))) +
        "\n";
    text += print("thickness = %.9g\n", thickness);
    if (row_.sheet == Sheet::folded) return text + folded_shape();
    text += print(R"(shape = { type = "rectangle", size = [%.9g, %.9g], resolution = [%d, %d] })"
                  "\n",
                  size_, size_, rows_, rows_);
    if (row_.sheet == Sheet::corners) {
      text += "[[body.pin]]\ncorners = [\"last_first\", \"last_last\"]\n";
    } else if (row_.sheet != Sheet::free && pins_.empty()) {
      text += "[[body.pin]]\nedges = [\"" + pinned_edges() + "\"]\n";
    }
    for (const PinMotion& pin : pins_) text += pin_text(pin);
    return text;
  }

  std::string pin_text(const PinMotion& pin) const {
    std::string text = "[[body.pin]]\nedges = [\"" + pin.vertices + "\"]\n[body.pin.motion]\n";
    const double middle = scene_.start + pin_duration_;
    text += print("keyframes = [{ time = %.9g }, { time = %.9g, translation = %s, ", scene_.start,
                  middle, text_of(world(pin.shift)).c_str());
    text += "rotation_deg = " + text_of(degrees(world(pin.rotation))) + " },";
    if (pin.returns) text += print(" { time = %.9g },", middle + pin_duration_);
    return text + "]\n";
  }

  // Writes two layers, joined along one column of quads, to a shape file.
  std::string folded_shape() const {
    const int half = rows_ / 2 + 1;
    const int columns = 2 * half;
    std::vector<double> places;
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns; ++column) {
        const int along = column < half ? column : columns - 1 - column;
        places.push_back(size_ / 2 * (0.5 - static_cast<double>(along) / (half - 1)) * -1);
        places.push_back(size_ * (static_cast<double>(row) / (rows_ - 1) - 0.5));
        places.push_back(column < half ? -layers_apart / 2 : layers_apart / 2);
      }
    }
    const std::string path = folder_ + "/" + print("folded_%d_%d.h5", scene_.number, scene_.seed);
    write_shape(path, places, {static_cast<hsize_t>(rows_), static_cast<hsize_t>(columns), 3});
    return R"(shape = { type = "file", path = ")" + path + R"(", dataset = "shape" })" + "\n";
  }
  static void write_shape(const std::string& path, const std::vector<double>& places,
                          const std::array<hsize_t, 3>& size) {
    const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t space = H5Screate_simple(3, size.data(), nullptr);
    const hid_t dataset =
        H5Dcreate2(file, "shape", H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    const herr_t written =
        H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, places.data());
    H5Dclose(dataset);
    H5Sclose(space);
    if (written < 0 || H5Fclose(file) < 0) throw std::runtime_error(path + ": cannot be written");
  }

  std::string things_text() const {
    std::string text;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const Body& body = bodies_[i];
      text += print("[[obstacle]]\nname = \"thing%d\"\n", static_cast<int>(i + 1));
      text += "position = " + text_of(world(body.centre)) + "\n";
      text += "rotation_deg = " + text_of(degrees(rotation_vector(frame_ * body.turn))) + "\n";
      text += "shape = " + body.shape + "\n[obstacle.motion]\n" + body.motion;
    }
    return text;
  }

  const Row& row_;
  Random random_;
  std::string folder_;
  MovingScene scene_;
  Mat3 frame_ = Mat3::Identity();
  double size_ = 0;  // m, of the sheet's sides
  int rows_ = 0;
  double contact_stiffness_ = 0;  // N/m^3
  double pin_duration_ = 0;       // s, of a way of the pins
  std::vector<Body> bodies_;
  std::vector<PinMotion> pins_;
};

}  // namespace

bool MovingScene::has_path() const {
  constexpr double greatest_stretch = 0.2;
  return !is_trapped && stretch <= greatest_stretch;
}

MovingScene make_scene(int number, int seed, const std::string& folder) {
  return Maker(number, seed, folder).make();
}

}  // namespace weft::moving
