#include "sim/motion/prescribed_paths.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "bsi/continuous_collision.h"
#include "sim/contact/contact_search.h"

namespace weft::sim {

namespace {

using Box = Eigen::AlignedBox3d;

template <std::size_t Count>
std::array<int, 4> joined(const std::array<int, Count>& a, const std::array<int, 4 - Count>& b) {
  std::array<int, 4> nodes{};
  std::copy(a.begin(), a.end(), nodes.begin());
  std::copy(b.begin(), b.end(), nodes.begin() + Count);
  return nodes;
}

bool share_a_vertex(const std::array<int, 4>& nodes, int split) {
  return std::any_of(nodes.begin(), nodes.begin() + split, [&](int node) {
    return std::find(nodes.begin() + split, nodes.end(), node) != nodes.end();
  });
}

}  // namespace

PrescribedPaths::PrescribedPaths(const Scene& scene)
    : scene_(scene),
      motion_of_particle_(scene.particle_count, -1),
      motion_of_(scene.point_count, -1),
      several_motions_(static_cast<int>(scene.prescribed.size()) + 1),
      features_(scene.bodies.size()),
      obstacles_(scene),
      is_placed_(scene.bodies.size(), 0),
      stray_(scene.prescribed.size() + 1, 0.0) {
  const std::span<const Vec3> points =
      scene.surface_map.points_of(scene.initial_position, scene.point_count, start_);
  start_.assign(points.begin(), points.end());
  end_ = start_;
  if (!scene.surface_map.is_identity()) particle_start_ = particle_end_ = scene.initial_position;
  std::fill(motion_of_particle_.begin() + scene.dynamic_particles, motion_of_particle_.end(), 0);
  for (std::size_t m = 0; m < scene.prescribed.size(); ++m) {
    const PrescribedMotion& held = scene.prescribed[m];
    for (const int particle : held.particles)
      motion_of_particle_[particle] = held.moves ? static_cast<int>(m) + 1 : 0;
  }
  const auto is_held = [&](int point) { return motion_of_[point] >= 0; };
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const SceneBody& body = scene.bodies[b];
    const int first = body.first_point;
    Features& features = features_[b];
    for (int i = first; i < first + body.point_count(); ++i) {
      motion_of_[i] = motion_of_point(i, features.motions);
      if (is_held(i)) features.vertices.push_back(i);
    }
    for (const bsi::Edge& edge : body.surface_mesh().edges) {
      const std::array<int, 2> e{edge.vertex[0] + first, edge.vertex[1] + first};
      if (std::all_of(e.begin(), e.end(), is_held)) features.edges.push_back(e);
    }
    for (const auto& [x, y, z] : body.surface_mesh().triangles) {
      const std::array<int, 3> t{x + first, y + first, z + first};
      if (std::all_of(t.begin(), t.end(), is_held)) features.triangles.push_back(t);
    }
    std::sort(features.motions.begin(), features.motions.end());
    features.motions.erase(std::unique(features.motions.begin(), features.motions.end()),
                           features.motions.end());
  }
  std::vector<Box> boxes;
  const int bodies = static_cast<int>(scene.bodies.size());
  for (int b = 0; b < bodies; ++b) {
    boxes.push_back(swept_box(features_[b].vertices));
    const std::vector<int>& motions = features_[b].motions;
    if (motions.empty() || motions.back() == 0) continue;
    for (int other = 0; other < bodies; ++other) {
      if (!may_cross({std::min(b, other), std::max(b, other)})) continue;
      moving_.push_back(b);
      break;
    }
  }
  tree_.build(std::move(boxes));
}

// Returns the motion of a surface point, numbered as in motion_of_. If the point is prescribed,
// appends the motions of its particles to `motions`.
int PrescribedPaths::motion_of_point(int point, std::vector<int>& motions) const {
  if (scene_.surface_map.is_identity()) {
    const int motion = motion_of_particle_[point];
    if (motion >= 0) motions.push_back(motion);
    return motion;
  }
  const auto shares = scene_.surface_map.shares(point);
  const auto motion = [&](const SurfaceMap::Share& share) {
    return motion_of_particle_[share.particle];
  };
  if (std::ranges::any_of(shares, [&](const auto& share) { return motion(share) < 0; })) return -1;
  const int first = motion(shares[0]);
  for (const SurfaceMap::Share& share : shares) motions.push_back(motion(share));
  const bool is_one =
      std::ranges::all_of(shares, [&](const auto& share) { return motion(share) == first; });
  return is_one ? first : several_motions_;
}

