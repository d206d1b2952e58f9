#include "sim/scene/sphere_groups.h"

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <numbers>
#include <random>
#include <unordered_map>

#include "sim/base/file_error.h"
#include "sim/case/case_error.h"
#include "sim/case/case_text.h"
#include "sim/case/memory_estimate.h"
#include "sim/scene/texel_file.h"

namespace weft::sim {

namespace {

// Random numbers in [0, 1) that are the same on every machine, unlike those of
// std::uniform_real_distribution.
class RandomNumbers {
 public:
  explicit RandomNumbers(int seed) : engine_(static_cast<std::uint64_t>(seed)) {}
  double next() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  // Returns a point of the unit cube.
  Vec3 next_point() {
    const double x = next(), y = next(), z = next();
    return {x, y, z};
  }

 private:
  std::mt19937_64 engine_;
};

// Largest distance of a place from the origin, in radii and in m. Rounding moves a place beyond by
// more than a thousandth of the radius. Other bodies may be as far away (body_motion.cpp).
constexpr double farthest_place = 1e12, lost_place = 1e15;

// Masses (kg) whose products with other numbers of a case are finite numbers.
constexpr double least_mass = 1e-100, largest_mass = 1e100;

// Throws CaseError unless double precision tells the place of a particle to a small part of its
// radius.
void require_near(const ParticlesCase& from, const Vec3& place) {
  const double by_radius = farthest_place * from.radius;
  const double farthest = std::min(by_radius, lost_place);
  if (place.cwiseAbs().maxCoeff() <= farthest) return;
  throw CaseError(
      from.positions.location,
      "particles " + in_quotes(from.name) + " are " + rounded_text(place.cwiseAbs().maxCoeff()) +
          " m from the origin",
      "expected at most " + rounded_text(farthest) + " m" +
          (by_radius <= lost_place ? ": rounding moves farther ones by a part of their radius"
                                   : ""));
}

std::vector<Vec3> grid_places(const ParticlesCase& from) {
  const PositionsCase& places = from.positions;
  constexpr double usual_spacing = 2.2;  // in radii
  const double spacing = places.spacing.value_or(usual_spacing * from.radius);
  RandomNumbers random(places.seed);
  std::vector<Vec3> result;
  for (int k = 0; k < places.count[2]; ++k) {
    for (int j = 0; j < places.count[1]; ++j) {
      for (int i = 0; i < places.count[0]; ++i) {
        const Vec3 cell(i - 0.5 * (places.count[0] - 1), j - 0.5 * (places.count[1] - 1),
                        k - 0.5 * (places.count[2] - 1));
        result.push_back(places.centre + spacing * cell);
        if (places.jitter > 0)
          result.back() += places.jitter * (2 * random.next_point() - Vec3::Ones());
      }
    }
  }
  return result;
}

// Spheres of one radius that do not overlap, in cells that are as wide as a sphere.
class PackedSpheres {
 public:
  explicit PackedSpheres(double radius) : width_(2 * radius) {}

