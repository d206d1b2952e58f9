#include "materials/drag.h"

#include "sim/forces/force_arrays.h"
#include "sim/forces/stencil_array.h"
#include "sim/scene/scene.h"

namespace weft::sim {

namespace {

using materials::Drag;
using materials::lane_count;
using materials::Lanes;
using materials::Mat3Of;
using materials::NodesOf;
using materials::Vec3Of;

using DragBatch = materials::DragOf<Lanes>;

// Eight triangles a batch; what is left of the last has no drag.
std::vector<DragBatch> packed(const std::vector<Drag>& drags) {
  std::vector<DragBatch> batches((drags.size() + lane_count - 1) / lane_count);
  for (std::size_t i = 0; i < drags.size(); ++i) {
    batches[i / lane_count].normal.values[i % lane_count] = drags[i].normal;
    batches[i / lane_count].tangential.values[i % lane_count] = drags[i].tangential;
  }
  return batches;
}

class DragForce final : public Force {
 public:
  DragForce(std::vector<std::array<int, 3>> triangles, const std::vector<Drag>& drags,
            const Vec3& wind, int particle_count)
      : triangles_(std::move(triangles), particle_count),
        drags_(packed(drags)),
        wind_(wind.cast<Lanes>()) {}

  std::string_view name() const override { return "drag"; }
  // Drag stores nothing.
  double energy(const Kinematics&, int) override { return 0; }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) override {
    triangles_.for_each_batch(threads, [&](int first) {
      const Vec3Of<Lanes> third =
          (1.0 / 3) * materials::drag_force(drags_[first / lane_count],
                                            triangles_.gather(first, state.position),
                                            triangles_.gather(first, state.velocity), wind_);
      triangles_.scatter(first, NodesOf<Lanes, 3>(third.replicate<1, 3>()), force);
    });
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    triangles_.add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) override { triangles_.attach(pattern); }

  void add_derivatives(const Kinematics& state, const Derivatives& into, Definiteness,
                       int threads) override {
    triangles_.for_each_batch(threads, [&](int first) {
      materials::StencilMatrix<Lanes, 3> blocks, joined;
      blocks.blocks.fill((1.0 / 9) *
                         materials::drag_damping(drags_[first / lane_count],
                                                 triangles_.gather(first, state.position),
                                                 triangles_.gather(first, state.velocity), wind_));
      joined.blocks.fill(Mat3Of<Lanes>::Zero());
      triangles_.scatter_damping(first, blocks, into, joined);
      if (into.is_joined()) triangles_.scatter(first, joined, into.stiffness);
    });
  }

 private:
  StencilArray<3> triangles_;
  std::vector<DragBatch> drags_;
  Vec3Of<Lanes> wind_;
};

}  // namespace

std::unique_ptr<Force> make_drag_force(const Scene& scene) {
  std::vector<std::array<int, 3>> triangles;
  std::vector<Drag> drags;
  const double density = scene.source.world.air_density;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const SceneBody& body = scene.bodies[b];
    const Drag drag{density * body.material->normal_drag, density * body.material->tangential_drag};
    if (drag.normal == 0 && drag.tangential == 0) continue;
    for (const std::array<int, 3>& t : body.mesh.triangles) {
      triangles.push_back(
          {t[0] + body.first_particle, t[1] + body.first_particle, t[2] + body.first_particle});
      drags.push_back(drag);
    }
  }
  if (triangles.empty()) return nullptr;
  return std::make_unique<DragForce>(std::move(triangles), drags, scene.source.world.wind,
                                     scene.dynamic_particles);
}

}  // namespace weft::sim
