// Drag of the wind on the curved surfaces of spline shells (materials/drag.h).
#include <algorithm>

#include "materials/drag.h"
#include "sim/forces/force_arrays.h"
#include "sim/forces/stencil_array.h"
#include "sim/scene/scene.h"
#include "sim/scene/spline_surface.h"
#include "sim/scene/time_curve.h"

namespace weft::sim {

namespace {

// The density of the air (kg/m^3) and the drag coefficients of a body.
struct AirOnBody {
  TimeCurve<double> density, normal, tangential;
  materials::Drag now;  // density times coefficients at the time of set_time(), kg/m^3
};

// The elements of all dynamic shells of one degree that have drag. Each element has 2 x 2 Gauss
// points.
template <int degree>
class DragElements {
 public:
  static constexpr int nodes = (degree + 1) * (degree + 1);

  void add_body(const SceneBody& body, int air) {
    const auto& patches = body.spline->patches();
    for (int p = 0; p < static_cast<int>(patches.size()); ++p) {
      const auto& [u, v] = patches[p];
      for (int element = 0; element < u.elements() * v.elements(); ++element)
        add_element(body, p, element % u.elements(), element / u.elements(), air);
    }
  }
  // Must be called once, after the last add_body().
  void finish(int particle_count) { elements_ = StencilArray<nodes>(stencils_, particle_count); }
  bool is_empty() const { return stencils_.empty(); }

  void add_forces(std::span<const AirOnBody> air, const Vec3& wind, const Kinematics& state,
                  std::span<Vec3> force, int threads) const {
    elements_.for_each(threads, [&](int e) {
      visit_flows(e, wind, state, [&](const Values& value, const Flow& flow) {
        const Vec3 whole = materials::drag_force(air[air_[e]].now, flow);
        for (int i = 0; i < nodes; ++i) force[stencils_[e][i]] += value[i] * whole;
      });
    });
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const {
    elements_.add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) { elements_.attach(pattern); }

  void add_derivatives(std::span<const AirOnBody> air, const Vec3& wind, const Kinematics& state,
                       const Derivatives& into, int threads) const {
    const double scale = into.is_joined() ? into.inverse_gamma : 1;
    elements_.for_each(threads, [&](int e) {
      materials::StencilMatrix<double, nodes> blocks;
      blocks.blocks.fill(Mat3::Zero());
      visit_flows(e, wind, state, [&](const Values& value, const Flow& flow) {
        const Mat3 damping = materials::drag_damping(air[air_[e]].now, flow);
        for (int a = 0; a < nodes; ++a) {
          for (int b = a; b < nodes; ++b) blocks(a, b) += (scale * value[a] * value[b]) * damping;
        }
        if (into.is_joined()) add_product(e, value, damping, into);
      });
      elements_.add_blocks(e, blocks, into.is_joined() ? into.stiffness : *into.damping);
    });
  }

 private:
  using Stencil = std::array<int, nodes>;
  using Values = std::array<double, nodes>;
  using Flow = materials::FlowOf<double>;
  static constexpr int points_per_element = 4;

  struct Point {
    double weight = 0;  // weight of quadrature: an area in parameter space
    Values value{}, slope_u{}, slope_v{};
  };

  void add_element(const SceneBody& body, int patch, int element_u, int element_v, int air) {
    const std::vector<int> control =
        body.spline->control_points(body.atlas, patch, element_u, element_v);
    Stencil& stencil = stencils_.emplace_back();
    for (int i = 0; i < nodes; ++i) stencil[i] = body.first_particle + control[i];
    air_.push_back(air);
    constexpr std::array<double, 2> gauss{0.21132486540518712, 0.78867513459481288};
    for (const double at_v : gauss) {
      for (const double at_u : gauss) {
        const SplineSurface::Point from =
            body.spline->at(body.atlas, {patch, element_u + at_u, element_v + at_v});
        Point& point = points_.emplace_back(Point{.weight = 0.25});
        std::ranges::copy(from.value, point.value.begin());
        std::ranges::copy(from.slope_u, point.slope_u.begin());
        std::ranges::copy(from.slope_v, point.slope_v.begin());
      }
    }
  }

  // Calls visit(values of the basis functions, flow) for each Gauss point of element e.
  template <class Visit>
  void visit_flows(int e, const Vec3& wind, const Kinematics& state, const Visit& visit) const {
    const Stencil& stencil = stencils_[e];
    for (int p = points_per_element * e; p < points_per_element * (e + 1); ++p) {
      const Point& point = points_[p];
      Vec3 along_u = Vec3::Zero(), along_v = Vec3::Zero(), relative = wind;
      for (int i = 0; i < nodes; ++i) {
        along_u += point.slope_u[i] * state.position[stencil[i]];
        along_v += point.slope_v[i] * state.position[stencil[i]];
        relative -= point.value[i] * state.velocity[stencil[i]];
      }
      const Vec3 normal = along_u.cross(along_v);
      const double area = normal.norm();
      visit(point.value, Flow{.relative_wind = relative,
                              .normal = area > 0 ? Vec3(normal / area) : normal,
                              .area = point.weight * area});
    }
  }

  void add_product(int e, const Values& value, const Mat3& damping, const Derivatives& into) const {
    Vec3 along = Vec3::Zero();
    for (int i = 0; i < nodes; ++i) along += value[i] * into.along[stencils_[e][i]];
    const Vec3 product = damping * along;
    for (int i = 0; i < nodes; ++i) into.product[stencils_[e][i]] += value[i] * product;
  }

  std::vector<Stencil> stencils_;
  std::vector<int> air_;  // by element: index into the list of AirOnBody
  std::vector<Point> points_;
  StencilArray<nodes> elements_;
};

class ShellDragForce final : public Force {
 public:
  explicit ShellDragForce(const Scene& scene)
      : wind_in_time_(scene.source.world.wind), wind_(scene.source.world.wind.constant_or_zero()) {
    const Varying<double>& density = scene.source.world.air_density;
    for (int b = 0; b < scene.dynamic_bodies; ++b) {
      const SceneBody& body = scene.bodies[b];
      const MaterialCase& material = *body.material;
      const bool is_smooth = material.normal_drag.is_zero() && material.tangential_drag.is_zero();
      if (!body.spline || density.is_zero() || is_smooth) continue;
      const int air = static_cast<int>(air_.size());
      air_.push_back({TimeCurve<double>(density),
                      TimeCurve<double>(material.normal_drag),
                      TimeCurve<double>(material.tangential_drag),
                      {}});
      if (body.spline->degree() == 2) quadratic_.add_body(body, air);
      if (body.spline->degree() == 3) cubic_.add_body(body, air);
    }
    visit([&](auto& elements) { elements.finish(scene.dynamic_particles); });
    set_time({});
  }