  // Adds a sphere unless it overlaps another one. Returns true if it has been added.
  bool add(const Vec3& centre) {
    const Cell cell = cell_of(centre);
    for (std::int64_t i = -1; i <= 1; ++i) {
      for (std::int64_t j = -1; j <= 1; ++j) {
        for (std::int64_t k = -1; k <= 1; ++k) {
          const auto found = cells_.find(key({cell[0] + i, cell[1] + j, cell[2] + k}));
          if (found == cells_.end()) continue;
          for (const Vec3& other : found->second) {
            if ((other - centre).squaredNorm() < width_ * width_) return false;
          }
        }
      }
    }
    cells_[key(cell)].push_back(centre);
    return true;
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  Cell cell_of(const Vec3& at) const {
    const auto along = [&](int k) { return static_cast<std::int64_t>(std::floor(at[k] / width_)); };
    return {along(0), along(1), along(2)};
  }
  // Different cells may have the same key: the search then only compares more spheres.
  static std::uint64_t key(const Cell& cell) {
    std::uint64_t result = 0;
    for (const std::int64_t each : cell)
      result = (result ^ static_cast<std::uint64_t>(each)) * 0x9e3779b97f4a7c15;
    return result;
  }

  double width_;
  std::unordered_map<std::uint64_t, std::vector<Vec3>> cells_;
};

std::vector<Vec3> random_places(const ParticlesCase& from) {
  constexpr int most_trials = 2000;  // for one particle
  const PositionsCase& places = from.positions;
  for (const Vec3& corner : {places.region_min, places.region_max}) require_near(from, corner);
  const Vec3 size = places.region_max - places.region_min;
  RandomNumbers random(places.seed);
  PackedSpheres packed(from.radius);
  std::vector<Vec3> result;
  for (int trial = 0; static_cast<int>(result.size()) < places.number;) {
    const Vec3 centre = places.region_min + random.next_point().cwiseProduct(size);
    if (packed.add(centre)) {
      result.push_back(centre);
      trial = 0;
    } else if (++trial == most_trials) {
      throw CaseError(places.location,
                      "found room for " + std::to_string(result.size()) + " of " +
                          std::to_string(places.number) + " particles " + in_quotes(from.name),
                      "expected a larger region, or fewer or smaller particles");
    }
  }
  return result;
}

std::vector<Vec3> file_places(const ParticlesCase& from, const Case& source) {
  const PositionsCase& places = from.positions;
  const auto path = std::filesystem::path(source.path).parent_path() / places.path;
  std::vector<Vec3> result;
  try {
    result = read_points(path.string(), places.dataset, memory_limit(source)).texels;
  } catch (const FileError& error) {
    throw CaseError(places.location, error.what());
  }
  for (std::size_t i = 0; i < result.size(); ++i) {
    if (result[i].allFinite()) continue;
    throw CaseError(places.location,
                    path.string() + ": dataset " + places.dataset + ": point " + std::to_string(i) +
                        " is not finite",
                    "expected numbers");
  }
  return result;
}

std::vector<Vec3> places_of(const ParticlesCase& from, const Case& source) {
  switch (from.positions.type) {
    case PositionsType::random:
      return random_places(from);
    case PositionsType::file:
      return file_places(from, source);
    default:
      return grid_places(from);
  }
}

// The material of spheres, which have no forces of surfaces.
const MaterialCase& no_material() {
  static const MaterialCase material = [] {
    MaterialCase result;
    result.membrane_stiffness = 0;
    return result;
  }();
  return material;
}

// Appends a body with one particle of the given mass (kg) at each place (m).
SceneBody& add_points(Scene& scene, const ParticlesCase& from, const std::vector<Vec3>& places,
                      double mass) {
  const int count = static_cast<int>(places.size());
  SceneBody body;
  body.name = from.name;
  body.atlas = bsi::Atlas::of_points(count);
  body.rest = places;
  body.first_particle = scene.particle_count;
  body.material = &no_material();
  body.spheres = &from;
  Vec3 sum = Vec3::Zero();
  for (const Vec3& place : places) sum += place;
  body.centre = sum / count;
  scene.mass.insert(scene.mass.end(), places.size(), mass);
  scene.pinned.resize(scene.mass.size(), 0);
  scene.initial_position.insert(scene.initial_position.end(), places.begin(), places.end());
  scene.particle_count += count;
  return scene.bodies.emplace_back(std::move(body));
}

double mass_of_sphere(const ParticlesCase& from) {
  return from.density * 4 / 3 * std::numbers::pi * std::pow(from.radius, 3);
}

void add_group(Scene& scene, const ParticlesCase& from) {
  const double mass = mass_of_sphere(from);
  if (!(mass >= least_mass && mass <= largest_mass)) {
    throw CaseError(
        from.location,
        "particles " + in_quotes(from.name) + " have a mass of " + rounded_text(mass) + " kg each",
        "expected a radius and a density of masses from " + rounded_text(least_mass) + " to " +
            rounded_text(largest_mass) + " kg");
  }
  const std::vector<Vec3> places = places_of(from, scene.source);
  for (const Vec3& place : places) require_near(from, place);
  SceneBody& body = add_points(scene, from, places, mass);
  body.velocity = from.velocity;
  body.thickness = 2 * from.radius;
  body.self_contact = scene.source.contact.enabled;
}

// `spheres` is the body of the group.
void add_spins(Scene& scene, const ParticlesCase& from, const SceneBody& spheres) {
  const std::vector<Vec3> places = spheres.rest;
  SceneBody& body = add_points(scene, from, places, spin_mass_share * mass_of_sphere(from));
  body.name += " (spin)";  // particles of a case have no spaces in their names
  body.are_spins = true;
  body.velocity = from.radius * (std::numbers::pi / 180) * from.angular_velocity_deg;
}

}  // namespace

void add_sphere_groups(Scene& scene) {
  const std::vector<ParticlesCase>& groups = scene.source.particles;
  const std::size_t first = scene.bodies.size();
  for (const ParticlesCase& group : groups) add_group(scene, group);
  if (scene.source.time.method == TimeMethod::impulses) return;
  for (std::size_t i = 0; i < groups.size(); ++i)
    if (scene.source.can_turn(groups[i])) add_spins(scene, groups[i], scene.bodies[first + i]);
}

std::vector<double> sphere_radii(const Scene& scene) {
  std::vector<double> radii;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const SceneBody& body = scene.bodies[b];
    radii.insert(radii.end(), body.particle_count(), body.spheres->radius);
  }
  return radii;
}

}  // namespace weft::sim
