#include "gpu/compute_traversal.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include "gpu/compute_device.h"

namespace weft::gpu {
namespace {

// A search has one list of pairs of blocks per step (fewer than pair_lists steps), then a list of
// pairs of leaf blocks, then a list of candidates.
constexpr int pair_lists = 32;
constexpr std::uint32_t leaf_list = pair_lists;
constexpr std::uint32_t result_list = pair_lists + 1;

// Number of work groups of each step on a graphics processor, whose idle ones cost microseconds.
// Software runs as many as the list needs, by an indirect dispatch. NVIDIA's driver (580) takes
// stale numbers for those.
constexpr GLuint hardware_groups = 2048;

// Returns the smallest float32 number that is at least `value`.
float rounded_up(double value) {
  const auto rounded = static_cast<float>(value);
  if (static_cast<double>(rounded) >= value) return rounded;
  return std::nextafter(rounded, std::numeric_limits<float>::infinity());
}

// Returns Query::filter_reach: the margin plus a bound of all rounding errors, m (docs/theory.md,
// "The distance filter"). The result is negative (no filter) if squares in the shader might
// overflow.
float filter_reach(double margin, const ComputePyramid::Device::Body& a,
                   const ComputePyramid::Device::Body& b) {
  const double largest = static_cast<double>(a.magnitude) + static_cast<double>(b.magnitude);
  if (largest > 0x1p20) return -1;
  return rounded_up(margin + 0x1p-19 * largest + 0x1p-60);
}

int deepest_patch(const ComputePyramid::Device::Body& body) {
  std::size_t levels = 0;
  for (const auto& patch : body.patches) levels = std::max(levels, patch.size());
  return static_cast<int>(levels);
}

using Lists = std::array<shaders::List, pair_lists + 2>;

}  // namespace

struct ComputeTraversal::Implementation {
  ComputePyramid& pyramids;
  bsi::Bound bound;
  ComputePyramid::Device& device = pyramids.device();
  const GlFunctions& gl = device.gl;
  GLint group_limit = 0;
  GlBuffer queries{gl}, lists{gl}, leaf_pairs{gl}, results{gl};
  // Two buffers for lists of pairs. A step reads one of them and writes the other.
  std::array<GlBuffer, 2> pairs{GlBuffer(gl), GlBuffer(gl)};
  ComputeProgram expand_pairs{gl, shaders::expand_pairs(bound, device.rounds_like_the_cpu)};
  ComputeProgram find_leaves{gl, shaders::find_leaves()};
  // Numbers of items for which each buffer of `pairs`, `leaf_pairs`, and `results` have memory.
  std::size_t pair_capacity = 0, leaf_capacity = 0, result_capacity = 0;
  int reruns = 0;
  std::size_t pairs_followed = 0;
  // The input of the latest search (queries and starting pairs) and its result (candidates).
  std::vector<shaders::Query> query_table;
  std::vector<shaders::BlockPair> starts;
  int steps = 0;  // number of dispatches of expand_pairs, enough for every query
  std::vector<Candidate> candidates;

  Implementation(ComputePyramid& pyramids_of_bodies, bsi::Bound compared)
      : pyramids(pyramids_of_bodies), bound(compared) {
    gl.GetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, 0, &group_limit);
  }
  void begin();
  void add_query(const PairQuery& query);
  void add_balls(int body, std::span<const Ball> balls, double margin);
  std::span<const Candidate> run(Leaf leaf);
  void reserve(std::size_t pair_count, std::size_t leaf_count, std::size_t result_count);
  Lists traverse(Leaf leaf);
  bool has_room(const Lists& filled) const;
};

void ComputeTraversal::Implementation::begin() {
  device.context.make_current();
  query_table.clear();
  starts.clear();
  steps = 0;
}

