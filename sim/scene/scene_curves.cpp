#include "sim/scene/scene_curves.h"

#include <algorithm>

namespace weft::sim {

namespace {

bool has_drag(const MaterialCase& material) {
  return !material.normal_drag.is_zero() || !material.tangential_drag.is_zero();
}

// Damping (1/s) from which a body that falls may count as at rest: it falls by less than 1 mm/s.
constexpr double brake = 1e4;

class CurveFinder {
 public:
  explicit CurveFinder(const Case& source) : case_(source) {}

  std::vector<SceneCurve> find() {
    if (SceneCurve* gravity = add("world.gravity", case_.world.gravity)) gravity->moves_all = true;
    note_drag(add("world.wind", case_.world.wind));
    note_drag(add("world.air_density", case_.world.air_density));
    if (SceneCurve* friction = add("contact.friction", case_.contact.friction)) {
      // A scene of impulses has contact off, since the method finds its contacts itself.
      const bool acts = case_.contact.enabled || case_.time.method == TimeMethod::impulses;
      friction->moves_all = acts;
      if (!acts) friction->unused = "contact.enabled is false";
    }
    for (const MaterialCase& material : case_.material) add_material(material);
    for (std::size_t i = 0; i < case_.load.size(); ++i) add_load(case_.load[i], i);
    return std::move(curves_);
  }

 private:
  template <class Value>
  SceneCurve* add(const std::string& key, const Varying<Value>& source) {
    if (!source.varies()) return nullptr;
    curves_.push_back({key, &source, times_of(source), {}, false, {}});
    return &curves_.back();
  }

  bool is_used(const MaterialCase& material) const {
    return std::ranges::any_of(
        case_.body, [&](const BodyCase& body) { return body.material == material.name; });
  }

  void note_drag(SceneCurve* air) const {
    if (air == nullptr) return;
    for (const MaterialCase& material : case_.material) {
      if (is_used(material) && has_drag(material) && !case_.world.air_density.is_zero())
        air->moves_materials.push_back(material.name);
    }
    air->moves_all = !case_.world.air_density.is_zero() &&
                     std::ranges::any_of(case_.particles, [](const ParticlesCase& group) {
                       return group.drag_coefficient > 0;
                     });
    if (air->moves_materials.empty() && !air->moves_all) air->unused = "nothing has drag";
  }

  void add_load(const LoadCase& load, std::size_t number) {
    const std::string path = "load." + std::to_string(number) + '.';
    const auto body = std::ranges::find(case_.body, load.body, &BodyCase::name);
    const auto moves = [&](SceneCurve* curve) {
      if (curve != nullptr) curve->moves_materials.push_back(body->material);
    };
    moves(add(path + "force", load.force));
    moves(add(path + "pressure", load.pressure));
    moves(add(path + "moment", load.moment));
  }

  void add_material(const MaterialCase& material) {
    const std::size_t first = curves_.size();
    const std::string path = "material." + material.name + '.';
    SceneCurve* damping = add(path + "mass_damping", material.mass_damping);
    if (damping != nullptr && std::ranges::max(material.mass_damping.curve()->values) > brake)
      damping->moves_materials.push_back(material.name);
    add(path + "stiffness_damping", material.stiffness_damping);
    SceneCurve* bending = add(path + "bending_damping", material.bending_damping);
    if (bending != nullptr && !material.resists_bending())
      bending->unused = "its bending_stiffness is 0";
    note_air(add(path + "normal_drag", material.normal_drag), material);
    note_air(add(path + "tangential_drag", material.tangential_drag), material);
    if (is_used(material)) return;
    for (std::size_t i = first; i < curves_.size(); ++i)
      curves_[i].unused = "no body is made of it";
  }

  void note_air(SceneCurve* drag, const MaterialCase& material) const {
    if (drag == nullptr) return;
    drag->moves_materials = {material.name};
    if (case_.world.air_density.is_zero()) drag->unused = "world.air_density is 0";
  }

  const Case& case_;
  std::vector<SceneCurve> curves_;
};

}  // namespace

std::vector<SceneCurve> find_curves(const Case& source) { return CurveFinder(source).find(); }

SceneCurves::SceneCurves(const Case& source) : curves_(find_curves(source)) {
  std::erase_if(curves_, [](const SceneCurve& curve) { return !curve.unused.empty(); });
}

std::vector<MotionEvent> SceneCurves::events() const {
  std::vector<MotionEvent> events;
  for (const SceneCurve& curve : curves_)
    events.insert(events.end(), curve.times.events.begin(), curve.times.events.end());
  std::ranges::sort(events, {}, &MotionEvent::time);
  return events;
}

double SceneCurves::longest_step() const {
  double longest = std::numeric_limits<double>::infinity();
  for (const SceneCurve& curve : curves_) longest = std::min(longest, curve.times.longest_step);
  return longest;
}

bool SceneCurves::may_move(const std::string& material, double from, double to) const {
  return std::ranges::any_of(curves_, [&](const SceneCurve& curve) {
    const bool acts = curve.moves_all || std::ranges::find(curve.moves_materials, material) !=
                                             curve.moves_materials.end();
    return acts && curve.times.changes_between(from, to);
  });
}

}  // namespace weft::sim
