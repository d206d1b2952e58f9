// Weft as one more method beside its peers.
#pragma once

#include <span>

#include "bench/peers/peer.h"
#include "bench/scenes.h"

namespace weft::bench {

// Returns a scene as meshes, for methods that take meshes, with the definition of its candidates.
// They are views of `scene`, which must stay where it is.
PeerScene mesh_view(const CollisionScene& scene);

struct WeftVariant {
  // Without it Weft finds the same pairs as its peers. With it (self queries only) Weft leaves out
  // pairs that cannot be hits.
  bool certificate = true;
  // query() lists the candidates pair by pair, as peers do, and not by pairs of leaf blocks.
  bool listed = false;
  // The bounds that the traversals compare. The rebuild makes spheres unless it is `box`.
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

// Returns how many of the candidates of any method come within the margin of the scene, by Weft's
// narrow phase for lists of pairs.
long weft_hits(const CollisionScene& scene, std::span<const LeafPair> pairs, int threads);

}  // namespace weft::bench
