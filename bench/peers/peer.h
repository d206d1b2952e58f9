// The interface of a library that finds pairs of near triangles in any mesh, for benchmarks.
//
// This header does not use Eigen: FCL needs another alignment of Eigen's types, so its file shares
// none of Weft's.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bsi/leaf_pair.h"

namespace weft::bench {

// Triangles as indices of points, or, without triangles, the points themselves.
struct PeerBody {
  std::span<const std::array<int, 3>> triangles;
  std::size_t point_count = 0;
  const double* start = nullptr;  // x, y, z of each point, metres
  const double* end = nullptr;    // end positions of a swept body; else null

  bool is_particles() const { return triangles.empty(); }
  std::size_t primitive_count() const { return is_particles() ? point_count : triangles.size(); }
};

// A query of one body against itself, or of the first against the second. Particles come first.
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

// A hierarchy of a scene. Every rebuild and refit reads the positions of the scene anew.
class Peer {
 public:
  Peer() = default;
  virtual ~Peer() = default;
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  virtual bool rebuilds() const { return true; }
  virtual void rebuild() = 0;  // builds a new tree; if rebuilds() is false, call it once, first
  virtual bool refits() const { return false; }
  virtual void refit() {}  // keeps the tree of the last rebuild and updates its boxes
  // Appends the candidates, each once, in any order. Those of a self query share no point.
  virtual void query(std::vector<LeafPair>& pairs) = 0;
  // Appends the candidates of the last query(), for libraries whose query() stores them in their
  // own form.
  virtual void list(std::vector<LeafPair>&) {}
  // Counts the candidates of the last query that come within `distance` (m) of each other, by the
  // library's own exact test; negative if it has none.
  virtual long hits(std::span<const LeafPair>, double distance) { return distance < 0 ? 0 : -1; }
};

struct PeerMaker {
  std::string name;
  std::unique_ptr<Peer> (*make)(const PeerScene&);  // returns null for scenes it cannot handle
};

// Returns the libraries that this build found, after brute force.
std::vector<PeerMaker> available_peers();

void add_brute_force(std::vector<PeerMaker>& makers);
void add_embree(std::vector<PeerMaker>& makers);
void add_fcl(std::vector<PeerMaker>& makers);
void add_bullet(std::vector<PeerMaker>& makers);
void add_cgal(std::vector<PeerMaker>& makers);

}  // namespace weft::bench
