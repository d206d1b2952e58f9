#include "bsi/traversal.h"

#include <omp.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <memory>

#include "bsi/detail/aligned_vector.h"
#include "bsi/detail/rounded_up.h"
#include "bsi/kernels/point_descent_kernels.h"

namespace weft::bsi {

std::size_t count_pairs(std::span<const LeafBlockPair> blocks) {
  std::size_t count = 0;
  for (const LeafBlockPair& pair : blocks) count += std::popcount(pair.leaves);
  return count;
}

namespace {

// Returns the margin (m), but at most four times the coordinate limit. A larger margin would not
// change the result and could overflow.
double largest_margin_that_counts(double margin) {
  return std::min(margin, 4.0 * static_cast<double>(Pyramid::coordinate_limit));
}

std::uint64_t next_serial() {
  static std::atomic<std::uint64_t> last = 0;
  return ++last;
}

// Makes the query of a traversal. `second` is the tree of a second pyramid, or a tree placed in
// space. Precondition: both trees have the spheres that options.bound needs.
DescentQuery query_of(const Pyramid& first, const BoxTree& second, bool self,
                      const TraversalOptions& options) {
  assert(first.is_built());
  assert(options.margin >= 0 && std::isfinite(options.margin));
  assert(options.bound == Bound::box || first.parts().spheres);
  DescentQuery query{};
  query.a = &first.tree();
  query.b = &second;
  query.half_margin = half_margin(options.margin, first.magnitude(), second.magnitude);
  query.sphere_reach = sphere_reach(query.half_margin, first.magnitude(), second.magnitude);
  query.bound = options.bound;
  query.self = self;
  query.serial = next_serial();
  query.triangles = options.leaf == Leaf::triangle;
  query.certificate_margin =
      self && options.certificate ? certificate_margin(options.margin, first.magnitude()) : -1.0;
  return query;
}

DescentQuery query_of(const Pyramid& first, const Pyramid& second, bool self,
                      const TraversalOptions& options) {
  assert(second.is_built());
  assert(options.bound == Bound::box || second.parts().spheres);
  return query_of(first, second.tree(), self, options);
}

bool overlap(const Box& a, const Box& b, float half) {
  for (int axis = 0; axis < 3; ++axis) {
    if (a.low[axis] - half > b.high[axis] + half || b.low[axis] - half > a.high[axis] + half) {
      return false;
    }
  }
  return true;
}

// Finds the pairs of patches from which descents start. It descends the groups above the patches.
class PatchPairs {
 public:
  PatchPairs(const Pyramid& first, const Pyramid& second, const DescentQuery& query)
      : first_(first), second_(second), query_(query) {}

  std::vector<NodePair> find() {
    follow({0, 0, first_.group_levels()}, {0, 0, second_.group_levels()});
    return std::move(found_);
  }

 private:
  // A node of the tree of groups: group `u` of a level or, if level == levels, patch `u`.
  struct Node {
    int level, u, levels;
    bool is_patch() const { return level == levels; }
    bool operator==(const Node&) const = default;
  };

  static Box box_of(const Pyramid& pyramid, const Node& node) {
    return node.is_patch() ? pyramid.box(node.u, 0, 0, 0) : pyramid.group_box(node.level, node.u);
  }

  static std::vector<Node> children_of(const Pyramid& pyramid, const Node& node) {
    if (node.is_patch()) return {node};
    if (node.level + 1 < node.levels) {
      return {{node.level + 1, 2 * node.u, node.levels},
              {node.level + 1, 2 * node.u + 1, node.levels}};
    }
    std::vector<Node> children;
    for (const int patch : pyramid.patches_of_group(node.level, node.u))
      children.push_back({node.levels, patch, node.levels});
    return children;
  }

