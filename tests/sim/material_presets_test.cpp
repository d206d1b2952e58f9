// Presets of materials: their numbers, and what a case changes of them.
#include "sim/case/material_presets.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "sim/case/case_error.h"
#include "sim/case/case_reader.h"
#include "tests/measured_fabrics.h"

namespace weft::sim::material_presets_test {
namespace {

const std::string sheet = R"(
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [5, 9] }
)";

MaterialCase material_of(const std::string& keys, const std::vector<std::string>& overrides = {}) {
  return parse_case("[material.m]\n" + keys + sheet, "case.toml", overrides).material[0];
}

TEST(MaterialPresets, HaveThePublishedNumbers) {
  for (const MeasuredFabric& fabric : measured_fabrics()) {
    const MaterialCase material = material_of("preset = \"" + fabric.name + "\"");
    EXPECT_EQ(material.density, fabric.density);
    const auto rows = clamped_coefficients(fabric);
    ASSERT_TRUE(material.measured_membrane && material.orthotropic_bending) << fabric.name;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      EXPECT_EQ(material.measured_membrane->warp[i], rows[i][0]);
      EXPECT_EQ(material.measured_membrane->coupling[i], rows[i][1]);
      EXPECT_EQ(material.measured_membrane->weft[i], rows[i][2]);
      EXPECT_EQ(material.measured_membrane->shear[i], rows[i][3]);
    }
    for (std::size_t i = 0; i < 5; ++i) {
      EXPECT_EQ(material.orthotropic_bending->warp[i], fabric.bending[0][i]);
      EXPECT_EQ(material.orthotropic_bending->bias[i], fabric.bending[1][i]);
      EXPECT_EQ(material.orthotropic_bending->weft[i], fabric.bending[2][i]);
      EXPECT_EQ(material.orthotropic_bending->curvatures[i], 10.0 * static_cast<double>(i));
    }
  }
}

TEST(MaterialPresets, CanAllBeUsed) {
  for (const MaterialPreset& preset : material_presets()) {
    const bool is_sheet = preset.keys["model"].value<std::string>() == "shell" &&
                          !preset.keys.contains("shell_thickness");
    const MaterialCase material = material_of("preset = \"" + preset.name + '"' +
                                              (is_sheet ? "\nshell_thickness = 1e-3" : ""));
    EXPECT_GT(material.area_density(), 0) << preset.name;
    EXPECT_FALSE(preset.source.empty()) << preset.name;
  }
}

TEST(MaterialPresets, GiveWayToTheKeysOfTheCase) {
  const std::string denim = "preset = \"11oz-black-denim\"\n";
  const MaterialCase heavier = material_of(denim + "density = 0.5\nnormal_drag = 1\n");
  EXPECT_EQ(heavier.density, 0.5);
  EXPECT_TRUE(heavier.measured_membrane);
  // One number of a table, by the file and by an override.
  EXPECT_EQ(
      material_of(denim + "[material.m.measured_membrane]\nfactor = 2\n").measured_membrane->factor,
      2);
  const MaterialCase one = material_of(denim, {"material.m.measured_membrane.warp.1=321",
                                               "material.m.orthotropic_bending.factor=0.25"});
  EXPECT_EQ(one.measured_membrane->warp[1], 321);
  EXPECT_EQ(one.measured_membrane->warp[0], 205.352005);
  EXPECT_EQ(one.orthotropic_bending->factor, 0.25);
  // A constant in place of a table.
  for (const bool by_override : {false, true}) {
    const std::vector<std::string> keys{"membrane_stiffness=700", "bending_stiffness=2e-5"};
    std::string text = denim;
    std::vector<std::string> overrides;
    for (const std::string& key : keys) {
      if (by_override) {
        overrides.push_back("material.m." + key);
      } else {
        text += key + '\n';
      }
    }
    const MaterialCase plain = material_of(text, overrides);
    EXPECT_FALSE(plain.measured_membrane || plain.orthotropic_bending);
    EXPECT_EQ(plain.membrane_stiffness, 700);
    EXPECT_EQ(plain.bending_stiffness, 2e-5);
    EXPECT_EQ(plain.density, 0.324);
  }
  // Another kind of membrane, and another preset.
  EXPECT_FALSE(material_of(denim + "membrane = \"springs\"\n").measured_membrane);
  const MaterialCase other = material_of(denim, {"material.m.preset=silk"});
  EXPECT_FALSE(other.measured_membrane);
  EXPECT_EQ(other.orthotropic_membrane->weft_stiffness, 326.61);
}

