#include "sim/contact/body_motion.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "sim/base/parallel.h"

namespace weft::sim {

namespace {

// Distance (m) from the origin at which a point counts as lost.
constexpr double lost_distance = 1e15;

constexpr double infinity = std::numeric_limits<double>::infinity();

// Extends the box by the points. Returns the sum of the points. The sum is NaN if a point is NaN,
// whereas the box ignores NaN.
Vec3 extend(BodyTree::Box& box, std::span<const Vec3> points) {
  Vec3 low = box.min(), high = box.max(), sum = Vec3::Zero();
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
    sum += p;
  }
  box = BodyTree::Box(low, high);
  return sum;
}

bool is_near_origin(const BodyTree::Box& box) {
  return box.min().minCoeff() > -lost_distance / 2 && box.max().maxCoeff() < lost_distance / 2;
}

}  // namespace

BodyMotion::BodyMotion(const Scene& scene)
    : scene_(scene),
      obstacles_(scene),
      bodies_(scene.bodies.size()),
      placed_(scene, scene.point_count),
      own_(scene, scene.dynamic_points) {
  for (int b = 0; b < static_cast<int>(scene.bodies.size()); ++b)
    if (scene.bodies[b].moves) moving_.push_back(b);
}

std::span<const Vec3> BodyMotion::of_body(std::span<const Vec3> all, int body) const {
  return all.subspan(scene_.bodies[body].first_point, scene_.bodies[body].point_count());
}

std::optional<int> BodyMotion::follow(const PointPaths& paths, std::span<const double> stray,
                                      std::span<const Vec3> velocity) {
  const bool is_first = !paths_;
  time_before_ = is_first ? paths.end.time() : std::min(paths_->end.time(), paths.end.time());
  velocity_ = velocity;
  paths_.emplace(paths);
  for (const int b : moving_) {
    bodies_[b].stray = stray.empty() ? 0 : stray[b];
    bodies_[b].box.setEmpty();
  }
  for (int b = 0; is_first && b < static_cast<int>(bodies_.size()); ++b)
    if (!scene_.bodies[b].moves) extend(bodies_[b].box, of_body(paths.end.position(), b));
  if (paths.is_path()) {
    if (const auto lost = enclose(paths.start)) return lost;
  }
  for (const int b : moving_) bodies_[b].start_middle = bodies_[b].middle;
  return enclose(paths.end);
}

// Extends the boxes of all bodies that move, and finds the means of their points.
std::optional<int> BodyMotion::enclose(const PlacedPoints& now) {
  for (const int b : moving_) {
    Body& body = bodies_[b];
    const int number = obstacles_.of_body(b);
    bool is_finite = false;
    if (const RigidPose* pose = now.pose(number)) {
      body.box.extend(obstacles_.all()[number].box(*pose));
      is_finite = pose->rotation.allFinite() && pose->translation.allFinite();
    } else {
      const auto points = of_body(now.position(), b);
      const Vec3 sum = extend(body.box, points);
      body.middle = sum / static_cast<double>(std::max<std::size_t>(1, points.size()));
      is_finite = sum.allFinite();
    }
    if (is_finite && is_near_origin(body.box)) continue;
    if (now.pose(number) != nullptr) now.place_all(obstacles_.all()[number]);
    if (const auto lost = find_lost(now.position(), b)) return lost;
  }
  return std::nullopt;
}

// Returns a point of the body that is not finite or farther than lost_distance from the origin, if
// any.
std::optional<int> BodyMotion::find_lost(std::span<const Vec3> position, int body) const {
  const auto points = of_body(position, body);
  const auto lost = std::find_if(points.begin(), points.end(), [](const Vec3& p) {
    return !(p.squaredNorm() < lost_distance * lost_distance);
  });
  if (lost == points.end()) return std::nullopt;
  return scene_.bodies[body].first_point + static_cast<int>(lost - points.begin());
}

// Returns the rigid obstacle of a body whose pose is given, or null.
const RigidObstacle* BodyMotion::posed(int body) const {
  const int number = obstacles_.of_body(body);
  return paths_->end.pose(number) == nullptr ? nullptr : &obstacles_.all()[number];
}

BodyPaths BodyMotion::placed_paths(int body) const {
  BodyPaths paths;
  paths.start = of_body(paths_->start.position(), body);
  paths.end = of_body(paths_->end.position(), body);
  paths.start_time = paths.is_path() ? paths_->start.time() : time_before_;
  paths.end_time = paths_->end.time();
  if (!velocity_.empty()) paths.velocity = of_body(velocity_, body);
  return paths;
}

