#include "sim/view/rendered_spheres.h"

#include <algorithm>
#include <cstddef>

#include "bsi/shapes.h"
#include "bsi/traversal.h"

namespace weft::sim {
namespace {

// A mark for each block of a level, patch by patch and row by row.
using Marks = std::vector<char>;

int level_of(const bsi::Pyramid& pyramid, int patch, int level) {
  return std::min(level, pyramid.levels(patch) - 1);
}

// Calls visit(block, number) for every block of the level. The numbers are the indices of Marks.
template <class Visit>
void for_each_block(const bsi::Pyramid& pyramid, int level, const Visit& visit) {
  std::size_t number = 0;
  for (int patch = 0; patch < pyramid.patch_count(); ++patch) {
    const int at = level_of(pyramid, patch, level);
    for (int v = 0; v < pyramid.blocks_v(patch, at); ++v) {
      for (int u = 0; u < pyramid.blocks_u(patch, at); ++u) {
        visit(bsi::PatchBlock{patch, at, u, v}, number++);
      }
    }
  }
}

std::vector<std::size_t> first_numbers(const bsi::Pyramid& pyramid, int level) {
  std::vector<std::size_t> first{0};
  for (int patch = 0; patch < pyramid.patch_count(); ++patch) {
    const int at = level_of(pyramid, patch, level);
    first.push_back(first.back() + static_cast<std::size_t>(pyramid.blocks_u(patch, at)) *
                                       pyramid.blocks_v(patch, at));
  }
  return first;
}

void mark(const bsi::Pyramid& pyramid, const bsi::PatchBlock& block,
          const std::vector<std::size_t>& first, Marks& marks) {
  const auto row = static_cast<std::size_t>(pyramid.blocks_u(block.patch, block.level));
  marks[first[block.patch] + block.v * row + block.u] = 1;
}

double largest_radius(const bsi::Pyramid& pyramid, int level) {
  float largest = 0;
  for_each_block(pyramid, level, [&](const bsi::PatchBlock& block, std::size_t) {
    largest = std::max(largest, pyramid.sphere(block).radius);
  });
  return largest;
}

// In each pyramid, marks the blocks whose spheres touch a sphere of the other pyramid.
void mark_touching(const bsi::Pyramid& a, const bsi::Pyramid& b, int level, Marks& marks_a,
                   Marks& marks_b) {
  const std::vector<std::size_t> first_a = first_numbers(a, level);
  const std::vector<std::size_t> first_b = first_numbers(b, level);
  std::vector<bsi::BlockPair> pairs;
  bsi::TraversalCounters counters;
  // The centre of a sphere lies in the box of its block. If two spheres meet, the distance between
  // their boxes is therefore at most this sum of radii.
  const double margin = largest_radius(a, level) + largest_radius(b, level);
  bsi::dual_traversal_of_blocks(a, b, level, {.margin = margin}, pairs, counters);
  for (const bsi::BlockPair& pair : pairs) {
    if (bsi::bounding_sphere_gap(a.sphere(pair.a), b.sphere(pair.b)) > 0) continue;
    mark(a, pair.a, first_a, marks_a);
    mark(b, pair.b, first_b, marks_b);
  }
}

// A triangulated unit sphere, as a pattern for `count` spheres. It is finer if `count` is small.
class Ball {
 public:
  explicit Ball(std::size_t count)
      : surface_(bsi::make_sphere(1, count > 4000  ? 3
                                     : count > 200 ? 5
                                                   : 12)),
        triangles_(bsi::build_mesh(surface_.atlas).triangles) {}

  void append(const bsi::Sphere& sphere, SphereSurface& to) const {
    append(Vec3(sphere.x, sphere.y, sphere.z), sphere.radius, to);
  }
  void append(const Vec3& centre, double radius, SphereSurface& to) const {
    const auto first = static_cast<int>(to.positions.size());
    for (const Vec3& direction : surface_.positions) {
      to.positions.push_back(centre + radius * direction);
      to.normals.push_back(direction);
    }
    for (const auto& [a, b, c] : triangles_)
      to.triangles.push_back({first + a, first + b, first + c});
  }

 private:
  bsi::Surface surface_;
  std::vector<std::array<int, 3>> triangles_;
};

}  // namespace

void surround_bodies(int level, std::vector<RenderedBody>& bodies) {
  std::vector<Marks> touching;
  std::size_t count = 0;
  for (const RenderedBody& body : bodies) {
    touching.emplace_back(body.pyramid ? first_numbers(*body.pyramid, level).back() : 0, 0);
    count += touching.back().size();
  }
  for (std::size_t a = 0; a < bodies.size(); ++a) {
    for (std::size_t b = a + 1; b < bodies.size(); ++b) {
      if (!bodies[a].pyramid || !bodies[b].pyramid) continue;
      mark_touching(*bodies[a].pyramid, *bodies[b].pyramid, level, touching[a], touching[b]);
    }
  }
  const Ball ball(count);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    RenderedBody& body = bodies[i];
    if (!body.pyramid) continue;
    body.spheres = {};
    body.touching_spheres = {};
    for_each_block(*body.pyramid, level, [&](const bsi::PatchBlock& block, std::size_t number) {
      ball.append(body.pyramid->sphere(block),
                  touching[i][number] != 0 ? body.touching_spheres : body.spheres);
    });
  }
}

SphereSurface surface_of_spheres(std::span<const Vec3> centres, std::span<const double> radii) {
  const Ball ball(radii.size());
  SphereSurface surface;
  for (std::size_t i = 0; i < radii.size(); ++i) ball.append(centres[i], radii[i], surface);
  return surface;
}

void draw_particles(RenderedBody& body) {
  body.spheres = surface_of_spheres(body.positions, body.radii);
  body.sphere_places.clear();
  if (body.places.empty()) return;
  const std::size_t points = body.spheres.positions.size() / body.radii.size();
  for (std::size_t i = 0; i < body.radii.size(); ++i)
    body.sphere_places.resize((i + 1) * points, body.places[i]);
}

std::vector<bsi::Sphere> spheres_of_level(const bsi::Pyramid& pyramid, int level) {
  std::vector<bsi::Sphere> spheres;
  for_each_block(pyramid, level, [&](const bsi::PatchBlock& block, std::size_t) {
    spheres.push_back(pyramid.sphere(block));
  });
  return spheres;
}

}  // namespace weft::sim
