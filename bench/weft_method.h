// Weft as one of the methods that are compared.
#pragma once

#include <span>

#include "bench/peers/peer.h"
#include "bench/scenes.h"

namespace weft::bench {

// Returns a scene as meshes, for methods that take meshes, with the definition of its candidates.
// The meshes are views of `scene`, which must not move.
PeerScene mesh_view(const CollisionScene& scene);

struct WeftVariant {
  // Leaves out pairs that cannot be hits (self queries only). Without it Weft finds the same pairs
  // as its peers.
  bool certificate = true;
  // Makes query() list candidates pair by pair, as peers do, instead of by pairs of leaf blocks.
  bool listed = false;
  // The bounds that the traversals compare. Unless they are `box`, the rebuild makes spheres too.
  bsi::Bound bound = bsi::Bound::box;
  int threads = 1;
};

// Box pyramids, their traversals, and the narrow phase.
class WeftMethod final : public Peer {
 public:
  WeftMethod(const CollisionScene& scene, const WeftVariant& variant);
  ~WeftMethod() override;
  void rebuild() override;
  void query(std::vector<LeafPair>& pairs) override;
  void list(std::vector<LeafPair>& pairs) override;
  long hits(std::span<const LeafPair> pairs, double distance) override;
  std::size_t bytes() const;  // of the hierarchy

 private:
  struct Pyramids;
  const CollisionScene& scene_;
  WeftVariant variant_;
  std::unique_ptr<Pyramids> pyramids_;
};

// Returns the number of candidates, of any method, within the margin of the scene, by Weft's narrow
// phase for lists of pairs.
long weft_hits(const CollisionScene& scene, std::span<const LeafPair> pairs, int threads);

}  // namespace weft::bench