  void follow(const Node& a, const Node& b) {
    Box box_b = box_of(second_, b);
    if (query_.b->placement != nullptr) box_b = placed_box(*query_.b, box_b);
    if (!overlap(box_of(first_, a), box_b, query_.half_margin)) return;
    if (a.is_patch() && b.is_patch()) {
      // Within one body, the lower patch comes first in a pair, although groups hold patches in any
      // order.
      const bool is_turned = query_.self && a.u > b.u;
      found_.push_back({{first_.tree().patches[is_turned ? b.u : a.u].first_level, 0, 0},
                        {second_.tree().patches[is_turned ? a.u : b.u].first_level, 0, 0}});
      return;
    }
    const bool itself = query_.self && a == b;
    const std::vector<Node> of_a = children_of(first_, a);
    const std::vector<Node> of_b = children_of(second_, b);
    for (std::size_t i = 0; i < of_a.size(); ++i) {
      for (std::size_t j = itself ? i : 0; j < of_b.size(); ++j) follow(of_a[i], of_b[j]);
    }
  }

  const Pyramid& first_;
  const Pyramid& second_;
  const DescentQuery& query_;
  std::vector<NodePair> found_;
};

void add(TraversalCounters& total, const DescentCounters& part) {
  total.bound_tests += part.bound_tests;
  total.certificate_tests += part.certificate_tests;
  total.certified += part.certified;
}

// Replaces each pair of blocks by the pairs of their children whose bounds overlap. Pairs of two
// leaf blocks, and pairs that `keep` selects, stay. Pairs that the certificate excludes are
// removed. Returns false if all pairs stay.
template <class Keep>
bool expand_all(const DescentQuery& query, std::vector<NodePair>& pairs, DescentCounters& counters,
                const Keep& keep) {
  const DescentKernels& kernels = descent_kernels();
  std::vector<NodePair> next;
  bool expanded = false;
  for (const NodePair& pair : pairs) {
    std::array<NodePair, largest_expansion> children;
    const int count = keep(pair) ? -1 : kernels.expand(query, pair, children.data(), counters);
    if (count < 0) {
      next.push_back(pair);
    } else {
      next.insert(next.end(), children.begin(), children.begin() + count);
      expanded = true;
    }
  }
  pairs = std::move(next);
  return expanded;
}

// Returns the pairs of blocks from which descents start: at least 256 if possible, to be shared
// among threads. They do not depend on the number of threads.
std::vector<NodePair> frontier(const Pyramid& first, const Pyramid& second,
                               const DescentQuery& query, DescentCounters& counters) {
  constexpr std::size_t enough = 256;
  std::vector<NodePair> pairs = PatchPairs(first, second, query).find();
  while (!pairs.empty() && pairs.size() < enough) {
    if (!expand_all(query, pairs, counters, [](const NodePair&) { return false; })) break;
  }
  return pairs;
}

// Appends the results of descents to a vector. `Sink` is BlockSink or PairSink, and `Found` is the
// type of the results.
template <class Sink, class Found>
class Collector {
 public:
  explicit Collector(std::vector<Found>& found) : found_(found), buffer_(capacity) {
    sink_ = {buffer_.data(), 0, capacity, &Collector::flush, this};
  }
  Sink& sink() { return sink_; }
  void finish() { flush(sink_); }

