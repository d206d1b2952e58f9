#include "sim/channels/surface_tensors.h"

#include <Eigen/Dense>
#include <cmath>

#include "materials/bending.h"
#include "materials/hinge.h"
#include "sim/base/parallel.h"
#include "sim/case/membrane_stiffness.h"

namespace weft::sim {

namespace {

using materials::Nodes3;
using materials::Nodes4;

PlaneTensor plane_tensor(const Eigen::Matrix2d& matrix) {
  return {matrix(0, 0), 0.5 * (matrix(0, 1) + matrix(1, 0)), matrix(1, 1)};
}
Eigen::Matrix2d matrix_of(const PlaneTensor& tensor) {
  Eigen::Matrix2d matrix;
  matrix << tensor.xx, tensor.xy, tensor.xy, tensor.yy;
  return matrix;
}

// Returns the tensor rotated by an angle, given by its cosine and sine.
PlaneTensor turned(const PlaneTensor& tensor, double cosine, double sine) {
  const double mean = 0.5 * tensor.trace(), half = 0.5 * (tensor.xx - tensor.yy);
  const double twice_cosine = cosine * cosine - sine * sine, twice_sine = 2 * cosine * sine;
  const double turned_half = twice_cosine * half - twice_sine * tensor.xy;
  return {mean + turned_half, twice_sine * half + twice_cosine * tensor.xy, mean - turned_half};
}

// Returns a vector of the plane with unit normal `from`, rotated into the plane with unit normal
// `to` about the line in which the planes meet.
Vec3 turned_into(const Vec3& from, const Vec3& to, const Vec3& vector) {
  const Vec3 axis = from.cross(to);
  const double cosine = from.dot(to);
  // If the planes are folded onto each other, both contain the vector.
  if (1 + cosine < 1e-9) return vector;
  const Vec3 first = axis.cross(vector);
  return vector + first + axis.cross(first) / (1 + cosine);
}

// Returns the cosine and sine of the angle of R in the polar decomposition F = R U. `gradient` is
// F.
std::array<double, 2> rotation_of(const Eigen::Matrix2d& gradient) {
  const double cosine = gradient(0, 0) + gradient(1, 1);
  const double sine = gradient(1, 0) - gradient(0, 1);
  const double size = std::hypot(cosine, sine);
  return {cosine / size, sine / size};
}

PlaneTensor difference(const PlaneTensor& a, const PlaneTensor& b) {
  return {a.xx - b.xx, a.xy - b.xy, a.yy - b.yy};
}

// Returns the double contraction a : b.
double product(const PlaneTensor& a, const PlaneTensor& b) {
  return a.xx * b.xx + 2 * a.xy * b.xy + a.yy * b.yy;
}

// Returns the direction or its opposite: the one whose component of largest magnitude is positive.
Vec3 with_sign(const Vec3& direction) {
  int largest = 0;
  direction.cwiseAbs().maxCoeff(&largest);
  return direction[largest] < 0 ? Vec3(-direction) : direction;
}

// Returns the nodes of a right triangle with legs of 1 m along the axes, as columns. The columns of
// `gradient` are where a deformation takes the legs.
Nodes3 unit_triangle(const Eigen::Matrix2d& gradient) {
  Nodes3 nodes = Nodes3::Zero();
  nodes.topRightCorner<2, 2>() = gradient;
  return nodes;
}

// Eliminates the angles of border edges, which are those without has_angle. They take the values of
// least energy, which are linear in the other angles. Their curvature is therefore added to the
// curvature per angle of the other edges, and set to zero.
void complete(const Nodes3& rest, double poisson_ratio, const std::array<bool, 3>& has_angle,
              std::array<PlaneTensor, 3>& curvature) {
  const Mat3 modulus =
      materials::triangle_bending_modulus(rest, {true, true, true}, 1, poisson_ratio);
  std::vector<int> border, others;
  for (int i = 0; i < 3; ++i) (has_angle[i] ? others : border).push_back(i);
  if (border.empty()) return;
  Eigen::MatrixXd own(border.size(), border.size());
  for (std::size_t a = 0; a < border.size(); ++a) {
    for (std::size_t b = 0; b < border.size(); ++b) own(a, b) = modulus(border[a], border[b]);
  }
  for (const int j : others) {
    Eigen::VectorXd coupling(border.size());
    for (std::size_t a = 0; a < border.size(); ++a) coupling[a] = modulus(border[a], j);
    const Eigen::VectorXd angle = -own.ldlt().solve(coupling);
    for (std::size_t a = 0; a < border.size(); ++a)
      curvature[j] += angle[a] * PlaneTensor(curvature[border[a]]);
  }
  for (const int i : border) curvature[i] = {};
}

}  // namespace

PlaneTensor& PlaneTensor::operator+=(const PlaneTensor& other) {
  xx += other.xx;
  xy += other.xy;
  yy += other.yy;
  return *this;
}

PlaneTensor PlateModuli::response(const PlaneTensor& strain) const {
  PlaneTensor result = (stiffness * (1 - poisson_ratio)) * strain;
  const double spread = stiffness * poisson_ratio * strain.trace();
  result.xx += spread;
  result.yy += spread;
  return result;
}

SurfaceTensors::SurfaceTensors(const SceneBody& body, bool bends, int threads,
                               std::span<const ClampedEdge> clamped, std::span<const char> held)
    : body_(body), threads_(threads), first_around_(body.particle_count() + 1, 0) {
  for (const std::array<int, 3>& nodes : body.mesh.triangles) {
    const Vec3 side = body.rest[nodes[1]] - body.rest[nodes[0]];
    const Vec3 other = body.rest[nodes[2]] - body.rest[nodes[0]];
    const double double_area = side.cross(other).norm(), length = side.norm();
    Eigen::Matrix2d edges;
    edges << length, side.dot(other) / length, 0, double_area / length;
    triangles_.push_back({nodes, edges.inverse(), 0.5 * double_area});
    const Vec3 warp = warp_direction(body, static_cast<int>(triangles_.size()) - 1).normalized();
    triangles_.back().warp_cosine = warp.dot(side) / length;
    triangles_.back().warp_sine = warp.dot(side.cross(other).cross(side)) / (double_area * length);
    for (const int node : nodes) ++first_around_[node + 1];
  }
  for (std::size_t i = 1; i < first_around_.size(); ++i) first_around_[i] += first_around_[i - 1];
  std::vector<int> place(first_around_.begin(), first_around_.end() - 1);
  around_.resize(3 * triangles_.size());
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    for (const int node : triangles_[t].nodes) around_[place[node]++] = static_cast<int>(t);
  }
  placed_.resize(triangles_.size());
  tensors_.resize(triangles_.size());
  if (!body.material->has_isotropic_membrane()) stretch_law_ = stretch_law(*body.material);
  if (body.material->orthotropic_bending) bending_law_ = bending_law(*body.material);
  if (body.material->strain_limit) {
    unit_limit_ = materials::make_strain_limit(unit_triangle(Eigen::Matrix2d::Identity()),
                                               *body.material->strain_limit,
                                               largest_membrane_stiffness(*body.material));
  }
  // The mesh is built anew because body.mesh may lack the edges.
  if (bends) add_hinges(bsi::build_mesh(body.atlas), clamped, held);
}

