// Bending of the triangles on the two sides of seams (sim/scene/seams.h).
#include <algorithm>

#include "sim/forces/border_bending.h"
#include "sim/forces/force_arrays.h"

namespace weft::sim {

namespace {

// Adds the triangles of a body at seams, except those whose bending a clamp has taken over.
void add_sewn_body(const Scene& scene, int b, BorderTriangles& all) {
  const std::vector<const SeamFold*> folds = seam_folds_of(scene, b);
  if (folds.empty()) return;
  const SceneBody& body = scene.bodies[b];
  const std::vector<char> at_clamps = triangles_at_clamps(scene, b);
  const std::size_t first = all.triangles.size();
  const bsi::Mesh mesh = bsi::build_mesh(body.atlas);
  for (std::size_t f = 0; f < folds.size(); ++f) {
    const int index = folds[f]->triangle;
    const bool again = f > 0 && folds[f - 1]->triangle == index;
    if (again || (!at_clamps.empty() && at_clamps[index] != 0)) continue;
    BorderTriangle triangle = border_triangle(scene, b, mesh, index);
    join_folds(scene, triangle, all.ghosts);
    find_laws(scene, mesh, triangle);
    all.triangles.push_back(triangle);
  }
  const Varying<double> damping = body.material->bending_damping_time();
  all.damping_times.append(static_cast<int>(all.triangles.size() - first), damping);
  all.is_damped |= !damping.is_zero();
}

}  // namespace

// While all sewn bodies sleep, the force exists without triangles: the energies of a run keep their
// names.
std::unique_ptr<Force> make_seam_bending(const Scene& scene) {
  const bool bends =
      std::ranges::any_of(scene.seams, [](const Seam& seam) { return !seam.folds.empty(); });
  if (!bends) return nullptr;
  BorderTriangles all;
  for (int b = 0; b < scene.dynamic_bodies; ++b) add_sewn_body(scene, b, all);
  return make_border_bending("seam_bending", std::move(all), scene);
}

}  // namespace weft::sim