 private:
  static constexpr int capacity = 1024;
  static void flush(Sink& sink) {
    auto* self = static_cast<Collector*>(sink.owner);
    self->found_.insert(self->found_.end(), self->buffer_.begin(),
                        self->buffer_.begin() + sink.count);
    sink.count = 0;
  }
  std::vector<Found>& found_;
  std::vector<Found> buffer_;
  Sink sink_{};
};

int team_of(int threads) { return threads > 0 ? threads : omp_get_max_threads(); }

// Calls work(i, sink, counters) for i = 0 .. count - 1, shared in chunks among threads. Appends the
// results in the order of i.
template <class Sink, class Found, class Work>
void collect(int count, int chunk, int threads, std::vector<Found>& found,
             DescentCounters& counters, const Work& work) {
  const auto run = [&](int begin, int end, std::vector<Found>& into, DescentCounters& tests) {
    Collector<Sink, Found> collector(into);
    for (int i = begin; i < end; ++i) work(i, collector.sink(), tests);
    collector.finish();
  };
  const int team = team_of(threads);
  if (team == 1 || count <= chunk) {
    run(0, count, found, counters);
    return;
  }
  const int chunks = (count + chunk - 1) / chunk;
  // The calling thread keeps the memory of the results. Allocating it for each query would add half
  // the query's cost.
  thread_local std::vector<std::vector<Found>> kept;
  std::vector<std::vector<Found>>& parts = kept;  // each thread has a `kept` of its own
  parts.resize(std::max<std::size_t>(parts.size(), chunks));
  std::vector<DescentCounters> tests(chunks);
#pragma omp parallel for schedule(dynamic, 1) num_threads(team)
  for (int c = 0; c < chunks; ++c) {
    parts[c].clear();
    run(c * chunk, std::min(count, (c + 1) * chunk), parts[c], tests[c]);
  }
  std::vector<std::size_t> begin(chunks);
  std::size_t total = found.size();
  for (int c = 0; c < chunks; ++c) {
    begin[c] = total;
    total += parts[c].size();
    counters.bound_tests += tests[c].bound_tests;
    counters.certificate_tests += tests[c].certificate_tests;
    counters.certified += tests[c].certified;
  }
  found.resize(total);
#pragma omp parallel for schedule(dynamic, 1) num_threads(team)
  for (int c = 0; c < chunks; ++c)
    std::copy(parts[c].begin(), parts[c].end(), found.data() + begin[c]);
}

void traverse(const Pyramid& first, const Pyramid& second, const DescentQuery& query, int threads,
              std::vector<LeafBlockPair>& blocks, TraversalCounters& counters) {
  DescentCounters tests{};
  const std::vector<NodePair> starts = frontier(first, second, query, tests);
  // With fewer starting pairs, a team of threads costs more than it saves.
  constexpr std::size_t few = 64;
  if (starts.size() < few) threads = 1;
  const DescentKernels& kernels = descent_kernels();
  collect<BlockSink>(static_cast<int>(starts.size()), 4, threads, blocks, tests,
                     [&](int i, BlockSink& sink, DescentCounters& own) {
                       // Each thread keeps its workspace, so that it is created only once.
                       thread_local AlignedVector<std::byte> workspace(descent_workspace);
                       kernels.descend(query, starts[i], workspace.data(), sink, own);
                     });
  add(counters, tests);
}

// Makes a query with only the fields that number() reads.
DescentQuery numbering(const Pyramid& first, const Pyramid& second, bool self, Leaf leaf) {
  DescentQuery query{};
  query.a = &first.tree();
  query.b = &second.tree();
  query.self = self;
  query.triangles = leaf == Leaf::triangle;
  return query;
}

void append_numbers(const DescentQuery& query, std::span<const LeafBlockPair> blocks, int threads,
                    std::vector<LeafPair>& pairs) {
  constexpr std::size_t chunk_size = 512;
  const int chunks = static_cast<int>((blocks.size() + chunk_size - 1) / chunk_size);
  const auto chunk = [&](int c) {
    return blocks.subspan(c * chunk_size, std::min(chunk_size, blocks.size() - c * chunk_size));
  };
  const auto number = [&](int c) {
    thread_local std::vector<LeafPair> buffer(64 * chunk_size + 8);
    const std::size_t count =
        descent_kernels().number(query, chunk(c).data(), chunk(c).size(), buffer.data());
    return std::span<const LeafPair>(buffer.data(), count);
  };
  const int team = std::min(team_of(threads), chunks);
  if (team <= 1) {
    pairs.reserve(pairs.size() + count_pairs(blocks));
    for (int c = 0; c < chunks; ++c) {
      const std::span<const LeafPair> numbered = number(c);
      pairs.insert(pairs.end(), numbered.begin(), numbered.end());
    }
    return;
  }
  // Chunk c writes its pairs from index place[c] on.
  std::vector<std::size_t> place(chunks + 1, pairs.size());
  for (int c = 0; c < chunks; ++c) place[c + 1] = place[c] + count_pairs(chunk(c));
  pairs.resize(place[chunks]);
#pragma omp parallel for schedule(dynamic, 4) num_threads(team)
  for (int c = 0; c < chunks; ++c) {
    const std::span<const LeafPair> numbered = number(c);
    std::copy(numbered.begin(), numbered.end(),
              pairs.begin() + static_cast<std::ptrdiff_t>(place[c]));
  }
}

void traverse(const Pyramid& first, const Pyramid& second, const DescentQuery& query,
              const TraversalOptions& options, std::vector<LeafPair>& pairs,
              TraversalCounters& counters) {
  std::vector<LeafBlockPair> blocks;
  traverse(first, second, query, options.threads, blocks, counters);
  append_numbers(query, blocks, options.threads, pairs);
}

// Frees memory that CacheLineAllocator has allocated. The memory is not initialised, whereas a
// vector would write to all of it.
struct FreeAligned {
  void operator()(std::byte* memory) const {
    CacheLineAllocator<std::byte>().deallocate(memory, 0);
  }
};

PatchBlock block_of(const Pyramid& pyramid, BoxNode node) {
  const int patch = pyramid.tree().levels[node.level].patch;
  return {patch, node.level - pyramid.tree().patches[patch].first_level, node.u, node.v};
}

void traverse_blocks(const Pyramid& first, const Pyramid& second, const DescentQuery& query,
                     int level, std::vector<BlockPair>& pairs, TraversalCounters& counters) {
  DescentCounters tests{};
  std::vector<NodePair> nodes = PatchPairs(first, second, query).find();
  // Each expansion replaces both blocks of a pair by blocks one level down. Leaf blocks stay.
  for (int i = 0; i < level; ++i) {
    if (!expand_all(query, nodes, tests, [](const NodePair&) { return false; })) break;
  }
  for (const NodePair& pair : nodes)
    pairs.push_back({block_of(first, pair.a), block_of(second, pair.b)});
  add(counters, tests);
}

}  // namespace

float half_margin(double margin, float magnitude_a, float magnitude_b) {
  margin = largest_margin_that_counts(margin);
  // Rounding to float32 moves a coordinate by at most 2^-24 of the magnitude, or by 2^-126 if the
  // result is flushed to zero.
  const double rounding =
      0x1p-23 * (static_cast<double>(magnitude_a) + static_cast<double>(magnitude_b)) + 0x1p-124;
  return rounded_up(0.5 * (margin + rounding));
}

float sphere_reach(float half, float magnitude_a, float magnitude_b) {
  const double gap = 2.0 * static_cast<double>(half);
  const double rounding =
      0x1p-22 * (static_cast<double>(magnitude_a) + static_cast<double>(magnitude_b) + gap);
  return rounded_up(static_cast<double>(root_of_three) * (gap + rounding));
}

double certificate_margin(double margin, float magnitude) {
  // Rounding the vertices to float32, and then the steps between them, shortens a distance by less
  // than 2^-20 of the magnitude plus 2^-124 m (docs/theory.md, "The tangent certificate").
  return margin + 0x1p-20 * static_cast<double>(magnitude) + 0x1p-124;
}

void single_traversal(const Pyramid& pyramid, const Vec3& point, double radius,
                      const TraversalOptions& options, std::vector<int>& leaves,
                      TraversalCounters& counters) {
  std::vector<LeafPair> pairs;
  single_traversal(pyramid, std::span(&point, 1), radius, options, pairs, counters);
  for (const LeafPair& pair : pairs) leaves.push_back(pair.b);
}

void single_traversal(const Pyramid& pyramid, std::span<const Vec3> points, double radius,
                      const TraversalOptions& options, std::vector<LeafPair>& pairs,
                      TraversalCounters& counters) {
  assert(radius >= 0 && std::isfinite(radius));
  assert(std::all_of(points.begin(), points.end(), [](const Vec3& p) {
    return p.cwiseAbs().maxCoeff() < static_cast<double>(Pyramid::coordinate_limit);
  }));
  DescentQuery query = query_of(pyramid, pyramid, false, options);
  query.half_margin = 0;
  DescentCounters tests{};
  const int batches = (static_cast<int>(points.size()) + points_per_batch - 1) / points_per_batch;
  const double reach = largest_margin_that_counts(options.margin + radius);
  collect<PairSink>(batches, 1, options.threads, pairs, tests,
                    [&](int i, PairSink& sink, DescentCounters& own) {
                      const std::size_t first = points.size() * i / batches;
                      const int count = static_cast<int>(points.size() * (i + 1) / batches - first);
                      // Each thread keeps its workspace, so that it is created only once.
                      thread_local const std::unique_ptr<std::byte, FreeAligned> workspace(
                          CacheLineAllocator<std::byte>().allocate(point_workspace));
                      const PointDescentKernels& kernels = point_descent_kernels();
                      const float largest_half = kernels.load_points(
                          points[first].data(), count, reach, pyramid.magnitude(), workspace.get());
                      for (int patch = 0; patch < pyramid.patch_count(); ++patch) {
                        kernels.descend_points(query, patch, count, largest_half,
                                               static_cast<int>(first), workspace.get(), sink, own);
                      }
                    });
  add(counters, tests);
}

void dual_traversal(const Pyramid& first, const Pyramid& second, const TraversalOptions& options,
                    std::vector<LeafPair>& pairs, TraversalCounters& counters) {
  traverse(first, second, query_of(first, second, false, options), options, pairs, counters);
}

void self_traversal(const Pyramid& pyramid, const TraversalOptions& options,
                    std::vector<LeafPair>& pairs, TraversalCounters& counters) {
  traverse(pyramid, pyramid, query_of(pyramid, pyramid, true, options), options, pairs, counters);
}

void dual_traversal(const Pyramid& first, const Pyramid& second, const TraversalOptions& options,
                    std::vector<LeafBlockPair>& blocks, TraversalCounters& counters) {
  traverse(first, second, query_of(first, second, false, options), options.threads, blocks,
           counters);
}

void self_traversal(const Pyramid& pyramid, const TraversalOptions& options,
                    std::vector<LeafBlockPair>& blocks, TraversalCounters& counters) {
  traverse(pyramid, pyramid, query_of(pyramid, pyramid, true, options), options.threads, blocks,
           counters);
}

void dual_traversal(const Pyramid& first, const RigidPyramid& second,
                    std::span<const RigidFrame> ends, const TraversalOptions& options,
                    std::vector<LeafPair>& pairs, TraversalCounters& counters) {
  PlacedTree placed;
  second.place(ends, placed);
  DescentQuery query = query_of(first, placed.tree, false, options);
  query.sphere_reach = rounded_up(static_cast<double>(query.sphere_reach) + placed.beyond_spheres);
  traverse(first, second.pyramid(), query, options, pairs, counters);
}

void append_pairs(const Pyramid& first, const Pyramid& second, Leaf leaf,
                  std::span<const LeafBlockPair> blocks, int threads,
                  std::vector<LeafPair>& pairs) {
  append_numbers(numbering(first, second, false, leaf), blocks, threads, pairs);
}

void append_pairs(const Pyramid& pyramid, Leaf leaf, std::span<const LeafBlockPair> blocks,
                  int threads, std::vector<LeafPair>& pairs) {
  append_numbers(numbering(pyramid, pyramid, true, leaf), blocks, threads, pairs);
}

void dual_traversal_of_blocks(const Pyramid& first, const Pyramid& second, int level,
                              const TraversalOptions& options, std::vector<BlockPair>& pairs,
                              TraversalCounters& counters) {
  traverse_blocks(first, second, query_of(first, second, false, options), level, pairs, counters);
}

void self_traversal_of_blocks(const Pyramid& pyramid, int level, const TraversalOptions& options,
                              std::vector<BlockPair>& pairs, TraversalCounters& counters) {
  traverse_blocks(pyramid, pyramid, query_of(pyramid, pyramid, true, options), level, pairs,
                  counters);
}

}  // namespace weft::bsi