// Sets the nodes beyond the clamped edges of a triangle to their ghosts. The indices of ghosts
// follow those of the particles.
void SurfaceTensors::clamp(std::span<const ClampedEdge> clamped, int triangle,
                           Hinges& hinges) const {
  for (std::size_t g = 0; g < clamped.size(); ++g) {
    if (clamped[g].triangle == triangle)
      hinges.across[clamped[g].edge] = body_.particle_count() + static_cast<int>(g);
  }
}

void SurfaceTensors::add_hinges(const bsi::Mesh& mesh, std::span<const ClampedEdge> clamped,
                                std::span<const char> held) {
  hinges_.resize(triangles_.size());
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const Triangle& triangle = triangles_[t];
    Hinges& hinges = hinges_[t];
    Nodes3 rest;
    for (int i = 0; i < 3; ++i) rest.col(i) = body_.rest[triangle.nodes[i]];
    // The x axis of the rest plane points along the edge 0 -> 1.
    const Eigen::Matrix2d edges = triangle.inverse_edges.inverse();
    const std::array<Eigen::Vector2d, 3> corners{Eigen::Vector2d::Zero(), edges.col(0),
                                                 edges.col(1)};
    std::array<bool, 3> has_angle{};
    for (int i = 0; i < 3; ++i) {
      const bsi::Edge& edge = mesh.edges[mesh.triangle_edges[t][i]];
      const Eigen::Vector2d along = corners[(i + 2) % 3] - corners[(i + 1) % 3];
      const double length = along.norm(), height = 2 * triangle.area / length;
      const Eigen::Vector2d outward(along.y() / length, -along.x() / length);
      hinges.curvature[i] = plane_tensor(outward * outward.transpose() / height);
      if (edge.triangle[1] >= 0)
        hinges.across[i] = edge.opposite[edge.triangle[0] == static_cast<int>(t) ? 1 : 0];
    }
    clamp(clamped, static_cast<int>(t), hinges);
    for (int i = 0; i < 3; ++i) has_angle[i] = hinges.across[i] >= 0;
    if (bending_law_) {
      const Mat3 map = materials::bending_map(rest, warp_direction(body_, static_cast<int>(t)),
                                              has_angle, flat_bending_moduli(*body_.material))
                           .map;
      for (int i = 0; i < 3; ++i)
        hinges.curvature[i] = turned({map(0, i), 0.5 * map(2, i), map(1, i)}, triangle.warp_cosine,
                                     triangle.warp_sine);
    } else {
      complete(rest, body_.material->poisson_ratio, has_angle, hinges.curvature);
    }
    for (int i = 0; i < 3; ++i) {
      const bool is_ghost = hinges.across[i] >= body_.particle_count();
      if (has_angle[i] && !is_ghost)
        hinges.rest_angle[i] = materials::hinge_angle(hinge_nodes(t, i, body_.rest));
      // Beyond a clamp the surface continues as its mirror image, so the edge bends by twice the
      // angle between the triangle and the held tangent plane.
      if (is_ghost) hinges.curvature[i] = 2.0 * hinges.curvature[i];
      if (!held.empty() && held[t] != 0) hinges.curvature[i] = {};
    }
  }
}