bool PrescribedPaths::moves(int body, double from, double to) const {
  return std::ranges::any_of(features_[body].motions, [&](int m) {
    if (m == 0) return false;
    const PrescribedMotion& held = scene_.prescribed[m - 1];
    return held.motion.bounds(from, to, held.radius).travel > 0;
  });
}

// True if prescribed features of the two bodies must be checked for crossings. They need no check
// if both bodies are obstacles of the case, if all features follow one motion, or if a body without
// self-contact is paired with itself.
bool PrescribedPaths::may_cross(const BodyPair& pair) const {
  const std::vector<int>&a = features_[pair.a].motions, &b = features_[pair.b].motions;
  if (scene_.bodies[pair.a].is_obstacle || a.empty() || b.empty()) return false;
  if (pair.a == pair.b && !scene_.bodies[pair.a].self_contact) return false;
  return a != b || a.size() > 1;
}

void PrescribedPaths::place(int body) {
  if (is_placed_[body] != 0) return;
  is_placed_[body] = 1;
  const SurfaceMap& map = scene_.surface_map;
  std::vector<Vec3>& start = map.is_identity() ? start_ : particle_start_;
  std::vector<Vec3>& end = map.is_identity() ? end_ : particle_end_;
  for (const int m : features_[body].motions) {
    if (m == 0) continue;
    const PrescribedMotion& held = scene_.prescribed[m - 1];
    moved_.resize(held.start.size());
    rates_.resize(held.start.size());
    for (const auto& [time, position] : {std::pair(from_, &start), std::pair(to_, &end)}) {
      held.motion.apply(time, held.start, moved_, rates_);
      for (std::size_t i = 0; i < moved_.size(); ++i) (*position)[held.particles[i]] = moved_[i];
    }
  }
  if (map.is_identity()) return;
  for (const int point : features_[body].vertices) {
    start_[point] = map.apply(point, particle_start_);
    end_[point] = map.apply(point, particle_end_);
  }
}

// Returns the box around the paths of the features of a body. A rigid obstacle is bounded by its
// moved box, without placing its points.
Eigen::AlignedBox3d PrescribedPaths::box_of_paths(int body) {
  const int number = obstacles_.of_body(body);
  if (number < 0) {
    place(body);
    return swept_box(features_[body].vertices);
  }
  const RigidObstacle& obstacle = obstacles_.all()[number];
  Box box;
  for (const double time : {from_, to_}) box.extend(obstacle.box(obstacle.held->motion.pose(time)));
  const double most = scene_.surface_map.is_identity() ? stray_[features_[body].motions.back()]
                                                       : largest_stray(features_[body].vertices);
  const Vec3 stray = Vec3::Constant(most);
  return {box.min() - stray, box.max() + stray};
}

