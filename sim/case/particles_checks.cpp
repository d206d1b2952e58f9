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
    restart();
    for (std::size_t i = 0; i < case_.particles.size(); ++i)
      turning(case_.particles[i], join_path("particles", i));
    for (std::size_t i = 0; i < case_.particles.size(); ++i)
      positions(case_.particles[i], join_path(join_path("particles", i), "positions"));
  }

 private:
  [[noreturn]] void fail(const std::string& path, const std::string& message,
                         const std::string& hint) const {
    throw CaseError(locations_.value(path), message, hint);
  }

  bool collides() const { return case_.time.method == TimeMethod::impulses; }

  void method() const {
    if (collides() && !case_.body.empty()) {
      fail(join_path(join_path("body", 0), "name"),
           "body " + in_quotes(case_.body.front().name) + " with time.method = \"impulses\"",
           "expected [[particles]] and [[obstacle]] only, or time.method = \"cvode\", which "
           "simulates bodies and particles together");
    }
    const TimeMethod method = case_.time.method;
    const bool is_implicit =
        method == TimeMethod::cvode || method == TimeMethod::arkode || method == TimeMethod::euler;
    if (collides() || is_implicit || case_.particles.empty()) return;
    fail(join_path(join_path("particles", 0), "name"),
         "particles " + in_quotes(case_.particles.front().name) +
             " with time.method = " + in_quotes(traits_of(method).name),
         "expected time.method = \"cvode\", \"arkode\" or \"euler\", or, without bodies, "
         "\"impulses\"");
  }

  void restart() const {
    if (case_.particles.empty() && !collides()) return;
    if (case_.restart)
      fail("restart.path", "a restart with particles",
           "expected weft run --resume, which goes on with a run of particles");
    if (case_.time.accuracy)
      fail("time.accuracy", "a case with particles has no calibrated accuracy",
           "expected time.position_tolerance and time.relative_tolerance, or time.step");
  }

  void turning(const ParticlesCase& of, const std::string& path) const {
    if (of.spin || of.angular_velocity_deg.isZero(0)) return;
    fail(join_path(path, "angular_velocity_deg"),
         "an angular velocity of particles " + in_quotes(of.name) + " with spin = false",
         "expected none, or spin = true");
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
    const double diameter = 2 * of.radius;
    if (places.spacing && *places.spacing < diameter) {
      fail(join_path(path, "spacing"),
           "a spacing of " + number_text(*places.spacing) + " m makes particles overlap",
           "expected at least twice the radius, " + number_text(diameter) + " m");
    }
    if (!collides() && places.spacing && *places.spacing < smallest_spacing * diameter) {
      fail(join_path(path, "spacing"),
           "a spacing of " + number_text(*places.spacing) + " m makes particles touch",
           "expected at least " + number_text(smallest_spacing * diameter) +
               " m with time.method = " + in_quotes(traits_of(case_.time.method).name) +
               ", which needs gaps");
    }
  }

  static constexpr double most_particles = 1e8;
  // Least spacing of a lattice under error control, in diameters.
  static constexpr double smallest_spacing = 1.001;

  const Case& case_;
  const Locations& locations_;
};

}  // namespace

void check_particles(const Case& target, const Locations& locations) {
  ParticlesChecker(target, locations).check();
}

}  // namespace weft::sim
