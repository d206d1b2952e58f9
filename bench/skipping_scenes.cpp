#include "bench/skipping_scenes.h"

#include <algorithm>
#include <cmath>

namespace weft::bench {

namespace {

std::string case_text(double duration, bool contact, const std::string& bodies,
                      const std::string& time_keys = "") {
  return "[time]\nduration = " + std::to_string(duration) + "\n" + time_keys +
         "[compute]\nbackend = \"cpu\"\nthreads = 1\n[contact]\nenabled = " +
         (contact ? "true" : "false") +
         "\n[material.cloth]\ndensity = 0.2\nmembrane_stiffness = 500\nbending_stiffness = 1e-4\n"
         "stiffness_damping = 1e-3\n" +
         bodies;
}

std::string place(double x, double y, double z) {
  return "position = [" + std::to_string(x) + ", " + std::to_string(y) + ", " + std::to_string(z) +
         "]\n";
}

std::string sheet(const std::string& name, const std::string& more, double size, int vertices) {
  const std::string n = std::to_string(vertices), side = std::to_string(size);
  return "[[body]]\nname = \"" + name + "\"\n" + more + "shape = { type = \"rectangle\", size = [" +
         side + ", " + side + "], resolution = [" + n + ", " + n + "] }\n";
}

std::string drape() {
  return sheet("sheet", place(0, 0, 0.26), 1.6, 17) +
         "[[obstacle]]\nname = \"torus\"\nshape = { type = \"torus\", major_radius = 0.6, "
         "minor_radius = 0.25, resolution = [24, 12] }\n";
}

// Spheres in a row 100 m away.
std::string far_obstacles(int count) {
  std::string text;
  for (int i = 0; i < count; ++i) {
    text += "[[obstacle]]\nname = \"far_" + std::to_string(i) + "\"\n" +
            place(100, 2.0 * i - count, 0) +
            "shape = { type = \"sphere\", radius = 0.5, resolution = [9] }\n";
  }
  return text;
}

// A torus of 512 x 512 vertices that turns, 100 m away.
std::string turning_torus() {
  return "[[obstacle]]\nname = \"turning\"\n" + place(100, 0, 0) +
         "shape = { type = \"torus\", major_radius = 0.6, minor_radius = 0.25, resolution = [512, "
         "512] }\nmotion = { angular_velocity_deg = [0, 90, 180] }\n";
}

// In a square grid, 1 m apart.
std::string small_sheets(int count) {
  const int side = static_cast<int>(std::sqrt(count));
  std::string text;
  for (int i = 0; i < count; ++i)
    text += sheet("sheet_" + std::to_string(i), place(i % side, i / side, 0), 0.5, 3);
  return text;
}

std::string hanging_sheet(int vertices) {
  return sheet("sheet", "material = \"cloth\"\n", 1, vertices) +
         "[[body.pin]]\ncorners = [\"last_first\", \"last_last\"]\n";
}

std::string held_sheets(int count) {
  std::string text;
  for (int i = 0; i < count; ++i) {
    text += sheet("held_" + std::to_string(i), place(3.0 * (i + 1), 0, 0), 1, 33) +
            "[[body.pin]]\nrows = [0, -1]\n";
  }
  return text;
}

// Upright sheets held by their upper edges: gravity stretches them by a millimetre, and they are at
// rest within a second.
std::string resting_sheets(int count) {
  std::string text =
      "[material.damped]\ndensity = 0.2\nmembrane_stiffness = 500\nbending_stiffness = 1e-4\n"
      "stiffness_damping = 1e-3\nmass_damping = 20\n";
  for (int i = 0; i < count; ++i) {
    text += sheet("resting_" + std::to_string(i),
                  place(3.0 * (i + 1), 0, 0) + "rotation_deg = [90, 0, 0]\nmaterial = \"damped\"\n",
                  1, 17) +
            "[[body.pin]]\nedges = [\"last_row\"]\n";
  }
  return text;
}

std::string ten_sheets(const std::string& time_keys = "") {
  return case_text(10, true, hanging_sheet(17) + resting_sheets(9), time_keys);
}

SkippingPair far(int count, double bar) {
  const std::string number = std::to_string(count);
  return {"far-" + number, number + " obstacles 100 m from a drape of 17 x 17 vertices",
          case_text(1, true, drape()), case_text(1, true, drape() + far_obstacles(count)), bar};
}

SkippingPair apart(int count) {
  const std::string number = std::to_string(count);
  const double duration = std::min(1.0, 320.0 / count);  // s
  return {"apart-" + number, "contact on over off: " + number + " bodies of 9 vertices, 1 m apart",
          case_text(duration, false, small_sheets(count)),
          case_text(duration, true, small_sheets(count)), 1.2};
}

}  // namespace

std::vector<SkippingPair> skipping_pairs() {
  return {
      far(100, 1.05),
      far(1000, 1.1),
      {"turning-512", "a torus of 512 x 512 vertices that turns 100 m from a drape of 17 x 17",
       case_text(1, true, drape()), case_text(1, true, drape() + turning_torus()), 0},
      apart(100),
      apart(400),
      apart(1600),
      {"held-4", "4 bodies of 33 x 33 vertices that pins hold, beside a sheet",
       case_text(0.5, true, hanging_sheet(33)),
       case_text(0.5, true, hanging_sheet(33) + held_sheets(4)), 1.1},
      {"resting-9", "9 sheets that come to rest beside one that swings, all of 17 x 17 vertices",
       case_text(10, true, hanging_sheet(17)), ten_sheets(), 0, false},
      {"asleep-9", "the same ten sheets, with sleep over without", ten_sheets("sleep = false\n"),
       ten_sheets(), 1.0 / 3, false}};
}

}  // namespace weft::bench
