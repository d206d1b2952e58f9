#include "sim/contact/pair_friction.h"

#include <algorithm>
#include <string>

namespace weft::sim {

namespace {

std::string material_of(const Scene& scene, const SceneBody& body) {
  const auto& obstacles = scene.source.obstacle;
  const auto obstacle = std::ranges::find(obstacles, body.name, &ObstacleCase::name);
  if (obstacle != obstacles.end()) return obstacle->material;
  return body.material == nullptr ? "" : body.material->name;
}

// Returns the bodies that have a name, or else the bodies whose material has it.
std::vector<int> bodies_of(const Scene& scene, const std::string& name, bool by_material) {
  std::vector<int> result;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const SceneBody& body = scene.bodies[b];
    if ((by_material ? material_of(scene, body) : body.name) == name)
      result.push_back(static_cast<int>(b));
  }
  return result;
}

}  // namespace

PairFriction::PairFriction(const Scene& scene)
    : scene_(scene),
      bodies_(scene.bodies.size()),
      default_(scene.source.contact.friction.constant_or_zero()) {
  const std::vector<ContactPairCase>& pairs = scene.source.contact.pair;
  if (pairs.empty()) return;
  rule_.assign(static_cast<std::size_t>(scene.dynamic_bodies) * bodies_, -1);
  for (const ContactPairCase& pair : pairs) friction_.push_back(pair.friction.value_or(0));
  // Names come last, so that they replace what materials have set. No name is a body's and a
  // material's at once, so a pair finds nothing in one of the two rounds.
  for (const bool by_material : {true, false}) {
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      apply(static_cast<int>(i), bodies_of(scene, pairs[i].between[0], by_material),
            bodies_of(scene, pairs[i].between[1], by_material));
    }
  }
  for (const int rule : rule_) {
    if (rule >= 0) largest_ = std::max(largest_, friction_[rule]);
  }
}

// Lets a rule hold for all pairs of one of the `first` and one of the `second` bodies that may
// touch.
void PairFriction::apply(int rule, const std::vector<int>& first, const std::vector<int>& second) {
  for (const int a : first) {
    for (const int b : second) {
      if (a == b && !scene_.bodies[a].self_contact) continue;
      if (a < scene_.dynamic_bodies) rule_[entry(a, b)] = rule;
      if (b < scene_.dynamic_bodies) rule_[entry(b, a)] = rule;
    }
  }
}

std::vector<int> PairFriction::uses() const {
  std::vector<int> result(friction_.size(), 0);
  for (int a = 0; a < scene_.dynamic_bodies && !rule_.empty(); ++a) {
    for (int b = a; b < static_cast<int>(bodies_); ++b) {
      const int rule = rule_[entry(a, b)];
      if (rule >= 0) ++result[rule];
    }
  }
  return result;
}

}  // namespace weft::sim