void ComputeTraversal::Implementation::add_query(const PairQuery& query) {
  const auto& a = device.bodies[query.body_a];
  const auto& b = device.bodies[query.body_b];
  const bool self = query.body_a == query.body_b;
  const auto number = static_cast<std::uint32_t>(query_table.size());
  shaders::Query entry;
  assert(bound == bsi::Bound::box || (a.spheres && b.spheres));
  entry.half_margin = bsi::half_margin(query.margin, a.magnitude, b.magnitude);
  entry.sphere_reach = bsi::sphere_reach(entry.half_margin, a.magnitude, b.magnitude);
  if (self && query.certificate) {
    assert(a.tangents);
    entry.certificate_margin = bsi::certificate_margin(query.margin, a.magnitude);
  }
  if (query.distance_filter) entry.filter_reach = filter_reach(query.margin, a, b);
  entry.flags = (self ? shaders::query_flags::self : 0) |
                (a.swept ? shaders::query_flags::swept_a : 0) |
                (b.swept ? shaders::query_flags::swept_b : 0);
  query_table.push_back(entry);
  starts.push_back({static_cast<std::uint32_t>(a.top_block()),
                    static_cast<std::uint32_t>(b.top_block()), a.top() | b.top() << 16, number});
  steps = std::max(steps, std::max(a.group_levels, b.group_levels) +
                              std::max(deepest_patch(a), deepest_patch(b)));
}

void ComputeTraversal::Implementation::add_balls(int body, std::span<const Ball> balls,
                                                 double margin) {
  const auto& b = device.bodies[body];
  for (const Ball& ball : balls) {
    const Eigen::Vector3f centre = ball.centre.cast<float>();
    const auto number = static_cast<std::uint32_t>(query_table.size());
    shaders::Query entry;
    const float magnitude = rounded_up(ball.centre.cwiseAbs().maxCoeff());
    entry.half_margin = bsi::half_margin(margin + ball.radius, b.magnitude, magnitude);
    entry.sphere_reach = bsi::sphere_reach(entry.half_margin, b.magnitude, magnitude);
    entry.flags = shaders::query_flags::point | (b.swept ? shaders::query_flags::swept_b : 0);
    std::copy_n(centre.data(), 3, entry.point);
    query_table.push_back(entry);
    starts.push_back({number, static_cast<std::uint32_t>(b.top_block()), b.top() << 16, number});
  }
  steps = std::max(steps, b.group_levels + deepest_patch(b));
}

void ComputeTraversal::Implementation::reserve(std::size_t pair_count, std::size_t leaf_count,
                                               std::size_t result_count) {
  const auto grow = [this](std::size_t& capacity, std::size_t needed, std::size_t item,
                           std::span<GlBuffer* const> buffers, const char* content) {
    const std::size_t room = grown_capacity(gl, capacity, needed, item);
    for (GlBuffer* buffer : buffers) buffer->reserve(room * item, content);
    capacity = room;
  };
  const std::array<GlBuffer*, 2> both{&pairs[0], &pairs[1]};
  const std::array<GlBuffer*, 1> leaves{&leaf_pairs}, found{&results};
  grow(pair_capacity, pair_count, sizeof(shaders::BlockPair), both, "pairs of blocks");
  grow(leaf_capacity, leaf_count, sizeof(shaders::BlockPair), leaves, "pairs of leaf blocks");
  grow(result_capacity, result_count, sizeof(Candidate), found, "candidates");
}