// Nothing of a shell's preset applies to cloth.
TEST(MaterialPresets, RefuseAnotherModel) {
  try {
    parse_case("[material.m]\npreset = \"paper\"\nmodel = \"cloth\"\n" + sheet, "case.toml");
    FAIL();
  } catch (const CaseError& error) {
    const std::string text = error.what();
    EXPECT_EQ(text.rfind("case.toml:3:9: the preset has \"", 0), 0U) << text;
    EXPECT_NE(text.find("which model = \"cloth\" does not know"), std::string::npos) << text;
  }
}

// A resolved case has the numbers of its presets, and is read as the case itself was.
TEST(MaterialPresets, AreWrittenOutInResolvedCases) {
  for (const MaterialPreset& preset : material_presets()) {
    const std::string thickness =
        preset.keys["model"].value<std::string>() == "shell" ? "shell_thickness = 1e-3\n" : "";
    const Case first = parse_case(
        "[material.m]\npreset = \"" + preset.name + "\"\n" + thickness + sheet, "case.toml");
    EXPECT_NE(first.resolved_text.find("preset = \"" + preset.name + '"'), std::string::npos);
    EXPECT_EQ(parse_case(first.resolved_text, "case.toml").resolved_text, first.resolved_text);
  }
  const Case denim =
      parse_case("[material.m]\npreset = \"11oz-black-denim\"\n" + sheet, "case.toml");
  EXPECT_NE(denim.resolved_text.find("[material.m.measured_membrane]"), std::string::npos);
  EXPECT_NE(denim.resolved_text.find("205.352005"), std::string::npos);
  EXPECT_EQ(denim.resolved_text.find("membrane_stiffness"), std::string::npos);
  EXPECT_EQ(denim.resolved_text.find("\nbending_stiffness"), std::string::npos);
  // Cases without presets do not speak of them.
  EXPECT_EQ(parse_case(sheet, "case.toml").resolved_text.find("preset"), std::string::npos);
}

TEST(MaterialPresets, AreListedWithTheirChanges) {
  const auto json = nlohmann::json::parse(material_presets_json());
  EXPECT_EQ(json["presets"].size(), preset_names().size());
  for (const MeasuredFabric& fabric : measured_fabrics()) {
    const auto& presets = json["presets"];
    const auto found = std::find_if(presets.begin(), presets.end(),
                                    [&](const auto& each) { return each["name"] == fabric.name; });
    ASSERT_NE(found, presets.end());
    EXPECT_NE((*found)["source"].get<std::string>().find("Ramamoorthi"), std::string::npos);
    const auto rows = clamped_coefficients(fabric);
    std::size_t changes = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      for (std::size_t k = 0; k < 4; ++k) {
        if (rows[i][k] == fabric.stretch[i][k]) continue;
        ++changes;
        const std::array<const char*, 4> keys{"warp", "coupling", "weft", "shear"};
        const std::string key =
            "measured_membrane." + std::string(keys[k]) + '[' + std::to_string(i) + ']';
        const auto& all = (*found)["changes"];
        const auto change = std::find_if(all.begin(), all.end(),
                                         [&](const auto& each) { return each["key"] == key; });
        ASSERT_NE(change, all.end()) << fabric.name << ' ' << key;
        EXPECT_EQ((*change)["published"], fabric.stretch[i][k]);
        EXPECT_EQ((*change)["value"], rows[i][k]);
        EXPECT_NE(material_presets_text().find(key), std::string::npos);
      }
    }
    EXPECT_EQ((*found)["changes"].size(), changes) << fabric.name;
  }
}

}  // namespace
}  // namespace weft::sim::material_presets_test
