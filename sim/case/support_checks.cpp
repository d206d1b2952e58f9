#include "sim/case/support_checks.h"

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "sim/case/case_error.h"
#include "sim/case/case_schema.h"
#include "sim/case/case_shape_checks.h"
#include "sim/case/case_text.h"
#include "sim/case/membrane_stiffness.h"

namespace weft::sim {

namespace {

class SupportChecker {
 public:
  SupportChecker(const Case& target, const Locations& locations)
      : case_(target), locations_(locations) {}

  void check() const {
    for (std::size_t i = 0; i < case_.body.size(); ++i) {
      for (std::size_t j = 0; j < case_.body[i].pin.size(); ++j) {
        if (case_.body[i].pin[j].slides())
          pin(case_.body[i], case_.body[i].pin[j],
              join_path(join_path(join_path("body", i), "pin"), j));
      }
    }
    for (std::size_t i = 0; i < case_.load.size(); ++i) load(case_.load[i], join_path("load", i));
  }

 private:
  [[noreturn]] void fail(const std::string& path, const std::string& message,
                         const std::string& hint) const {
    throw CaseError(locations_.value(path), message, hint);
  }

  const MaterialCase& material_of(const BodyCase& body) const {
    return *std::ranges::find(case_.material, body.material, &MaterialCase::name);
  }
  bool is_shell(const BodyCase& body) const { return material_of(body).is_shell(); }

  void pin(const BodyCase& body, const PinCase& pin, const std::string& path) const {
    const std::string key = pin.symmetry ? "symmetry_normal" : "axes";
    if (std::set(pin.axes.begin(), pin.axes.end()).size() < pin.axes.size())
      fail(join_path(path, "axes"), "\"axes\" names a direction twice", "expected each once");
    const bool is_timed = std::ranges::any_of(body.pin, [](const PinCase& each) {
      return each.hold_time > 0 || each.release_time.has_value();
    });
    if (is_timed) {
      fail(join_path(path, key),
           in_quotes(key) + " does not go with a hold_time or release_time of the same body",
           "expected pins that hold all the time");
    }
    // The springs of axes are a multiple of this stiffness, and would hold nothing.
    if (!pin.symmetry && !is_shell(body) && largest_membrane_stiffness(material_of(body)) == 0) {
      fail(join_path(path, key), "axes of a membrane without stiffness, which give it no hold",
           "expected membrane_stiffness > 0 in " + heading(join_path("material", body.material)) +
               ", or a pin without axes");
    }
    if (!pin.symmetry) return;
    if (pin.symmetry->isZero(0))
      fail(join_path(path, key), "the normal has no direction",
           "expected a vector that is not zero");
    if (!is_shell(body)) {
      fail(join_path(path, key),
           "a plane of symmetry of body " + in_quotes(body.name) + ", which is no shell",
           "expected model = \"shell\" in " + heading(join_path("material", body.material)) +
               ", or axes, which hold vertices in a plane");
    }
    if (pin.motion) {
      fail(join_path(path, "motion"), "a plane of symmetry does not move",
           "expected axes, whose motion is prescribed");
    }
  }

  void load(const LoadCase& load, const std::string& path) const {
    const auto body = std::ranges::find(case_.body, load.body, &BodyCase::name);
    if (body == case_.body.end()) {
      std::vector<std::string> bodies;
      for (const BodyCase& each : case_.body) bodies.push_back(each.name);
      fail(join_path(path, "body"), "no body " + in_quotes(load.body),
           name_hint(load.body, bodies));
    }
    selection(load, path, *body);
    if (load.type == LoadType::moment && !is_shell(*body)) {
      fail(join_path(path, "type"),
           "a moment on body " + in_quotes(body->name) + ", which is no shell",
           "expected model = \"shell\" in " + heading(join_path("material", body->material)));
    }
  }

  // Refuses selectors that this type of load does not use, and a lack of selectors that it needs.
  void selection(const LoadCase& load, const std::string& path, const BodyCase& body) const {
    const bool is_point = load.type == LoadType::point;
    const bool is_edge = load.type == LoadType::line || load.type == LoadType::moment;
    const std::vector<std::string> allowed =
        is_point  ? std::vector<std::string>{"corners", "edges",      "rows",      "cols",
                                             "patch",   "region_min", "region_max"}
        : is_edge ? std::vector<std::string>{"edges", "patch"}
                  : std::vector<std::string>{"region_min", "region_max"};
    for (const char* key :
         {"corners", "edges", "rows", "cols", "patch", "region_min", "region_max"}) {
      if (!locations_.given(join_path(path, key)) ||
          std::ranges::find(allowed, key) != allowed.end())
        continue;
      fail(join_path(path, key), in_quotes(key) + " does not select what this type of load acts on",
           "expected " + quoted_list(allowed));
    }
    if (is_edge && load.vertices.edges.empty())
      fail(path, "the load names no edge", "expected edges = [\"first_row\"] or others");
    const bool has_box = load.vertices.region_min || load.vertices.region_max;
    if (is_point || is_edge || has_box)
      check_selection(load.vertices, "load", body.shape, path, locations_);
  }

  const Case& case_;
  const Locations& locations_;
};

}  // namespace

void check_loads_and_supports(const Case& target, const Locations& locations) {
  SupportChecker(target, locations).check();
}

}  // namespace weft::sim
