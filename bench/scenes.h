// The scenes of the collision benchmarks.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bsi/shapes.h"

namespace weft::bench {

// A geometry image with its triangles, for methods that need a mesh; or, without an atlas,
// particles.
struct Body {
  bsi::Atlas atlas;
  std::vector<std::array<int, 3>> triangles;
  std::vector<bsi::Vec3> start;  // metres
  std::vector<bsi::Vec3> end;    // end positions of a swept body; else empty

  bool is_particles() const { return triangles.empty(); }
  bool is_swept() const { return !end.empty(); }
};

// A query of one body against itself, or of the first against the second. Particles come first.
struct CollisionScene {
  std::string name;
  int n = 0;  // images of n x n vertices
  double margin = 0;
  std::vector<Body> bodies;

  bool is_self() const { return bodies.size() == 1; }
  bool is_swept() const { return bodies.front().is_swept(); }
};

constexpr double scene_margin = 2e-3;  // m

// The names of all scenes.
// tori: two tori of n x n vertices, linked like a chain, half a margin apart.
// Sheets of n x n vertices, 2 m wide:
//   rolled: a spiral with layers 0.8 to 1.2 margins apart;
//   pleated: 20 pleats, each at that distance from the next but one;
//   crumpled: pleats of many widths and distances, bent by waves in all directions;
//   drape: hung over a ball in folds, nowhere near itself.
// NAME-swept: the same, with every vertex moving along a straight line, some millimetres long.
// particles-1k, -10k, -100k: uniform in a box about a torus of n x n vertices.
std::vector<std::string> scene_names();

// Makes a scene, always the same one. Throws std::invalid_argument for an unknown name.
CollisionScene make_scene(const std::string& name, int n);

// The torus of the paper's experiments, around the z axis, n x n vertices.
constexpr double torus_major = 0.5, torus_minor = 0.2;  // radii, m
Body make_paper_torus(int n);
// Particles uniform in the box of that torus widened by 5 cm, with a fixed seed.
Body make_particles(int count);

}  // namespace weft::bench