// Returns the positions or velocities `x` of the four nodes of a hinge, in the order of
// materials/hinge.h. The hinge is at the triangle's edge opposite node i.
Nodes4 SurfaceTensors::hinge_nodes(std::size_t triangle, int i, std::span<const Vec3> x) const {
  const auto& nodes = triangles_[triangle].nodes;
  Nodes4 result;
  result.col(0) = x[nodes[(i + 1) % 3]];
  result.col(1) = x[nodes[(i + 2) % 3]];
  result.col(2) = x[nodes[i]];
  result.col(3) = x[hinges_[triangle].across[i]];
  return result;
}

void SurfaceTensors::place(std::span<const Vec3> position, std::span<const Vec3> velocity,
                           const DampingTimes& damping, std::vector<materials::Crease> creases) {
  damping_ = damping;
  creases_ = std::move(creases);
  position_.assign(position.begin(), position.end());
  velocity_.assign(velocity.begin(), velocity.end());
  parallel_chunks(static_cast<int>(triangles_.size()), threads_, [&](int first, int last) {
    for (int t = first; t < last; ++t) place_triangle(t);
  });
}

void SurfaceTensors::place_triangle(int t) {
  const Triangle& triangle = triangles_[t];
  const auto& [a, b, c] = triangle.nodes;
  const Vec3 side = position_[b] - position_[a], other = position_[c] - position_[a];
  Placed& placed = placed_[t];
  placed.along = side.normalized();
  placed.normal = side.cross(other).normalized();
  placed.across = placed.normal.cross(placed.along);
  const auto in_plane = [&](const Vec3& one, const Vec3& two) {
    Eigen::Matrix2d edges;
    edges << placed.along.dot(one), placed.along.dot(two), placed.across.dot(one),
        placed.across.dot(two);
    return Eigen::Matrix2d(edges * triangle.inverse_edges);
  };
  placed.gradient = in_plane(side, other);
  placed.rate = in_plane(velocity_[b] - velocity_[a], velocity_[c] - velocity_[a]);
}

