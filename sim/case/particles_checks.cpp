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
      : case_(target), locations_(locations) {}

  void check() const {
    if (case_.body.empty() && case_.particles.empty())
      fail("", "the case has no \"body\"", "expected tables [[body]] or [[particles]]");
    method();
    for (std::size_t i = 0; i < case_.particles.size(); ++i)
      positions(case_.particles[i], join_path(join_path("particles", i), "positions"));
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

  static constexpr double most_particles = 1e8;

  const Case& case_;
  const Locations& locations_;
};

}  // namespace

void check_particles(const Case& target, const Locations& locations) {
  ParticlesChecker(target, locations).check();
}

}  // namespace weft::sim
