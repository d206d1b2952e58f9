#include "sim/case/case_output_checks.h"

#include <algorithm>

#include "sim/case/case_error.h"
#include "sim/case/case_schema.h"
#include "sim/case/case_shape_checks.h"
#include "sim/case/case_text.h"
#include "sim/case/time_methods.h"

namespace weft::sim {

namespace {

class OutputChecker {
 public:
  OutputChecker(const Case& target, const Locations& locations)
      : case_(target), output_(target.output), locations_(locations) {
    for (const BodyCase& body : case_.body) names_.push_back(body.name);
    for (const ObstacleCase& obstacle : case_.obstacle) names_.push_back(obstacle.name);
    for (const ParticlesCase& particles : case_.particles) names_.push_back(particles.name);
  }

  void check() const {
    frame_times();
    bodies();
    parts();
  }

 private:
  [[noreturn]] void fail(const std::string& path, const std::string& message,
                         const std::string& hint) const {
    throw CaseError(locations_.value(path), message, hint);
  }

  void frame_times() const {
    const std::vector<double>& times = output_.frame_times;
    if (times.empty()) return;
    if (traits_of(case_.time.method).finds_equilibria()) {
      fail("output.frame_times", "frame_times with a method that finds equilibria",
           "expected time.frames_per_second: each frame is an equilibrium");
    }
    for (std::size_t i = 0; i < times.size(); ++i) {
      const std::string place = join_path("output.frame_times", i);
      if (i > 0 && times[i] <= times[i - 1]) {
        fail(place,
             "the frame at " + number_text(times[i]) + " s follows one at " +
                 number_text(times[i - 1]) + " s",
             "expected increasing times");
      }
      if (times[i] > case_.time.duration) {
        fail(place, "a frame at " + number_text(times[i]) + " s is after the end of the run",
             "expected at most the duration, " + number_text(case_.time.duration) + " s");
      }
    }
  }

  // Throws CaseError if nothing that is recorded has the name.
  void require_known(const std::string& name, const std::string& place) const {
    if (std::ranges::find(names_, name) != names_.end()) return;
    fail(place, "no body, obstacle or group of particles is called " + in_quotes(name),
         name_hint(name, names_));
  }

  void bodies() const {
    const std::vector<std::string>& names = output_.bodies;
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string place = join_path("output.bodies", i);
      require_known(names[i], place);
      if (std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(i), names[i]) !=
          names.begin() + static_cast<std::ptrdiff_t>(i)) {
        fail(place, in_quotes(names[i]) + " again", "expected each name once");
      }
    }
  }

  const ShapeCase& shape_of(const std::string& name) const {
    const auto body = std::ranges::find(case_.body, name, &BodyCase::name);
    if (body != case_.body.end()) return body->shape;
    return std::ranges::find(case_.obstacle, name, &ObstacleCase::name)->shape;
  }

  void parts() const {
    for (std::size_t i = 0; i < output_.part.size(); ++i) {
      const OutputPartCase& part = output_.part[i];
      const std::string path = join_path("output.part", i);
      const std::string place = join_path(path, "body");
      require_known(part.body, place);
      if (std::ranges::find(case_.particles, part.body, &ParticlesCase::name) !=
          case_.particles.end()) {
        fail(place, "a part of particles " + in_quotes(part.body),
             "expected a body or an obstacle, whose images have rows and columns");
      }
      const std::vector<std::string>& recorded = output_.bodies;
      if (!recorded.empty() && std::ranges::find(recorded, part.body) == recorded.end()) {
        fail(place, in_quotes(part.body) + " is not recorded",
             "expected a name that output.bodies lists: " + quoted_list(recorded));
      }
      for (std::size_t j = 0; j < i; ++j) {
        if (output_.part[j].body != part.body) continue;
        fail(place, "a second part of " + in_quotes(part.body), "expected one part for each body");
      }
      check_rows_and_cols(shape_of(part.body), part.rows, part.cols, path, locations_);
    }
  }

  const Case& case_;
  const OutputCase& output_;
  const Locations& locations_;
  std::vector<std::string> names_;
};

}  // namespace

void check_output(const Case& target, const Locations& locations) {
  OutputChecker(target, locations).check();
}

}  // namespace weft::sim