PlateModuli SurfaceTensors::membrane_moduli() const {
  const MaterialCase& material = *body_.material;
  if (material.membrane != MembraneModel::triangles) return {0, material.poisson_ratio};
  const double nu = material.poisson_ratio;
  return {material.membrane_stiffness / (1 - nu * nu), nu};
}

// Returns the Green strain in the rest plane, plus `damping_time` (s) times its rate.
PlaneTensor SurfaceTensors::strain_of(int t, double damping_time) const {
  const Placed& placed = placed_[t];
  const Eigen::Matrix2d& f = placed.gradient;
  Eigen::Matrix2d strain = 0.5 * (f.transpose() * f - Eigen::Matrix2d::Identity());
  if (damping_time > 0) {
    const Eigen::Matrix2d rate = f.transpose() * placed.rate;
    strain += 0.5 * damping_time * (rate + rate.transpose());
  }
  return plane_tensor(strain);
}

// Returns the change of curvature since rest in the rest plane, plus `damping_time` (s) times its
// rate.
PlaneTensor SurfaceTensors::curvature_of(int t, double damping_time) const {
  const Hinges& hinges = hinges_[t];
  PlaneTensor sum;
  for (int i = 0; i < 3; ++i) {
    if (hinges.across[i] < 0) continue;
    const auto vectors = materials::hinge_vectors(hinge_nodes(t, i, position_));
    double angle = materials::hinge_angle(vectors) - hinges.rest_angle[i];
    if (damping_time > 0) {
      const Nodes4 gradient = materials::hinge_gradient(vectors);
      angle += damping_time * gradient.cwiseProduct(hinge_nodes(t, i, velocity_)).sum();
    }
    sum += angle * hinges.curvature[i];
  }
  return sum;
}

PlaneTensor SurfaceTensors::crease_of(int t) const {
  PlaneTensor sum;
  if (creases_.empty()) return sum;
  const Hinges& hinges = hinges_[t];
  for (int i = 0; i < 3; ++i) {
    // At a clamp, `curvature` is that of half the angle by which the triangle bends.
    const bool is_ghost = hinges.across[i] >= body_.particle_count();
    sum += ((is_ghost ? 0.5 : 1.0) * creases_[t].angles[i]) * hinges.curvature[i];
  }
  return sum;
}

PlaneTensor SurfaceTensors::elastic_curvature_of(int t, double damping_time) const {
  PlaneTensor curvature = curvature_of(t, damping_time);
  curvature += -1.0 * crease_of(t);
  return curvature;
}

// Returns a tensor of the rest plane in the present axes of the triangle. It is rotated by R of
// F = R U, but not stretched.
PlaneTensor SurfaceTensors::in_space(int t, const PlaneTensor& at_rest) const {
  const auto [cosine, sine] = rotation_of(placed_[t].gradient);
  return turned(at_rest, cosine, sine);
}