BodyPaths BodyMotion::own_paths(int body) const {
  BodyPaths paths = placed_paths(body);
  paths.end_origin = bodies_[body].middle;
  paths.start_origin = paths.is_path() ? bodies_[body].start_middle : paths.end_origin;
  return paths;
}

BodyMotion::Displacement BodyMotion::displacement(std::span<const Vec3> recorded,
                                                  std::span<const Vec3> now) {
  Displacement moved;
  for (std::size_t i = 0; i < recorded.size(); ++i) moved.mean += now[i] - recorded[i];
  moved.mean /= static_cast<double>(std::max<std::size_t>(1, recorded.size()));
  double largest = 0;
  for (std::size_t i = 0; i < recorded.size(); ++i)
    largest = std::max(largest, (now[i] - recorded[i] - moved.mean).squaredNorm());
  moved.residual = std::sqrt(largest);
  return moved;
}

// A point p of the obstacle, at t = 0, has moved by d + (R1 - R0) (p - middle), where d is the
// displacement of its middle. The spectral norm of R1 - R0 is its Frobenius norm over the square
// root of two, because its two nonzero singular values are equal.
BodyMotion::Displacement BodyMotion::displacement(const RigidObstacle& obstacle,
                                                  const RigidPose& recorded, const RigidPose& now) {
  Displacement moved;
  moved.mean = now.place(obstacle.middle) - recorded.place(obstacle.middle);
  moved.residual = std::numbers::sqrt2 / 2 * (now.rotation - recorded.rotation).norm() *
                   obstacle.radius * (1 + 1e-9);
  return moved;
}

void BodyMotion::measure_placed(int b, bool with_mean) {
  Body& body = bodies_[b];
  body.with_mean = with_mean;
  const RigidObstacle* obstacle = posed(b);
  if (!scene_.bodies[b].moves) {
    body.moved = placed_.has(b) ? 0 : infinity;
  } else if (obstacle == nullptr) {
    body.pose.reset();
    if (with_mean && placed_.looks_ahead(b)) placed_.forget(b);
    placed_.measure(b, placed_paths(b));
    body.moved = placed_.displacement(b);
    if (with_mean && placed_.has(b)) find_means(b);
  } else if (!body.pose) {
    body.moved = infinity;
  } else {
    const RigidPose& from = body.start_pose ? *body.start_pose : *body.pose;
    body.at_end = displacement(*obstacle, *body.pose, *paths_->end.pose(obstacle->number));
    body.at_start = paths_->is_path()
                        ? displacement(*obstacle, from, *paths_->start.pose(obstacle->number))
                        : body.at_end;
    body.moved = std::max(body.at_start.largest(), body.at_end.largest());
  }
}

void BodyMotion::find_means(int b) {
  const BodyPaths now = placed_paths(b);
  bodies_[b].at_end = displacement(placed_.end(b), now.end);
  bodies_[b].at_start =
      now.is_path() ? displacement(placed_.start(b), now.start) : bodies_[b].at_end;
}

// At equal times on two straight paths, displacements are convex combinations of the displacements
// at the ends, with the same weights for both bodies. The change is therefore no larger than at one
// of the ends.
double BodyMotion::change(int a, int b) const {
  const Body &one = bodies_[a], &other = bodies_[b];
  const double sum = one.moved + other.moved;
  if (!scene_.bodies[b].moves || sum == infinity) return sum;
  const auto relative = [](const Displacement& p, const Displacement& q) {
    return p.residual + q.residual + (p.mean - q.mean).norm();
  };
  return std::min(
      sum, std::max(relative(one.at_start, other.at_start), relative(one.at_end, other.at_end)));
}

void BodyMotion::choose_placed(int b) {
  if (posed(b) != nullptr) {
    bodies_[b].chosen = bodies_[b].moved;
  } else {
    placed_.choose(b);
    find_features(b, placed_, bodies_[b].placed);
  }
}

void BodyMotion::choose_own(int b) {
  own_.choose(b);
  find_features(b, own_, bodies_[b].own);
}

double BodyMotion::growth(int b) const {
  if (!scene_.bodies[b].moves) return 0;
  if (posed(b) == nullptr) return placed_.growth(b);
  const Body& body = bodies_[b];
  return body.chosen < infinity ? std::max(body.moved - body.chosen, 0.0) : infinity;
}

