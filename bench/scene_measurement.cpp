#include "bench/scene_measurement.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>

#include "bench/medians.h"
#include "bench/triangle_test.h"
#include "bench/weft_method.h"

namespace weft::bench {

namespace {

// Returns a hash of a set of pairs, which does not depend on their order.
std::uint64_t fingerprint(std::span<const LeafPair> pairs) {
  std::uint64_t sum = 0;
  for (const auto& [a, b] : pairs) {
    std::uint64_t bits = (static_cast<std::uint64_t>(a) << 32) | static_cast<unsigned>(b);
    bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9ULL;
    bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebULL;
    sum += bits ^ (bits >> 31);
  }
  return sum;
}

struct Method {
  std::string name;
  MethodKind kind;
  int threads = 1;
  std::unique_ptr<Peer> peer;
  bool all_candidates = true;  // finds all that brute force does
  std::vector<double> rebuild, refit, query, narrow, weft_narrow;  // ms
  long candidates = 0, hits = 0;
  bool agrees = true;  // its own exact test agrees with Weft's
  std::uint64_t set = 0;
};

template <class Work>
double milliseconds(int threads, const Work& work) {
  return 1e3 * (threads == 1 ? thread_time_of(work) : wall_time_of(work));
}

std::vector<Method> make_methods(const CollisionScene& scene, const PeerScene& meshes,
                                 const SceneMeasurement& measurement) {
  std::vector<Method> methods;
  const auto add = [&](const std::string& name, MethodKind kind, int threads,
                       std::unique_ptr<Peer> peer) {
    const auto& wanted = measurement.methods;
    const bool skip =
        !wanted.empty() && std::find(wanted.begin(), wanted.end(), name) == wanted.end();
    if (!peer || skip) return;
    Method& method = methods.emplace_back();
    method.name = name;
    method.kind = kind;
    method.threads = threads;
    method.peer = std::move(peer);
    method.all_candidates =
        !scene.is_self() || !name.starts_with("weft") || name == "weft-uncertified";
  };
  for (const PeerMaker& maker : available_peers()) {
    const bool oracle = maker.name == "brute-force";
    add(maker.name, oracle ? MethodKind::oracle : MethodKind::peer, 1, maker.make(meshes));
  }
  for (const int threads : measurement.threads) {
    const auto add_variant = [&](const char* name, MethodKind kind, WeftVariant variant) {
      variant.threads = threads;
      add(name, kind, threads, std::make_unique<WeftMethod>(scene, variant));
    };
    add_variant("weft", MethodKind::weft, {});
    add_variant("weft-sphere", MethodKind::variant, {.bound = bsi::Bound::sphere});
    add_variant("weft-sphere-then-box", MethodKind::variant,
                {.bound = bsi::Bound::sphere_then_box});
    if (scene.bodies.front().is_particles()) continue;
    add_variant("weft-listed", MethodKind::variant, {.listed = true});
    if (!scene.is_self()) continue;
    add_variant("weft-uncertified", MethodKind::variant, {.certificate = false});
  }
  return methods;
}

void displace(CollisionScene& scene, double distance) {
  for (Body& body : scene.bodies) {
    for (auto* positions : {&body.start, &body.end}) {
      for (bsi::Vec3& p : *positions)
        p += distance * bsi::Vec3(std::sin(9 * p.y()), std::sin(7 * p.z()), std::sin(8 * p.x()));
    }
  }
}

// Builds the trees at another pose, so that refitting them has something to do.
void build_elsewhere(CollisionScene& scene, std::vector<Method>& methods) {
  const std::vector<Body> here = scene.bodies;
  displace(scene, 3e-3);
  for (Method& method : methods) method.peer->rebuild();
  for (std::size_t i = 0; i < here.size(); ++i) {
    // Positions are copied, not swapped: the peers hold pointers to these arrays.
    std::copy(here[i].start.begin(), here[i].start.end(), scene.bodies[i].start.begin());
    std::copy(here[i].end.begin(), here[i].end.end(), scene.bodies[i].end.begin());
  }
}

// Counts hits by the method's own exact test or, without one, by that of bench/triangle_test.h.
void find_own_hits(const CollisionScene& scene, Method& method,
                   const std::vector<LeafPair>& pairs) {
  const Body &first = scene.bodies.front(), &second = scene.bodies.back();
  const double own_ms =
      milliseconds(1, [&] { method.hits = method.peer->hits(pairs, scene.margin); });
  const bool has_own = method.hits >= 0;
  const double scalar_ms = has_own ? 0 : milliseconds(1, [&] {
    method.hits = count_hits({first.start, first.triangles}, {second.start, second.triangles},
                             pairs, scene.margin);
  });
  method.narrow.push_back(has_own ? own_ms : scalar_ms);
}

void find_hits(const CollisionScene& scene, Method& method, int pass,
               const std::vector<LeafPair>& pairs) {
  const bool ours = method.kind == MethodKind::weft || method.kind == MethodKind::variant;
  if (!ours && pass > 0) return;
  const double weft_ms = milliseconds(method.threads, [&] {
    method.hits = ours ? method.peer->hits(pairs, scene.margin) : weft_hits(scene, pairs, 1);
  });
  method.weft_narrow.push_back(weft_ms);
  if (ours) {
    method.narrow.push_back(weft_ms);
  } else {
    const long expected = method.hits;
    find_own_hits(scene, method, pairs);
    method.agrees = method.hits == expected;
  }
}

// Runs one pass. It refits before it rebuilds, so the first refit is of a tree at another pose.
void run_pass(const CollisionScene& scene, Method& method, int pass, std::vector<LeafPair>& pairs) {
  Peer& peer = *method.peer;
  if (peer.refits())
    method.refit.push_back(milliseconds(method.threads, [&] { peer.refit(); }));
  else if (peer.rebuilds())
    method.rebuild.push_back(milliseconds(method.threads, [&] { peer.rebuild(); }));
  pairs.clear();
  method.query.push_back(milliseconds(method.threads, [&] { peer.query(pairs); }));
  if (pairs.empty()) peer.list(pairs);
  method.candidates = static_cast<long>(pairs.size());
  method.set = fingerprint(pairs);
  if (!scene.is_swept()) find_hits(scene, method, pass, pairs);
  if (peer.refits() && peer.rebuilds())
    method.rebuild.push_back(milliseconds(method.threads, [&] { peer.rebuild(); }));
}

std::optional<double> median_of(const std::vector<double>& times) {
  if (times.empty()) return std::nullopt;
  return median(times);
}

Row row_of(const CollisionScene& scene, const Method& method) {
  Row row{scene.name, scene.n, method.name, method.kind, method.threads};
  row.rebuild_ms = median_of(method.rebuild);
  row.refit_ms = median_of(method.refit);
  row.query_ms = median_of(method.query);
  row.narrow_ms = median_of(method.narrow);
  row.weft_narrow_ms = median_of(method.weft_narrow);
  row.candidates = method.candidates;
  if (!method.narrow.empty()) row.hits = method.hits;
  return row;
}

bool check_sets(const CollisionScene& scene, const std::vector<Method>& methods) {
  const auto expected = std::find_if(methods.begin(), methods.end(),
                                     [](const Method& method) { return method.all_candidates; });
  bool right = true;
  for (const Method& method : methods) {
    const bool same_set = !method.all_candidates || method.set == expected->set;
    const bool same_hits = method.agrees && method.hits == methods.front().hits;
    if (same_set && same_hits) continue;
    right = false;
    std::fprintf(stderr, "%s, n = %d: %s finds %ld candidates and %ld hits, %s %ld and %ld\n",
                 scene.name.c_str(), scene.n, method.name.c_str(), method.candidates, method.hits,
                 expected->name.c_str(), expected->candidates, expected->hits);
  }
  return right;
}

}  // namespace

std::vector<std::string> method_names() {
  std::vector<std::string> names{"weft", "weft-sphere", "weft-sphere-then-box", "weft-listed",
                                 "weft-uncertified"};
  for (const PeerMaker& maker : available_peers()) names.push_back(maker.name);
  return names;
}

bool measure_scene(CollisionScene scene, const SceneMeasurement& measurement,
                   std::vector<Row>& rows) {
  const PeerScene meshes = mesh_view(scene);
  std::vector<Method> methods = make_methods(scene, meshes, measurement);
  if (methods.empty()) return true;
  build_elsewhere(scene, methods);
  std::vector<LeafPair> pairs;
  bool right = true;
  for (int pass = 0; pass < measurement.repeats; ++pass) {
    for (Method& method : methods) {
      if (pass == 0 || method.kind != MethodKind::oracle) run_pass(scene, method, pass, pairs);
    }
    right = check_sets(scene, methods) && right;
  }
  for (const Method& method : methods) rows.push_back(row_of(scene, method));
  return right;
}

}  // namespace weft::bench
