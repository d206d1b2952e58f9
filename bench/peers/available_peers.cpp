#include "bench/peers/peer.h"

namespace weft::bench {

std::vector<PeerMaker> available_peers() {
  std::vector<PeerMaker> makers;
  add_brute_force(makers);
#ifdef WEFT_BENCH_EMBREE
  add_embree(makers);
#endif
#ifdef WEFT_BENCH_FCL
  add_fcl(makers);
#endif
#ifdef WEFT_BENCH_BULLET
  add_bullet(makers);
#endif
#ifdef WEFT_BENCH_CGAL
  add_cgal(makers);
#endif
  return makers;
}

}  // namespace weft::bench
