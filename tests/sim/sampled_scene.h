// Scenes whose surfaces are sampled: made-up maps from particles to surface points, for tests.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "sim/scene/surface_points.h"
#include "simulated_case.h"

namespace weft::sim {

// Returns the twofold refinement of a body's image. New points lie between neighbouring particles,
// at the average of two, and in the middle of quads, at the average of four. Points along seams are
// sewn as the particles are.
inline SampledSurface refined_surface(const SceneBody& body) {
  std::vector<bsi::Patch> patches;
  std::vector<int> point_of_texel, first_share{0};
  std::vector<SurfaceMap::Share> shares;
  std::map<std::vector<int>, int> point_of;  // by its particles
  for (std::size_t p = 0; p < body.atlas.patches().size(); ++p) {
    bsi::Patch patch = body.atlas.patches()[p];
    patch.rows += patch.quad_rows();
    patch.cols += patch.quad_cols();
    patches.push_back(patch);
    for (int row = 0; row < patch.rows; ++row) {
      for (int col = 0; col < patch.cols; ++col) {
        std::vector<int> around;
        for (const int r : {row / 2, (row + 1) / 2}) {
          for (const int c : {col / 2, (col + 1) / 2})
            around.push_back(body.atlas.particle(static_cast<int>(p), r, c));
        }
        std::sort(around.begin(), around.end());
        around.erase(std::unique(around.begin(), around.end()), around.end());
        const auto [found, is_new] = point_of.try_emplace(around, std::ssize(point_of));
        point_of_texel.push_back(found->second);
        if (!is_new) continue;
        for (const int particle : around)
          shares.push_back({particle, 1.0 / static_cast<double>(around.size())});
        first_share.push_back(static_cast<int>(shares.size()));
      }
    }
  }
  return {bsi::Atlas(patches, point_of_texel), SurfaceMap(first_share, shares), body.rest};
}

// Returns the body's own image by an explicit map: each point has one particle.
inline SampledSurface own_surface(const SceneBody& body) {
  std::vector<int> first_share{0};
  std::vector<SurfaceMap::Share> shares;
  for (int i = 0; i < body.particle_count(); ++i) {
    shares.push_back({i, 1.0});
    first_share.push_back(i + 1);
  }
  return {body.atlas, SurfaceMap(first_share, shares), body.rest};
}

// A scene with its case.
class SampledScene {
 public:
  // Bodies that `pick` accepts get the surface that `sample` makes of them; others keep their own.
  template <class Sample>
  SampledScene(
      const std::string& text, const Overrides& overrides, const Sample& sample,
      bool (*pick)(const SceneBody&) = [](const SceneBody&) { return true; })
      : built_(build_scene(parse_case(text, "test.toml", overrides))), scene_(*built_) {
    for (SceneBody& body : scene_.bodies) {
      if (pick(body)) body.sampled.emplace(sample(body));
    }
    number_surface_points(scene_);
  }

  const Scene& plain() const { return *built_; }
  const Scene& scene() const { return scene_; }

  // Returns the scene whose particles are the surface points of this one: what contact should see.
  Scene points_as_particles() const {
    Scene points = scene_;
    points.pinned.clear();
    points.initial_position = on_points(scene_.initial_position);
    for (SceneBody& body : points.bodies) {
      body.first_particle = body.first_point;
      if (!body.sampled) continue;
      body.atlas = body.sampled->atlas;
      body.mesh = body.sampled->mesh;
      body.rest = body.sampled->rest;
      body.sampled.reset();
    }
    points.dynamic_particles = scene_.dynamic_points;
    points.particle_count = scene_.point_count;
    for (int i = 0; i < scene_.dynamic_points; ++i) {
      const auto shares = scene_.surface_map.shares(i);
      points.pinned.push_back(static_cast<char>(std::ranges::all_of(
          shares, [&](const auto& share) { return scene_.pinned[share.particle] != 0; })));
    }
    points.mass.assign(scene_.dynamic_points, 1.0);
    number_surface_points(points);
    return points;
  }

  // Return S x and S^T f, from the definition.
  std::vector<Vec3> on_points(const std::vector<Vec3>& particles) const {
    std::vector<Vec3> points(scene_.point_count, Vec3::Zero());
    for (int i = 0; i < scene_.point_count; ++i) {
      for (const auto& [particle, weight] : scene_.surface_map.shares(i))
        points[i] += weight * particles[particle];
    }
    return points;
  }
  std::vector<Vec3> on_particles(const std::vector<Vec3>& points) const {
    std::vector<Vec3> particles(scene_.particle_count, Vec3::Zero());
    for (std::size_t i = 0; i < points.size(); ++i) {
      for (const auto& [particle, weight] : scene_.surface_map.shares(static_cast<int>(i)))
        particles[particle] += weight * points[i];
    }
    return particles;
  }

 private:
  std::unique_ptr<const Scene> built_;  // its case has the materials
  Scene scene_;
};

}  // namespace weft::sim