// Traverses all levels. Returns the lists with the number of items appended to each, including
// items beyond its capacity, which are lost.
Lists ComputeTraversal::Implementation::traverse(Leaf leaf) {
  Lists filled{};
  const auto start_count = static_cast<std::uint32_t>(starts.size());
  filled[0].length = start_count;
  filled[0].groups = std::min((start_count + shaders::group_size - 1) / shaders::group_size,
                              static_cast<std::uint32_t>(group_limit));
  lists.write(std::span<const shaders::List>(filled));
  pairs[0].write(std::span<const shaders::BlockPair>(starts));
  device.levels.bind(0);
  queries.bind(3);
  device.bounds.bind(4);
  lists.bind(5);
  gl.BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, lists.name());
  const auto dispatch = [&](std::uint32_t list) {
    if (device.context.backend() == GlBackend::hardware) {
      gl.DispatchCompute(hardware_groups, 1, 1);
    } else {
      gl.DispatchComputeIndirect(static_cast<GLintptr>(list * sizeof(shaders::List)));
    }
    gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
  };
  expand_pairs.use();
  device.tangents.bind(6);
  leaf_pairs.bind(7);
  expand_pairs.set("group_limit", static_cast<GLuint>(group_limit));
  expand_pairs.set("list_leaves", leaf_list);
  expand_pairs.set("pair_capacity", static_cast<GLuint>(pair_capacity));
  expand_pairs.set("leaf_capacity", static_cast<GLuint>(leaf_capacity));
  for (int step = 0; step < steps; ++step) {
    pairs[step % 2].bind(1);
    pairs[(step + 1) % 2].bind(2);
    expand_pairs.set("list_in", static_cast<GLuint>(step));
    expand_pairs.set("list_out", static_cast<GLuint>(step) + 1);
    dispatch(static_cast<std::uint32_t>(step));
  }
  find_leaves.use();
  leaf_pairs.bind(6);
  results.bind(7);
  device.coordinates.bind(1);
  device.map.bind(2);
  find_leaves.set("vertex_count", static_cast<GLuint>(device.vertices));
  find_leaves.set("group_limit", static_cast<GLuint>(group_limit));
  find_leaves.set("list_leaves", leaf_list);
  find_leaves.set("list_results", result_list);
  find_leaves.set("leaf_capacity", static_cast<GLuint>(leaf_capacity));
  find_leaves.set("result_capacity", static_cast<GLuint>(result_capacity));
  find_leaves.set("triangles", leaf == Leaf::triangle ? 1 : 0);
  dispatch(leaf_list);
  gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  lists.read(std::span<shaders::List>(filled));
  check_gl(gl, "traverse pyramids");
  return filled;
}

bool ComputeTraversal::Implementation::has_room(const Lists& filled) const {
  return std::ranges::all_of(
             std::span(filled).first(pair_lists),
             [&](const shaders::List& list) { return list.length <= pair_capacity; }) &&
         filled[leaf_list].length <= leaf_capacity && filled[result_list].length <= result_capacity;
}

std::span<const Candidate> ComputeTraversal::Implementation::run(Leaf leaf) {
  candidates.clear();
  if (starts.empty()) return candidates;
  assert(steps < pair_lists);
  queries.reserve(query_table.size() * sizeof(shaders::Query), "queries");
  queries.write(std::span<const shaders::Query>(query_table));
  lists.reserve(sizeof(Lists), "lengths of lists");
  constexpr std::size_t first_capacity = 1024;
  reserve(std::max(starts.size(), first_capacity), first_capacity, first_capacity);
  Lists filled = traverse(leaf);
  // Pairs lost from a full list have no children in the next lists, so one repetition may not be
  // enough. Each repetition completes at least one more level.
  while (!has_room(filled)) {
    ++reruns;
    std::size_t longest = 0;
    for (int i = 0; i < pair_lists; ++i) longest = std::max<std::size_t>(longest, filled[i].length);
    reserve(longest, filled[leaf_list].length, filled[result_list].length);
    filled = traverse(leaf);
  }
  pairs_followed = filled[leaf_list].length;
  for (int i = 0; i < pair_lists; ++i) pairs_followed += filled[i].length;
  candidates.resize(filled[result_list].length);
  results.read(std::span(candidates));
  return candidates;
}

ComputeTraversal::ComputeTraversal(ComputePyramid& pyramids, bsi::Bound bound) {
  pyramids.device().context.make_current();
  implementation_ = std::make_unique<Implementation>(pyramids, bound);
}

ComputeTraversal::~ComputeTraversal() { implementation_->device.context.make_current(); }

std::span<const Candidate> ComputeTraversal::find_pairs(std::span<const PairQuery> queries,
                                                        Leaf leaf) {
  implementation_->begin();
  for (const PairQuery& query : queries) implementation_->add_query(query);
  return implementation_->run(leaf);
}

std::span<const Candidate> ComputeTraversal::find_leaves(int body, std::span<const Ball> balls,
                                                         double margin, Leaf leaf) {
  implementation_->begin();
  implementation_->add_balls(body, balls, margin);
  return implementation_->run(leaf);
}

std::size_t ComputeTraversal::pairs_followed() const { return implementation_->pairs_followed; }
int ComputeTraversal::reruns() const { return implementation_->reruns; }

}  // namespace weft::gpu
