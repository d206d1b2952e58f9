#include "sim/case/fabric_checks.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "materials/orthotropic_moduli.h"
#include "sim/case/case_error.h"
#include "sim/case/case_schema.h"
#include "sim/case/case_text.h"

namespace weft::sim {

namespace {

class FabricChecker {
 public:
  FabricChecker(const MaterialCase& material, const Locations& locations)
      : material_(material), path_(join_path("material", material.name)), locations_(locations) {}

  void check() const {
    if (material_.orthotropic_membrane)
      orthotropic(*material_.orthotropic_membrane, join_path(path_, "orthotropic_membrane"));
    if (material_.measured_membrane)
      measured(*material_.measured_membrane, join_path(path_, "measured_membrane"));
    if (material_.orthotropic_bending)
      bending(*material_.orthotropic_bending, join_path(path_, "orthotropic_bending"));
  }

 private:
  [[noreturn]] void fail(const std::string& path, const std::string& message,
                         const std::string& hint) const {
    throw CaseError(locations_.value(path), message, hint);
  }
  [[noreturn]] void fail_entry(const std::string& path, const std::string& key, std::size_t index,
                               double value, const std::string& hint) const {
    const std::string entry = join_path(key, index);
    fail(join_path(path, entry), in_quotes(entry) + " is " + number_text(value), hint);
  }

  void orthotropic(const OrthotropicMembraneCase& membrane, const std::string& path) const {
    require(membrane.warp_stiffness || membrane.warp_curve, path, "warp_stiffness", "warp_curve");
    require(membrane.weft_stiffness || membrane.weft_curve, path, "weft_stiffness", "weft_curve");
    require(membrane.shear_modulus || membrane.shear_curve, path, "shear_modulus", "shear_curve");
    if (membrane.warp_curve) curve(*membrane.warp_curve, join_path(path, "warp_curve"));
    if (membrane.weft_curve) curve(*membrane.weft_curve, join_path(path, "weft_curve"));
    if (membrane.shear_curve) {
      const std::string place = join_path(path, "shear_curve");
      curve(*membrane.shear_curve, place);
      if (membrane.shear_curve->strains.front() < 0)
        fail_entry(place, "strains", 0, membrane.shear_curve->strains.front(),
                   "expected 0: the other direction is the mirror image");
    }
    poisson_ratio(membrane, path);
  }
  void require(bool is_given, const std::string& path, const std::string& constant,
               const std::string& curve) const {
    if (is_given) return;
    fail(path, heading(path) + " has no " + in_quotes(constant),
         "expected " + in_quotes(constant) + ", a number (N/m), or " + in_quotes(curve) +
             ", a table");
  }
  void poisson_ratio(const OrthotropicMembraneCase& membrane, const std::string& path) const {
    const double ratio = membrane.poisson_ratio;
    if (ratio == 0) return;
    const std::string place = join_path(path, "poisson_ratio");
    const std::string message = in_quotes("poisson_ratio") + " is " + number_text(ratio);
    if (membrane.has_curves())
      fail(place, message + " beside a curve",
           "expected 0: curves have no Poisson effect, which they would contradict");
    const double limit = *membrane.warp_stiffness / *membrane.weft_stiffness;
    if (ratio * ratio < limit) return;
    fail(place, message,
         "expected between -" + rounded_text(std::sqrt(limit)) + " and " +
             rounded_text(std::sqrt(limit)) +
             ", the root of warp_stiffness / weft_stiffness: cloth beyond would gain energy by "
             "stretching");
  }

  void curve(const StretchCurveCase& curve, const std::string& path) const {
    same_length(curve.tensions.size(), curve.strains.size(), path, "tensions", "strains");
    const auto zero = std::ranges::find(curve.strains, 0.0);
    rises(curve.strains, path, "strains", true);
    if (zero == curve.strains.end())
      fail(join_path(path, "strains"), "\"strains\" has no 0",
           "expected the strain 0, where the tension is 0, among them");
    rises(curve.tensions, path, "tensions", false);
    const auto index = static_cast<std::size_t>(zero - curve.strains.begin());
    if (curve.tensions[index] != 0)
      fail_entry(path, "tensions", index, curve.tensions[index],
                 "expected 0 at the strain 0: cloth at rest has no tension");
  }
  void same_length(std::size_t count, std::size_t expected, const std::string& path,
                   const std::string& key, const std::string& beside) const {
    if (count == expected) return;
    fail(join_path(path, key),
         in_quotes(key) + " has " + counted(static_cast<std::int64_t>(count), "entry", "entries") +
             " beside " + std::to_string(expected) + " in " + in_quotes(beside),
         "expected as many");
  }
  void rises(const std::vector<double>& values, const std::string& path, const std::string& key,
             bool strictly) const {
    for (std::size_t i = 1; i < values.size(); ++i) {
      if (values[i] > values[i - 1] || (!strictly && values[i] == values[i - 1])) continue;
      fail_entry(path, key, i, values[i],
                 strictly ? "expected more than the entry before, " + number_text(values[i - 1])
                          : "expected a curve that does not fall: at least the entry before, " +
                                number_text(values[i - 1]));
    }
  }

  void measured(const MeasuredMembraneCase& membrane, const std::string& path) const {
    for (std::size_t i = 0; i < membrane.coupling.size(); ++i) {
      const double limit = std::sqrt(membrane.warp[i] * membrane.weft[i]);
      if (membrane.coupling[i] <= limit * (1 + 1e-12)) continue;
      fail_entry(path, "coupling", i, membrane.coupling[i],
                 "expected at most " + rounded_text(limit) +
                     ", the root of warp x weft: cloth beyond would gain energy by stretching");
    }
  }

  void bending(const OrthotropicBendingCase& bending, const std::string& path) const {
    const std::size_t count = bending.warp.size();
    same_length(bending.bias.size(), count, path, "bias", "warp");
    same_length(bending.weft.size(), count, path, "weft", "warp");
    if (count > 1 || !bending.curvatures.empty())
      same_length(bending.curvatures.size(), count, path, "curvatures", "warp");
    if (!bending.curvatures.empty() && bending.curvatures[0] != 0)
      fail_entry(path, "curvatures", 0, bending.curvatures[0], "expected 0, the flat cloth");
    rises(bending.curvatures, path, "curvatures", true);
    for (std::size_t i = 0; i < count; ++i) {
      if (materials::is_bending_possible(bending.warp[i], bending.bias[i], bending.weft[i]))
        continue;
      fail_entry(path, "bias", i, bending.bias[i],
                 "expected more than " +
                     rounded_text(materials::least_bias(bending.warp[i], bending.weft[i])) +
                     ", (sqrt(warp) - sqrt(weft))^2 / 4: some curvature would otherwise gain "
                     "energy");
    }
  }

  const MaterialCase& material_;
  std::string path_;
  const Locations& locations_;
};

}  // namespace

void check_fabrics(const Case& target, const Locations& locations) {
  for (const MaterialCase& material : target.material) FabricChecker(material, locations).check();
}

}  // namespace weft::sim
