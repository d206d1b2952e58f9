// What a benchmark asks of a library that finds pairs of near triangles in any mesh.
//
// No Eigen here: FCL needs its own alignment of Eigen's types, so that its file shares none of
// ours.
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
  // By which boxes of points rounded to float32 are widened, in float32 (bsi::half_margin), metres:
  // pairs whose widened boxes overlap or touch are candidates.
  float half_margin = 0;
  // For particles, each its own; none larger than half_margin. Else empty.
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
  // Appends the candidates, those of a self query without a common point, each once, in any order.
  virtual void query(std::vector<LeafPair>& pairs) = 0;
  // For those who leave the candidates of query() in a form of their own: appends them as above.
  virtual void list(std::vector<LeafPair>&) {}
  // Its own exact test of the candidates of the last query: how many pairs of triangles come within
  // `distance` (metres) of each other; negative where it has none.
  virtual long hits(std::span<const LeafPair>, double distance) { return distance < 0 ? 0 : -1; }
};

struct PeerMaker {
  std::string name;
  std::unique_ptr<Peer> (*make)(const PeerScene&);  // null: not for this kind of scene
};

// Those of the libraries that this build found, and brute force first of all.
std::vector<PeerMaker> available_peers();

void add_brute_force(std::vector<PeerMaker>& makers);
void add_embree(std::vector<PeerMaker>& makers);
void add_fcl(std::vector<PeerMaker>& makers);
void add_bullet(std::vector<PeerMaker>& makers);
void add_cgal(std::vector<PeerMaker>& makers);

}  // namespace weft::bench
