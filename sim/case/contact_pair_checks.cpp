#include "sim/case/contact_pair_checks.h"

#include <algorithm>

#include "sim/case/case_error.h"
#include "sim/case/case_schema.h"
#include "sim/case/case_text.h"

namespace weft::sim {

namespace {

class ContactPairChecker {
 public:
  ContactPairChecker(const Case& target, const Locations& locations)
      : case_(target),
        locations_(locations),
        of_particles_(target.time.method == TimeMethod::impulses) {
    for (const BodyCase& each : case_.body) partners_.push_back(each.name);
    for (const ParticlesCase& each : case_.particles) partners_.push_back(each.name);
    for (const ObstacleCase& each : case_.obstacle) partners_.push_back(each.name);
    for (const MaterialCase& each : case_.material) materials_.push_back(each.name);
  }

  void check() const {
    for (std::size_t i = 0; i < case_.contact.pair.size(); ++i) pair(i);
  }

 private:
  [[noreturn]] void fail(const std::string& path, const std::string& message,
                         const std::string& hint) const {
    throw CaseError(locations_.value(path), message, hint);
  }

  static bool contains(const std::vector<std::string>& names, const std::string& name) {
    return std::ranges::find(names, name) != names.end();
  }
  bool is_obstacle(const std::string& name) const {
    return std::ranges::find(case_.obstacle, name, &ObstacleCase::name) != case_.obstacle.end();
  }

  void pair(std::size_t number) const {
    const ContactPairCase& target = case_.contact.pair[number];
    const std::string path = join_path("contact.pair", number);
    for (std::size_t k = 0; k < 2; ++k) name(target.between[k], path, k);
    kinds(target, path);
    for (std::size_t other = 0; other < number; ++other) {
      const std::vector<std::string>& names = case_.contact.pair[other].between;
      if (!std::ranges::is_permutation(names, target.between)) continue;
      fail(join_path(path, "between"), "a second " + text_of(target), "expected each pair once");
    }
    if (!of_particles_ && !bounces(target)) return numbers_of_cloth(target, path);
    if (!target.restitution && !target.friction) {
      fail(join_path(path, "between"),
           "the " + text_of(target) + " has no \"restitution\" and no \"friction\"",
           "expected at least one of them");
    }
  }

  void name(const std::string& given, const std::string& path, std::size_t k) const {
    const std::string place = join_path(join_path(path, "between"), k);
    const bool is_partner = contains(partners_, given), is_material = contains(materials_, given);
    if (of_particles_ && !is_partner) {
      fail(place, "no particles or obstacle " + in_quotes(given),
           is_material ? "expected particles or an obstacle, not a material: particles have none"
                       : hint_for(given, partners_, "particles or obstacles"));
    }
    if (of_particles_ || is_partner != is_material) return;
    if (is_partner) {
      fail(place, in_quotes(given) + " is the name of a material and of a body or obstacle",
           "expected different names, so that it is clear which of them the pair means");
    }
    std::vector<std::string> known = partners_;
    known.insert(known.end(), materials_.begin(), materials_.end());
    fail(place, "no body, obstacle or material " + in_quotes(given),
         hint_for(given, known, "bodies, obstacles or materials"));
  }

  static std::string hint_for(const std::string& name, const std::vector<std::string>& known,
                              const std::string& kinds) {
    return known.empty() ? "expected " + kinds + ", and the case has none" : name_hint(name, known);
  }

  static std::string text_of(const ContactPairCase& target) {
    return "pair of " + in_quotes(target.between[0]) + " and " + in_quotes(target.between[1]);
  }

  bool is_particles(const std::string& name) const {
    return std::ranges::find(case_.particles, name, &ParticlesCase::name) != case_.particles.end();
  }
  // True for particles among themselves or with an obstacle, which have a restitution.
  bool bounces(const ContactPairCase& target) const {
    const std::string &first = target.between[0], &second = target.between[1];
    return (is_particles(first) && (is_particles(second) || is_obstacle(second))) ||
           (is_particles(second) && is_obstacle(first));
  }

  // Refuses pairs of two obstacles, and of a material and something else.
  void kinds(const ContactPairCase& target, const std::string& path) const {
    const std::string &first = target.between[0], &second = target.between[1];
    if (is_obstacle(first) && is_obstacle(second)) {
      fail(join_path(path, "between"), "a pair of two obstacles",
           "expected " + std::string(of_particles_ ? "particles" : "a body") +
               " as one of the two: obstacles do not collide with each other");
    }
    const bool first_is_partner = contains(partners_, first);
    if (first_is_partner == contains(partners_, second)) return;
    fail(join_path(path, "between"),
         in_quotes(first_is_partner ? second : first) + " is a material, and " +
             in_quotes(first_is_partner ? first : second) + " is none",
         "expected two bodies or obstacles, or two materials");
  }

  void numbers_of_cloth(const ContactPairCase& target, const std::string& path) const {
    if (target.restitution) {
      fail(join_path(path, "restitution"), "a restitution in the " + text_of(target),
           "expected \"friction\" only: cloth has no restitution of its own; how it rebounds "
           "follows from its stiffness, its damping and contact.damping_time");
    }
    if (!target.friction) {
      fail(join_path(path, "between"), "the " + text_of(target) + " has no \"friction\"",
           "expected a number >= 0");
    }
  }

  const Case& case_;
  const Locations& locations_;
  bool of_particles_;  // otherwise the case simulates bodies
  std::vector<std::string> partners_, materials_;
};

}  // namespace

void check_contact_pairs(const Case& target, const Locations& locations) {
  ContactPairChecker(target, locations).check();
}

}  // namespace weft::sim
