// Weft as one more method beside its peers.
#pragma once

#include <span>

#include "bench/peers/peer.h"
#include "bench/scenes.h"

namespace weft::bench {

// A scene as meshes, for those who take meshes, with the definition of its candidates. Views of
// `scene`, which must stay where it is.
PeerScene mesh_view(const CollisionScene& scene);

// Box pyramids and their traversals. Without the certificate it finds what its peers find; with it
// (self queries only), less: what it leaves out cannot be a hit. Bytes of the hierarchy in `bytes`.
class WeftMethod final : public Peer {
 public:
  WeftMethod(const CollisionScene& scene, bool certificate, int threads);
  ~WeftMethod() override;
  void rebuild() override;
  void query(std::vector<LeafPair>& pairs) override;
  std::size_t bytes() const;

 private:
  struct Pyramids;
  const CollisionScene& scene_;
  bool certificate_;
  int threads_;
  std::unique_ptr<Pyramids> pyramids_;
};

// How many of the candidates come within the margin of the scene: Weft's narrow phase.
long weft_hits(const CollisionScene& scene, std::span<const LeafPair> pairs, int threads);

}  // namespace weft::bench