// Returns the sorted pairs of bodies that may cross in the interval: each moving body with itself
// and with the bodies whose boxes overlap its box.
std::vector<BodyPair> PrescribedPaths::pairs_that_move(double from, double to) {
  from_ = from;
  to_ = to;
  std::vector<Box> boxes;
  for (const int body : moving_) {
    is_placed_[body] = 0;
    for (const int m : features_[body].motions) {
      if (m == 0) continue;
      const PrescribedMotion& held = scene_.prescribed[m - 1];
      stray_[m] = held.motion.bounds(from, to, held.radius).stray;
    }
    boxes.push_back(box_of_paths(body));
  }
  tree_.move(moving_, boxes);
  std::vector<BodyPair> pairs;
  for (const int body : moving_) {
    if (!moves(body, from, to)) continue;
    const auto add = [&](int other) {
      const BodyPair pair{std::min(body, other), std::max(body, other)};
      if (may_cross(pair)) pairs.push_back(pair);
    };
    add(body);
    tree_.visit_neighbours(body, add);
  }
  std::ranges::sort(pairs);
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

std::optional<ContactFault> PrescribedPaths::find_crossing(double from, double to) {
  for (const BodyPair& pair : pairs_that_move(from, to)) {
    if (auto fault = check(pair)) return fault;
  }
  return std::nullopt;
}

double PrescribedPaths::stray_of(int point) const {
  if (scene_.surface_map.is_identity()) return stray_[motion_of_[point]];
  double sum = 0;
  for (const auto& [particle, weight] : scene_.surface_map.shares(point))
    sum += std::abs(weight) * stray_[motion_of_particle_[particle]];
  return sum;
}

template <class Points>
double PrescribedPaths::largest_stray(const Points& points) const {
  double largest = 0;
  for (const int p : points) largest = std::max(largest, stray_of(p));
  return largest;
}

// Returns a box around the true paths of these points and of every point of their convex hull.
template <class Points>
Eigen::AlignedBox3d PrescribedPaths::swept_box(const Points& points) const {
  Box box;
  for (const int p : points) box.extend(start_[p]).extend(end_[p]);
  const double stray = largest_stray(points);
  box.min().array() -= stray;
  box.max().array() += stray;
  return box;
}

std::optional<ContactFault> PrescribedPaths::check(const BodyPair& pair) {
  for (const int body : {pair.a, pair.b}) {
    if (std::ranges::binary_search(moving_, body)) place(body);
  }
  const Features &a = features_[pair.a], &b = features_[pair.b];
  if (!swept_box(a.vertices).intersects(swept_box(b.vertices))) return std::nullopt;
  const auto as_arrays = [](const std::vector<int>& vertices) {
    std::vector<std::array<int, 1>> arrays;
    arrays.reserve(vertices.size());
    for (const int vertex : vertices) arrays.push_back({vertex});
    return arrays;
  };
  if (auto fault = check_kind(false, as_arrays(a.vertices), b.triangles)) return fault;
  if (pair.a != pair.b) {
    if (auto fault = check_kind(false, as_arrays(b.vertices), a.triangles)) return fault;
  }
  return check_kind(true, a.edges, b.edges);
}

// True if all nodes follow one motion, which keeps their distances constant.
bool PrescribedPaths::is_rigid(const std::array<int, 4>& nodes) const {
  const int motion = motion_of_[nodes[0]];
  return motion != several_motions_ &&
         std::ranges::all_of(nodes, [&](int node) { return motion_of_[node] == motion; });
}

// Checks vertices against triangles, or edges against edges. Of the first kind, only features near
// those of the second are put in a tree, which finds the pairs whose boxes meet.
template <class First, class Second>
std::optional<ContactFault> PrescribedPaths::check_kind(bool edges, const std::vector<First>& first,
                                                        const std::vector<Second>& second) const {
  Box all;
  for (const Second& other : second) all.extend(swept_box(other));
  std::vector<First> near;
  std::vector<Box> boxes;
  for (const First& one : first) {
    const Box box = swept_box(one);
    if (!box.intersects(all)) continue;
    near.push_back(one);
    boxes.push_back(box);
  }
  BodyTree tree;
  tree.build(std::move(boxes));
  std::vector<int> met;
  for (const Second& other : second) {
    met.clear();
    tree.visit_meeting(swept_box(other), [&](int one) { met.push_back(one); });
    // The order of the features, not that of the tree, decides which crossing is reported.
    std::ranges::sort(met);
    for (const int one : met) {
      if (auto fault = check_pair(edges, near[one], other)) return fault;
    }
  }
  return std::nullopt;
}

template <class First, class Second>
std::optional<ContactFault> PrescribedPaths::check_pair(bool edges, const First& one,
                                                        const Second& other) const {
  const std::array<int, 4> nodes = joined(one, other);
  if (is_rigid(nodes) || share_a_vertex(nodes, edges ? 2 : 1)) return std::nullopt;
  if (!scene_.sewn.is_empty() && scene_.sewn.are_joined(nodes, edges ? 2 : 1)) return std::nullopt;
  bsi::FourPoints from, to;
  for (int k = 0; k < 4; ++k) {
    from[k] = start_[nodes[k]];
    to[k] = end_[nodes[k]];
  }
  const double separation = largest_stray(one) + largest_stray(other);
  const double safe = edges ? bsi::safe_fraction_edge_edge(from, to, separation)
                            : bsi::safe_fraction_vertex_triangle(from, to, separation);
  if (safe < 1) return ContactFault{ContactFault::Kind::crossing, nodes, 0};
  return std::nullopt;
}

}  // namespace weft::sim
