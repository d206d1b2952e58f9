#include "sim/case/particles_checks.h"

#include <algorithm>

#include "sim/case/case_error.h"
#include "sim/case/case_schema.h"
#include "sim/case/case_text.h"
#include "sim/case/time_methods.h"

namespace weft::sim {

namespace {

class ParticlesChecker {
 public:
  ParticlesChecker(const Case& target, const Locations& locations)
      : case_(target), locations_(locations) {
    for (const ParticlesCase& each : case_.particles) names_.push_back(each.name);
    for (const ObstacleCase& each : case_.obstacle) names_.push_back(each.name);
  }

  void check() const {
    if (case_.body.empty() && case_.particles.empty())
      fail("", "the case has no \"body\"", "expected tables [[body]] or [[particles]]");
    method();
    for (std::size_t i = 0; i < case_.particles.size(); ++i)
      positions(case_.particles[i], join_path(join_path("particles", i), "positions"));
    for (std::size_t i = 0; i < case_.contact.pair.size(); ++i) pair(i);
  }

 private:
  [[noreturn]] void fail(const std::string& path, const std::string& message,
                         const std::string& hint) const {
    throw CaseError(locations_.value(path), message, hint);
  }

  void method() const {
    const bool collides = case_.time.method == TimeMethod::impulses;
    if (collides && !case_.body.empty()) {
      fail(join_path(join_path("body", 0), "name"),
           "body " + in_quotes(case_.body.front().name) + " with time.method = \"impulses\"",
           "expected [[particles]] and [[obstacle]] only");
    }
    if (collides && case_.restart)
      fail("restart.path", "a restart with time.method = \"impulses\"",
           "expected weft run --resume, which goes on with a run of particles");
    if (collides || case_.particles.empty()) return;
    fail(join_path(join_path("particles", 0), "name"),
         "particles " + in_quotes(case_.particles.front().name) +
             " with time.method = " + in_quotes(traits_of(case_.time.method).name),
         "expected time.method = \"impulses\"");
  }

  void positions(const ParticlesCase& of, const std::string& path) const {
    const PositionsCase& places = of.positions;
    if (places.type == PositionsType::random) {
      for (int k = 0; k < 3; ++k) {
        if (places.region_max[k] >= places.region_min[k]) continue;
        fail(join_path(path, "region_max"), "region_max is below region_min",
             "expected a box whose upper corner is at least as high along x, y and z");
      }
    }
    if (places.type != PositionsType::grid) return;
    double number = 1;
    for (const int along : places.count) number *= along;
    if (number > most_particles) {
      fail(join_path(path, "count"), number_text(number) + " particles",
           "expected at most " + number_text(most_particles));
    }
    if (places.spacing && *places.spacing < 2 * of.radius) {
      fail(join_path(path, "spacing"),
           "a spacing of " + number_text(*places.spacing) + " m makes particles overlap",
           "expected at least twice the radius, " + number_text(2 * of.radius) + " m");
    }
  }

  bool is_obstacle(const std::string& name) const {
    return std::ranges::find(case_.obstacle, name, &ObstacleCase::name) != case_.obstacle.end();
  }

  void pair(std::size_t number) const {
    const ContactPairCase& target = case_.contact.pair[number];
    const std::string path = join_path("contact.pair", number);
    for (std::size_t k = 0; k < 2; ++k) {
      const std::string& name = target.between[k];
      if (std::ranges::find(names_, name) != names_.end()) continue;
      fail(join_path(join_path(path, "between"), k), "no particles or obstacle " + in_quotes(name),
           names_.empty() ? "expected particles or obstacles, and the case has none"
                          : name_hint(name, names_));
    }
    const std::string &first = target.between[0], &second = target.between[1];
    if (is_obstacle(first) && is_obstacle(second)) {
      fail(join_path(path, "between"), "a pair of two obstacles",
           "expected particles as one of the two: obstacles do not collide with each other");
    }
    for (std::size_t other = 0; other < number; ++other) {
      const std::vector<std::string>& names = case_.contact.pair[other].between;
      if (!std::ranges::is_permutation(names, target.between)) continue;
      fail(join_path(path, "between"),
           "a second pair of " + in_quotes(first) + " and " + in_quotes(second),
           "expected each pair once");
    }
  }

  static constexpr double most_particles = 1e8;

  const Case& case_;
  const Locations& locations_;
  std::vector<std::string> names_;  // of particles and obstacles
};

}  // namespace

void check_particles(const Case& target, const Locations& locations) {
  ParticlesChecker(target, locations).check();
}

}  // namespace weft::sim