void BodyMotion::renew_placed(int b, const RecordRules& rules) {
  Body& body = bodies_[b];
  body.at_start = body.at_end = {};
  if (const RigidObstacle* obstacle = posed(b)) {
    body.pose = *paths_->end.pose(obstacle->number);
    body.start_pose.reset();
    if (paths_->is_path()) body.start_pose = *paths_->start.pose(obstacle->number);
    body.moved = 0;
    placed_.renew_by_place(b, body.start_pose.has_value());
    return;
  }
  RecordRules with_others = rules;
  if (body.with_mean || !scene_.bodies[b].moves) with_others.ahead = 0;
  placed_.renew(b, placed_paths(b), with_others);
  body.moved = placed_.displacement(b);
  if (body.with_mean) find_means(b);
}

void BodyMotion::renew_own(int body, const RecordRules& rules) {
  BodyPaths now = own_paths(body);
  for (const Vec3& each : now.velocity) now.velocity_origin += each;
  now.velocity_origin /= static_cast<double>(std::max<std::size_t>(1, now.velocity.size()));
  own_.renew(body, now, rules);
}

void BodyMotion::forget_renewed() {
  placed_.forget_renewed();
  own_.forget_renewed();
}

BodyPath BodyMotion::placed_path(int b, bool with_points) {
  const Body& body = bodies_[b];
  BodyPath path{b, placed_.start(b), placed_.end(b)};
  if (!body.pose) return path;
  const RigidObstacle& obstacle = obstacles_.all()[obstacles_.of_body(b)];
  const RigidPose& from = body.start_pose ? *body.start_pose : *body.pose;
  if (!with_points) {
    path.obstacle = &obstacle;
    path.frames = {obstacle.frame(from), obstacle.frame(*body.pose)};
    return path;
  }
  for (std::size_t i = 0; i < obstacle.start().size(); ++i) {
    const Vec3& start = obstacle.start()[i];
    placed_.place(obstacle.first_point + static_cast<int>(i), from.place(start),
                  body.pose->place(start));
  }
  return path;
}

void BodyMotion::place_quad(int b, int quad) {
  const Body& body = bodies_[b];
  const RigidObstacle& obstacle = obstacles_.all()[obstacles_.of_body(b)];
  for (const int corner : scene_.bodies[b].surface_atlas().quad_particles(quad)) {
    const int point = obstacle.first_point + corner;
    if (!marks_.is_new(point)) continue;
    const Vec3& start = obstacle.start()[corner];
    const Vec3 end = body.pose->place(start);
    placed_.place(point, body.start_pose ? body.start_pose->place(start) : end, end);
  }
}

void BodyMotion::find_features(int b, const Snapshot& snapshot, Features& found) const {
  const bsi::Mesh& mesh = scene_.bodies[b].surface_mesh();
  const auto point = snapshot.displacements().subspan(scene_.bodies[b].first_point,
                                                      scene_.bodies[b].point_count());
  const auto bounds = [&](Feature kind) -> std::vector<float>& {
    return found.bounds[static_cast<int>(kind)];
  };
  std::vector<float>& vertex = bounds(Feature::vertex);
  std::vector<float>& triangle = bounds(Feature::triangle);
  std::vector<float>& edge = bounds(Feature::edge);
  found.largest = static_cast<float>(snapshot.displacement(b)) * (1 + 1e-6F);
  vertex.assign(point.begin(), point.end());
  if (scene_.bodies[b].spheres != nullptr) {
    triangle = vertex;  // a sphere counts as a triangle (SurfaceFeatures)
    return;
  }
  triangle.resize(mesh.triangles.size());
  edge.resize(mesh.edges.size());
  const int triangles = static_cast<int>(triangle.size()), edges = static_cast<int>(edge.size());
  parallel_chunks(triangles, scene_.threads, [&](int first, int last) {
    for (int t = first; t < last; ++t) {
      const auto& [i, j, k] = mesh.triangles[t];
      triangle[t] = std::max({point[i], point[j], point[k]});
    }
  });
  parallel_chunks(edges, scene_.threads, [&](int first, int last) {
    for (int e = first; e < last; ++e) {
      const auto& [i, j] = mesh.edges[e].vertex;
      edge[e] = std::max(point[i], point[j]);
    }
  });
}

FeatureMotion BodyMotion::features(int b, Feature kind, bool own) const {
  const Body& body = bodies_[b];
  if (!scene_.bodies[b].moves) return {};
  if (body.pose) return {{}, static_cast<float>(body.moved) * (1 + 1e-6F)};
  const Features& found = own ? body.own : body.placed;
  return {found.bounds[static_cast<int>(kind)], found.largest};
}

}  // namespace weft::sim