  bool is_empty() const { return air_.empty(); }
  std::string_view name() const override { return "shell_drag"; }
  bool has_damping() const override { return true; }
  bool is_external() const override { return true; }
  bool varies() const override {
    return wind_in_time_.varies() || std::ranges::any_of(air_, [](const AirOnBody& air) {
             return air.density.varies() || air.normal.varies() || air.tangential.varies();
           });
  }
  void set_time(const Instant& now) override {
    wind_ = wind_in_time_.at(now);
    for (AirOnBody& air : air_) {
      const double density = air.density.at(now);
      air.now = {density * air.normal.at(now), density * air.tangential.at(now)};
    }
  }
  double evaluation_work() const override { return 0.6; }
  // Drag stores no energy.
  double energy(const Kinematics&, int) override { return 0; }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) override {
    visit([&](auto& elements) { elements.add_forces(air_, wind_, state, force, threads); });
  }
  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    quadratic_.add_couplings(neighbours);
    cubic_.add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) override {
    visit([&](auto& elements) { elements.attach(pattern); });
  }
  void add_derivatives(const Kinematics& state, const Derivatives& into, Definiteness,
                       int threads) override {
    visit([&](auto& elements) { elements.add_derivatives(air_, wind_, state, into, threads); });
  }

 private:
  template <class Visit>
  void visit(const Visit& with) {
    if (!quadratic_.is_empty()) with(quadratic_);
    if (!cubic_.is_empty()) with(cubic_);
  }

  TimeCurve<Vec3> wind_in_time_;
  Vec3 wind_;                   // m/s, at the time of set_time()
  std::vector<AirOnBody> air_;  // one entry per body with drag
  DragElements<2> quadratic_;
  DragElements<3> cubic_;
};

}  // namespace

std::unique_ptr<Force> make_shell_drag_force(const Scene& scene) {
  auto force = std::make_unique<ShellDragForce>(scene);
  if (force->is_empty()) return nullptr;
  return force;
}

}  // namespace weft::sim