// Returns the stress dw/de plus the viscous stress, in the axes of the triangle. The viscous stress
// is `damping_time` (s) times the law's moduli times the strain rate. The strain rate (1/s) is
// moved - strain, because `moved` is the strain after one second at this rate.
template <class Law>
PlaneTensor SurfaceTensors::stress_by(const Law& law, int t, const PlaneTensor& strain,
                                      const PlaneTensor& moved, double damping_time) const {
  const Triangle& triangle = triangles_[t];
  const auto along_warp = [&](const PlaneTensor& tensor) {
    const PlaneTensor own = turned(tensor, triangle.warp_cosine, -triangle.warp_sine);
    return std::array{own.xx, own.yy, 2 * own.xy};
  };
  const std::array<double, 3> e = along_warp(strain);
  std::array<double, 3> stress = materials::energy_jet<1>(law, e).first;
  if (damping_time > 0) {
    const std::array<double, 3> rate = along_warp(difference(moved, strain));
    const Vec3 viscous = law.semi_definite_moduli(e) * Vec3(rate[0], rate[1], rate[2]);
    for (int i = 0; i < 3; ++i) stress[i] += damping_time * viscous[i];
  }
  return turned({stress[0], stress[2], stress[1]}, triangle.warp_cosine, triangle.warp_sine);
}

template <class Law>
double SurfaceTensors::energy_by(const Law& law, int t, const PlaneTensor& strain) const {
  const PlaneTensor own = turned(strain, triangles_[t].warp_cosine, -triangles_[t].warp_sine);
  return law.energy(std::array{own.xx, own.yy, 2 * own.xy});
}

PlaneTensor SurfaceTensors::membrane_tension_of(int t) const {
  if (!stretch_law_) return membrane_moduli().response(strain_of(t, damping_.membrane));
  return std::visit(
      [&](const auto& law) {
        return stress_by(law, t, strain_of(t, 0), strain_of(t, 1), damping_.membrane);
      },
      *stretch_law_);
}

// The energy per rest area is that of the unit triangle, divided by its area of 1/2, and the
// tension is twice its derivative by F^T F.
PlaneTensor SurfaceTensors::limit_tension_of(int t) const {
  if (!unit_limit_) return {};
  const materials::LimitDerivatives<double> derivatives(*unit_limit_,
                                                        unit_triangle(placed_[t].gradient));
  const auto& [xx, xy, yy] = derivatives.tension;
  return (4 * unit_limit_->stiffness) * PlaneTensor{xx, xy, yy};
}

PlaneTensor SurfaceTensors::tension_of(int t) const {
  PlaneTensor tension = membrane_tension_of(t);
  tension += limit_tension_of(t);
  return tension;
}

PlaneTensor SurfaceTensors::moment_of(int t) const {
  if (!bending_law_) {
    const PlateModuli moduli{body_.material->bending_stiffness, body_.material->poisson_ratio};
    return moduli.response(elastic_curvature_of(t, damping_.bending));
  }
  return std::visit(
      [&](const auto& law) {
        return stress_by(law, t, curvature_of(t, 0), curvature_of(t, 1), damping_.bending);
      },
      *bending_law_);
}

double SurfaceTensors::stretch_energy_of(int t) const {
  const PlaneTensor strain = strain_of(t, 0);
  if (!stretch_law_) return 0.5 * product(strain, membrane_moduli().response(strain));
  return std::visit([&](const auto& law) { return energy_by(law, t, strain); }, *stretch_law_);
}

double SurfaceTensors::bending_energy_of(int t) const {
  const PlaneTensor curvature = elastic_curvature_of(t, 0);
  if (bending_law_)
    return std::visit([&](const auto& law) { return energy_by(law, t, curvature); }, *bending_law_);
  const PlateModuli moduli{body_.material->bending_stiffness, body_.material->poisson_ratio};
  return 0.5 * product(curvature, moduli.response(curvature));
}

