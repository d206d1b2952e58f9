// Scenes and positions for the oracles of contact: a sheet folded on itself, a crumpled or rolled
// one, two bodies and three.
#pragma once

#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "sim/case/case_reader.h"
#include "sim/scene/scene.h"

namespace weft::sim::contact_scenes {

using Positions = std::vector<Vec3>;

inline constexpr double thickness = 0.004, range = 0.03, slack = 0.02;  // m, of all scenes
inline constexpr double reach = thickness + range;

// The head of all scenes, with range and slack as above.
inline const std::string contact_head = R"(
[time]
duration = 1
[contact]
range = 0.03
search_slack = 0.02
)";

// A rectangular body of this size and resolution, such as "0.5, 0.5" and "4, 4".
inline std::string rectangle(const std::string& name, const std::string& size,
                             const std::string& resolution) {
  return "[[body]]\nname = \"" + name +
         "\"\nthickness = 0.004\nshape = { type = \"rectangle\", size = [" + size +
         "], resolution = [" + resolution + "] }\n";
}

inline const std::string one_sheet = contact_head + rectangle("sheet", "1, 1", "9, 9");

// A sheet whose edges are shorter than thickness + range: most triangles in reach are neighbours.
inline const std::string fine_sheet = contact_head + rectangle("sheet", "0.25, 0.25", "11, 11");

// Two strips in line; the gap between their bounding spheres is that of the strips within 2 mm.
inline const std::string two_strips =
    contact_head + rectangle("left", "1, 0.06", "2, 17") + rectangle("right", "1, 0.06", "2, 17");

inline const std::string three_plates = contact_head + rectangle("upper", "0.5, 0.5", "4, 4") +
                                        rectangle("middle", "0.5, 0.5", "4, 4") +
                                        rectangle("lower", "0.5, 0.5", "4, 4");

inline std::unique_ptr<const Scene> scene_of(const std::string& text) {
  return build_scene(parse_case(text, "test.toml"));
}

inline Positions shifted(Positions positions, double amplitude, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-amplitude, amplitude);
  for (Vec3& x : positions) {
    const double along_x = shift(random), along_y = shift(random), along_z = shift(random);
    x += Vec3(along_x, along_y, along_z);
  }
  return positions;
}

// Folds the sheet along its middle column into two layers `gap` apart, with the middle of the body
// in place.
inline Positions folded(const Scene& scene, double gap) {
  Positions positions = scene.initial_position;
  for (Vec3& x : positions) {
    const double side = std::abs(x.x()) < 1e-9 ? 0 : x.x() < 0 ? -1 : 1;
    x = Vec3(-std::abs(x.x()) + 0.01 * side, x.y() + 0.015 * side, 0.5 * gap * side);
  }
  return positions;
}

// Folds the sheet into narrow pleats and squeezes it along them until opposite edges of one quad
// are in reach.
inline Positions crumpled(const Scene& scene, unsigned seed) {
  Positions positions = scene.initial_position;
  for (Vec3& x : positions) {
    const bool odd = std::lround(8 * (x.x() + 0.5)) % 2 == 1;
    x = Vec3(0.12 * x.x(), 0.2 * x.y(), odd ? 0.12 : 0);
  }
  return shifted(positions, 0.003, seed);
}

inline Positions strips(const Scene& scene, const Vec3& between) {
  Positions positions = scene.initial_position;
  const int count = scene.bodies[0].particle_count();
  for (int i = 0; i < scene.particle_count; ++i)
    positions[i] += i < count ? Vec3(-0.5, 0, 0) : Vec3(Vec3(0.5, 0, 0) + between);
  return positions;
}

// Puts the middle plate at the origin, the upper one above it, the lower one below its edge.
inline Positions plates(const Scene& scene, double upper, double lower) {
  Positions positions = scene.initial_position;
  const Vec3 places[] = {{0, 0, upper}, {0, 0, 0}, {0.45, 0, -lower}};
  for (int b = 0; b < 3; ++b) {
    const SceneBody& body = scene.bodies[b];
    for (int i = 0; i < body.particle_count(); ++i) positions[body.first_particle + i] += places[b];
  }
  return positions;
}

// Rolls the sheet up about y by this angle, and lays its ends over each other if the angle exceeds
// a turn: the radius grows by `rise` from one end to the other.
inline Positions rolled(const Scene& scene, double angle, double rise) {
  Positions positions = scene.initial_position;
  for (Vec3& x : positions) {
    const double part = x.x() / 0.25 + 0.5, turned = angle * part;
    const double radius = 0.25 / angle + rise * (part - 0.5);
    x = Vec3(radius * std::sin(turned), x.y(), -radius * std::cos(turned));
  }
  return positions;
}

}  // namespace weft::sim::contact_scenes
