#include "bench/scenes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <stdexcept>

namespace weft::bench {

namespace {

using bsi::Vec3;
constexpr double pi = std::numbers::pi;
constexpr double width = 2;  // of the sheets, m

// Maps the point (u, v) of a sheet, both in [0, 1], to its position (m).
using SheetMap = std::function<Vec3(double u, double v)>;

std::vector<std::array<int, 3>> triangles_of(const bsi::Atlas& atlas) {
  std::vector<std::array<int, 3>> triangles;
  triangles.reserve(2 * static_cast<std::size_t>(atlas.quad_count()));
  for (int quad = 0; quad < atlas.quad_count(); ++quad) {
    for (const auto& triangle : bsi::quad_triangles(atlas.quad_particles(quad))) {
      triangles.push_back(triangle);
    }
  }
  return triangles;
}

Body body_of(bsi::Surface surface) {
  Body body;
  body.triangles = triangles_of(surface.atlas);
  body.atlas = std::move(surface.atlas);
  body.start = std::move(surface.positions);
  return body;
}

Body make_sheet(int n, const SheetMap& map) {
  bsi::Surface sheet = bsi::make_rectangle(width, width, n, n);
  for (Vec3& p : sheet.positions) p = map(p.x() / width + 0.5, p.y() / width + 0.5);
  return body_of(std::move(sheet));
}

// Rotates points so that no fold lies along an axis: the boxes of flat pieces would be thinner than
// those of real cloth.
Vec3 turned(const Vec3& p) {
  static const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.6, Vec3(0.36, 0.48, 0.8)).toRotationMatrix();
  return turn * p;
}

// Returns the angle at which the arc of an Archimedean spiral from the inner radius has a given
// length.
double spiral_angle(double length, double inner, double pitch) {
  const double growth = pitch / (2 * pi);  // radius = inner + growth * angle
  // length = inner a + growth a^2 / 2, to order growth^2 / inner^2.
  return (std::sqrt(inner * inner + 2 * growth * length) - inner) / growth;
}

Vec3 rolled(double u, double v) {
  constexpr double inner = 0.06;
  const double distance = scene_margin * (0.8 + 0.4 * v);
  const double angle = spiral_angle(width * u, inner, distance);
  const double radius = inner + distance * angle / (2 * pi);
  return turned({radius * std::cos(angle), radius * std::sin(angle), width * v});
}

// A zigzag of period 2 and of heights between 0 and 1.
double zigzag(double t) {
  const double phase = t - 2 * std::floor(t / 2);
  return phase < 1 ? phase : 2 - phase;
}

Vec3 pleated(double u, double v) {
  constexpr int pleats = 20;
  const double distance = 0.5 * scene_margin * (0.8 + 0.4 * v);  // from a panel to the next
  const double wave = 0.01 * std::sin(9 * v);                    // along the pleats
  return turned({distance * pleats * u + wave, width * v, width / pleats * zigzag(pleats * u)});
}

// Makes pleats whose widths and distances vary, then shears along each axis by waves along the
// others. Each step maps space one to one, so layers stay apart.
Vec3 crumpled(double u, double v) {
  const double t = 24 * u + 1.5 * std::sin(2 * pi * u) + 0.8 * std::sin(7 * pi * u);
  const double height = 0.08 * zigzag(t) * (1 + 0.4 * std::sin(5 * u + 3 * v));
  Vec3 p(scene_margin * (1.3 * t + 6 * std::sin(4 * pi * u) * std::sin(4 * pi * u) * u), width * v,
         height);
  constexpr int waves = 6;
  for (int k = 0; k < waves; ++k) {
    const int to = k % 3, from = (k + 1) % 3;
    const double length = 0.5 / (1 + 0.5 * k);
    p[to] += 0.12 * length * std::sin(2 * pi / length * (p[from] + 0.37 * p[(k + 2) % 3]) + k);
  }
  return turned(p);
}

// Drapes the sheet over a ball of 0.4 m; the part beyond its equator hangs down in eight folds.
Vec3 draped(double u, double v) {
  constexpr double ball = 0.4, folds = 8;
  const double x = width * (u - 0.5), y = width * (v - 0.5);
  const double length = std::hypot(x, y), angle = std::atan2(y, x);
  const double down = std::max(0.0, length - ball * pi / 2);
  const double polar = std::min(length / ball, pi / 2);
  const double radius = ball * std::sin(polar) + 0.25 * down * (1 + std::cos(folds * angle));
  return turned(
      {radius * std::cos(angle), radius * std::sin(angle), ball * std::cos(polar) - 0.9 * down});
}

// A displacement that is not rigid: up to 8 mm, over waves half a metre long.
Vec3 displaced(const Vec3& p) {
  return p + Vec3(4e-3 * std::sin(12 * p.y()), 4e-3 * std::sin(11 * p.z() + 1),
                  4e-3 * std::sin(13 * p.x() + 2) + 3e-3);
}

void sweep(Body& body) {
  body.end.clear();
  for (const Vec3& p : body.start) body.end.push_back(displaced(p));
}

std::vector<Body> linked_tori(int n) {
  Body first = make_paper_torus(n), second = first;
  // The tube of each torus passes through the hole of the other.
  const double shift = 2 * torus_major - 2 * torus_minor - 0.5 * scene_margin;
  const Eigen::Matrix3d turn(Eigen::AngleAxisd(pi / 2, Vec3::UnitX()) *
                             Eigen::AngleAxisd(0.1, Vec3::UnitZ()));
  for (Vec3& p : second.start) p = turn * p + Vec3(shift, 0, 0);
  for (Body* body : {&first, &second}) {
    for (Vec3& p : body->start) p = turned(p);
  }
  std::vector<Body> bodies;
  bodies.push_back(std::move(first));
  bodies.push_back(std::move(second));
  return bodies;
}

struct Sheet {
  const char* name;
  Vec3 (*map)(double, double);
};
constexpr std::array<Sheet, 4> sheets{{
    {"rolled", rolled},
    {"pleated", pleated},
    {"crumpled", crumpled},
    {"drape", draped},
}};

struct Cloud {
  const char* name;
  int count;
};
constexpr std::array<Cloud, 3> clouds{{
    {"particles-1k", 1'000},
    {"particles-10k", 10'000},
    {"particles-100k", 100'000},
}};

}  // namespace

Body make_paper_torus(int n) { return body_of(bsi::make_torus(torus_major, torus_minor, n, n)); }

Body make_particles(int count) {
  std::mt19937_64 random(20070901);
  const double reach = torus_major + torus_minor + 0.05, height = torus_minor + 0.05;
  // Not std::uniform_real_distribution: its numbers depend on the library.
  const auto uniform = [&] { return std::ldexp(static_cast<double>(random() >> 11), -52) - 1; };
  Body body;
  for (int i = 0; i < count; ++i) {
    const double x = uniform(), y = uniform(), z = uniform();
    body.start.emplace_back(reach * x, reach * y, height * z);
  }
  return body;
}

std::vector<std::string> scene_names() {
  std::vector<std::string> names{"tori"};
  for (const Sheet& sheet : sheets) names.emplace_back(sheet.name);
  for (std::size_t i = 0, count = names.size(); i < count; ++i)
    names.push_back(names[i] + "-swept");
  for (const Cloud& cloud : clouds) names.emplace_back(cloud.name);
  return names;
}

CollisionScene make_scene(const std::string& name, int n) {
  CollisionScene scene{name, n, scene_margin, {}};
  const bool swept = name.ends_with("-swept");
  const std::string shape = swept ? name.substr(0, name.size() - 6) : name;
  if (shape == "tori") scene.bodies = linked_tori(n);
  for (const Sheet& sheet : sheets) {
    if (shape == sheet.name) scene.bodies.push_back(make_sheet(n, sheet.map));
  }
  for (const Cloud& cloud : clouds) {
    if (name != cloud.name) continue;
    scene.bodies.push_back(make_particles(cloud.count));
    scene.bodies.push_back(make_paper_torus(n));
  }
  if (scene.bodies.empty()) throw std::invalid_argument("unknown scene " + name);
  if (swept) {
    for (Body& body : scene.bodies) sweep(body);
  }
  return scene;
}

}  // namespace weft::bench
