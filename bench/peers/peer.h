// The interface of a library that finds pairs of near triangles in any mesh, for benchmarks.
//
// This header does not use Eigen: FCL needs its own alignment of Eigen's types, so that its file
// shares none of ours.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bsi/leaf_pair.h"

namespace weft::bench {

// Triangles in indices of points, or, without triangles, the points themselves.
struct PeerBody {
  std::span<const std::array<int, 3>> triangles;
  std::size_t point_count = 0;
  const double* start = nullptr;  // x, y, z of each point, metres
  const double* end = nullptr;    // of a swept body: where its points go; else null

  bool is_particles() const { return triangles.empty(); }
  std::size_t primitive_count() const { return is_particles() ? point_count : triangles.size(); }
};

// One body against itself, or the first against the second. Particles come first.
struct PeerScene {
  std::vector<PeerBody> bodies;
  // Margin (metres) by which boxes of points rounded to float32 are widened, in float32
  // (bsi::half_margin). Pairs whose widened boxes overlap or touch are candidates.
  float half_margin = 0;
  // Margin of each particle, none larger than half_margin; empty without particles.
  std::vector<float> particle_half_margins;

  bool is_self() const { return bodies.size() == 1; }
};

using bsi::LeafPair;  // of a self query: a < b

// A hierarchy of a scene. It reads the positions of the scene afresh with every rebuild and refit.
class Peer {
 public:
  Peer() = default;
  virtual ~Peer() = default;
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  virtual bool rebuilds() const { return true; }
  virtual void rebuild() = 0;  // from nothing; where rebuilds() is false: to be called once, first
  virtual bool refits() const { return false; }
  virtual void refit() {}  // keeps the tree of the last rebuild
  // Appends the candidates, each once, in any order. Those of a self query have no common point.
  virtual void query(std::vector<LeafPair>& pairs) = 0;
  // Appends the candidates of query() as above, for libraries whose query() leaves them in a form
  // of their own.
  virtual void list(std::vector<LeafPair>&) {}
  // Counts the candidates of the last query that come within `distance` (metres) of each other, by
  // the library's own exact test; negative where it has none.
  virtual long hits(std::span<const LeafPair>, double distance) { return distance < 0 ? 0 : -1; }
};

struct PeerMaker {
  std::string name;
  std::unique_ptr<Peer> (*make)(const PeerScene&);  // null: not for this kind of scene
};

// Returns the libraries that this build found, after brute force.
std::vector<PeerMaker> available_peers();

void add_brute_force(std::vector<PeerMaker>& makers);
void add_embree(std::vector<PeerMaker>& makers);
void add_fcl(std::vector<PeerMaker>& makers);
void add_bullet(std::vector<PeerMaker>& makers);
void add_cgal(std::vector<PeerMaker>& makers);

}  // namespace weft::bench
