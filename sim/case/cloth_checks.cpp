#include "sim/case/cloth_checks.h"

#include <algorithm>
#include <string>
#include <vector>

#include "sim/case/case_error.h"
#include "sim/case/case_schema.h"
#include "sim/case/case_shape_checks.h"
#include "sim/case/case_text.h"
#include "sim/case/membrane_stiffness.h"
#include "sim/case/time_methods.h"

namespace weft::sim {

namespace {

class ClothChecker {
 public:
  ClothChecker(const Case& target, const Locations& locations)
      : case_(target), locations_(locations) {}

  void check() const {
    for (const MaterialCase& material : case_.material) {
      const std::string path = join_path("material", material.name);
      loss_factor(material, path);
      strain_limit(material, path);
      creases(material, path);
    }
    for (std::size_t i = 0; i < case_.seam.size(); ++i) seam(case_.seam[i], join_path("seam", i));
  }

 private:
  [[noreturn]] void fail(const std::string& path, const std::string& message,
                         const std::string& hint) const {
    throw CaseError(locations_.value(path), message, hint);
  }

  void loss_factor(const MaterialCase& material, const std::string& path) const {
    if (material.loss_factor && !material.loss_frequency) {
      fail(join_path(path, "loss_factor"), "a loss_factor without the frequency at which it holds",
           "expected loss_frequency (Hz) with it");
    }
    if (material.loss_frequency && !material.loss_factor) {
      fail(join_path(path, "loss_frequency"), "a loss_frequency without a loss_factor",
           "expected loss_factor with it");
    }
  }

  void strain_limit(const MaterialCase& material, const std::string& path) const {
    if (!material.strain_limit || largest_membrane_stiffness(material) > 0) return;
    fail(join_path(path, "strain_limit"), "a strain_limit of a membrane without stiffness",
         "expected membrane_stiffness > 0 in " + heading(path));
  }

  void creases(const MaterialCase& material, const std::string& path) const {
    if (material.yield_curvature && material.orthotropic_bending) {
      fail(join_path(path, "yield_curvature"),
           "a yield_curvature beside orthotropic_bending: creases are of isotropic bending",
           "expected bending_stiffness in place of orthotropic_bending in " + heading(path));
    }
    if (material.yield_curvature && !(material.bending_stiffness > 0)) {
      fail(join_path(path, "yield_curvature"),
           "a yield_curvature of a material that does not resist bending",
           "expected bending_stiffness > 0 in " + heading(path));
    }
    if (material.hardening && !material.yield_curvature) {
      fail(join_path(path, "hardening"), "hardening of a material that does not yield",
           "expected yield_curvature with it");
    }
  }

  // Returns the body of this name, which must be of cloth. `key` has the name.
  const BodyCase& side(const std::string& name, const std::string& path,
                       const std::string& key) const {
    const auto body = std::ranges::find(case_.body, name, &BodyCase::name);
    if (body == case_.body.end()) {
      std::vector<std::string> bodies;
      for (const BodyCase& each : case_.body) bodies.push_back(each.name);
      fail(join_path(path, key), "no body " + in_quotes(name), name_hint(name, bodies));
    }
    if (material_of(*body).is_shell()) {
      fail(join_path(path, key), "a seam of body " + in_quotes(name) + ", which is a shell",
           "expected model = \"cloth\" in " + heading(join_path("material", body->material)) +
               ", or a [[tie]]");
    }
    return *body;
  }
  const MaterialCase& material_of(const BodyCase& body) const {
    return *std::ranges::find(case_.material, body.material, &MaterialCase::name);
  }

  void seam(const SeamCase& target, const std::string& path) const {
    const BodyCase& body = side(target.body, path, "body");
    const BodyCase& other = side(target.to, path, "to");
    check_edge_range(body.shape, target.edge, target.range, path, "range", locations_);
    check_edge_range(other.shape, target.to_edge, target.to_range, path, "to_range", locations_);
    const bool is_same = target.body == target.to && target.edge == target.to_edge &&
                         target.patch == target.to_patch;
    if (is_same && (target.range.empty() || target.to_range.empty())) {
      fail(join_path(path, "to_edge"), "an edge that is sewn to itself",
           "expected another edge, or a range and a to_range of it");
    }
    if (!target.stiffness && largest_membrane_stiffness(material_of(body)) == 0 &&
        largest_membrane_stiffness(material_of(other)) == 0) {
      fail(path, "a seam of two membranes without stiffness, which give it none",
           "expected stiffness (N/m^2), or membrane_stiffness > 0 of a side");
    }
    if (target.closing_time > case_.time.duration) {
      fail(join_path(path, "closing_time"),
           "closing_time is " + number_text(target.closing_time) + " s, longer than the run",
           "expected at most the duration, " + number_text(case_.time.duration) + " s");
    }
  }

  const Case& case_;
  const Locations& locations_;
};

}  // namespace

void check_cloth(const Case& target, const Locations& locations) {
  ClothChecker(target, locations).check();
}

}  // namespace weft::sim
