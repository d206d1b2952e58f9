#include "materials/drag.h"

#include "sim/forces/force_arrays.h"
#include "sim/forces/quads.h"
#include "sim/forces/stencil_array.h"
#include "sim/forces/varying_numbers.h"
#include "sim/scene/scene.h"

namespace weft::sim {

namespace {

using materials::DragOf;
using materials::Lanes;
using materials::Mat3Of;
using materials::NodesOf;
using materials::Vec3Of;

// Density of the air times the drag coefficients, by quad, kg/m^3.
struct DragNumbers {
  VaryingNumbers normal, tangential;
};

class DragForce final : public Force {
 public:
  DragForce(const std::vector<Quad>& quads, DragNumbers drags, const Varying<Vec3>& wind,
            int particle_count)
      : quads_(quads, particle_count),
        drags_(std::move(drags)),
        wind_in_time_(wind),
        normal_(drags_.normal.numbers()),
        tangential_(drags_.tangential.numbers()),
        wind_(wind.constant_or_zero().cast<Lanes>()) {}

  std::string_view name() const override { return "drag"; }
  bool has_damping() const override { return true; }
  bool is_external() const override { return true; }
  bool varies() const override {
    return wind_in_time_.varies() || drags_.normal.varies() || drags_.tangential.varies();
  }
  void set_time(const Instant& now) override {
    wind_ = wind_in_time_.at(now).cast<Lanes>();
    drags_.normal.update(now, normal_);
    drags_.tangential.update(now, tangential_);
  }
  double evaluation_work() const override { return 0.6; }
  // Drag stores no energy.
  double energy(const Kinematics&, int) override { return 0; }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) override {
    quads_.for_each_batch(threads, [&](int first) { add_batch(first, state, force); });
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    quads_.add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) override { quads_.attach(pattern); }

  void add_derivatives(const Kinematics& state, const Derivatives& into, Definiteness,
                       int threads) override {
    quads_.for_each_batch(threads, [&](int first) { add_batch_derivatives(first, state, into); });
  }

 private:
  using Corners = NodesOf<Lanes, 4>;

  WEFT_FLATTEN void add_batch(int first, const Kinematics& state, std::span<Vec3> force) const {
    const Corners x = quads_.gather(first, state.position);
    const Corners v = quads_.gather(first, state.velocity);
    const DragOf<Lanes> drag = batch(first);
    const auto third = [&](int t) -> Vec3Of<Lanes> {
      return (1.0 / 3) *
             materials::drag_force(drag, triangle_nodes(x, t), triangle_nodes(v, t), wind_);
    };
    quads_.scatter(first, shared(third(0), third(1)), force);
  }

  WEFT_FLATTEN void add_batch_derivatives(int first, const Kinematics& state,
                                          const Derivatives& into) const {
    const Corners x = quads_.gather(first, state.position);
    const Corners v = quads_.gather(first, state.velocity);
    const Mat3Of<Lanes> one = damping_of(first, x, v, 0), other = damping_of(first, x, v, 1);
    const Mat3Of<Lanes> both = one + other;
    const double scale = into.is_joined() ? into.inverse_gamma : 1;
    quads_.scatter_blocks(first,
                          [&](auto a, auto b) -> Mat3Of<Lanes> {
                            if constexpr (a == 0) return scale * one;
                            if constexpr (b == 3) return scale * other;
                            return scale * both;
                          },
                          {into.is_joined() ? into.stiffness : *into.damping});
    if (!into.is_joined()) return;
    const Corners along = quads_.gather(first, into.along);
    const Vec3Of<Lanes> middle = along.col(1) + along.col(2);
    quads_.scatter(first, shared(one * (along.col(0) + middle), other * (along.col(3) + middle)),
                   into.product);
  }

  // Returns the block of D (N s/m) that is common to all pairs of nodes of a triangle.
  Mat3Of<Lanes> damping_of(int first, const Corners& x, const Corners& v, int triangle) const {
    return (1.0 / 9) * materials::drag_damping(batch(first), triangle_nodes(x, triangle),
                                               triangle_nodes(v, triangle), wind_);
  }

  // Returns the sum at each corner of a quad, where `one` and `other` are the vectors that the two
  // triangles add to each of their nodes.
  static Corners shared(const Vec3Of<Lanes>& one, const Vec3Of<Lanes>& other) {
    Corners corners;
    corners << one, one + other, one + other, other;
    return corners;
  }

  DragOf<Lanes> batch(int first) const { return {normal_.batch(first), tangential_.batch(first)}; }

  StencilArray<4, QuadCorners> quads_;
  DragNumbers drags_;
  TimeCurve<Vec3> wind_in_time_;
  StencilNumbers normal_, tangential_;  // kg/m^3, at the time of set_time()
  Vec3Of<Lanes> wind_;                  // m/s, at the time of set_time()
};

// Appends the density of the air times a drag coefficient of a body (kg/m^3) for `quads` quads.
void append(int quads, const Varying<double>& density, const Varying<double>& coefficient,
            VaryingNumbers& numbers) {
  const TimeCurve<double> of_air(density), of_body(coefficient);
  numbers.append(quads, of_air.varies() || of_body.varies(),
                 [=](const Instant& now) { return of_air.at(now) * of_body.at(now); });
}

}  // namespace

std::unique_ptr<Force> make_drag_force(const Scene& scene) {
  std::vector<Quad> quads;
  DragNumbers drags;
  const Varying<double>& density = scene.source.world.air_density;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const SceneBody& body = scene.bodies[b];
    const auto& normal = body.material->normal_drag;
    const auto& tangential = body.material->tangential_drag;
    if (body.spline || density.is_zero() || (normal.is_zero() && tangential.is_zero())) continue;
    for (int q = 0; q < quad_count(body); ++q) {
      for (int& corner : quads.emplace_back(quad_corners(body, q))) corner += body.first_particle;
    }
    append(quad_count(body), density, normal, drags.normal);
    append(quad_count(body), density, tangential, drags.tangential);
  }
  if (quads.empty()) return nullptr;
  return std::make_unique<DragForce>(quads, std::move(drags), scene.source.world.wind,
                                     scene.dynamic_particles);
}

}  // namespace weft::sim