void SurfaceTensors::find_strain(PrincipalValues& values) const {
  average([&](int t) { return in_space(t, strain_of(t, 0)); }, values);
}

void SurfaceTensors::find_stress(PrincipalValues& values) const {
  average(
      [&](int t) {
        const Eigen::Matrix2d& f = placed_[t].gradient;
        const Eigen::Matrix2d second_piola = matrix_of(tension_of(t));
        return plane_tensor(f * second_piola * f.transpose() / f.determinant());
      },
      values);
}

void SurfaceTensors::find_curvature(PrincipalValues& values) const {
  average([&](int t) { return in_space(t, curvature_of(t, 0)); }, values);
}

void SurfaceTensors::find_crease(PrincipalValues& values) const {
  average([&](int t) { return in_space(t, crease_of(t)); }, values);
}

void SurfaceTensors::find_moment(PrincipalValues& values) const {
  average([&](int t) { return in_space(t, moment_of(t)); }, values);
}

double SurfaceTensors::elastic_energy() const {
  const bool bends = body_.material->resists_bending();
  return parallel_sum(static_cast<int>(triangles_.size()), threads_, [&](int first, int last) {
    double sum = 0;
    for (int t = first; t < last; ++t) {
      const double density = stretch_energy_of(t) + (bends ? bending_energy_of(t) : 0);
      sum += triangles_[t].area * density;
    }
    return sum;
  });
}

// Averages the tensors of the triangles around each particle, and finds the principal values.
// tensor_of(triangle) returns a triangle's tensor in the present axes of its plane.
template <class TensorOf>
void SurfaceTensors::average(const TensorOf& tensor_of, PrincipalValues& values) const {
  parallel_chunks(static_cast<int>(triangles_.size()), threads_, [&](int first, int last) {
    for (int t = first; t < last; ++t) tensors_[t] = tensor_of(t);
  });
  const int count = body_.particle_count();
  values.major.resize(count);
  values.minor.resize(count);
  values.direction.resize(3 * static_cast<std::size_t>(count));
  parallel_chunks(count, threads_, [&](int first, int last) {
    for (int particle = first; particle < last; ++particle) average_at(particle, values);
  });
}

Vec3 SurfaceTensors::normal_at(std::span<const int> around) const {
  Vec3 sum = Vec3::Zero();
  for (const int t : around) sum += triangles_[t].area * placed_[t].normal;
  const double size = sum.norm();
  // The normals of triangles that are folded onto each other may cancel.
  if (size <= 1e-12 * triangles_[around[0]].area) return placed_[around[0]].normal;
  return sum / size;
}

void SurfaceTensors::average_at(int particle, PrincipalValues& values) const {
  const auto around = std::span(around_).subspan(
      first_around_[particle], first_around_[particle + 1] - first_around_[particle]);
  const Vec3 normal = normal_at(around);
  const Placed& one = placed_[around[0]];
  const Vec3 along = turned_into(one.normal, normal, one.along), across = normal.cross(along);
  PlaneTensor sum;
  double area = 0;
  for (const int t : around) {
    const Vec3 axis = turned_into(placed_[t].normal, normal, placed_[t].along);
    sum += triangles_[t].area * turned(tensors_[t], axis.dot(along), axis.dot(across));
    area += triangles_[t].area;
  }
  const PlaneTensor mean = (1 / area) * sum;
  const double centre = 0.5 * mean.trace(), half = 0.5 * (mean.xx - mean.yy);
  const double radius = std::hypot(half, mean.xy), angle = 0.5 * std::atan2(mean.xy, half);
  values.major[particle] = centre + radius;
  values.minor[particle] = centre - radius;
  const Vec3 direction =
      with_sign((std::cos(angle) * along + std::sin(angle) * across).normalized());
  for (int i = 0; i < 3; ++i)
    values.direction[3 * static_cast<std::size_t>(particle) + i] = direction[i];
}

}  // namespace weft::sim
