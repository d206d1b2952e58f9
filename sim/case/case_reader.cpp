#include "sim/case/case_reader.h"

#include "sim/case/case_checks.h"
#include "sim/case/case_include.h"
#include "sim/case/case_locations.h"
#include "sim/case/case_override.h"
#include "sim/case/case_schema.h"
#include "sim/case/case_table_reader.h"
#include "sim/case/case_text.h"
#include "sim/case/case_tree.h"
#include "sim/case/case_writer.h"
#include "sim/case/located_text.h"
#include "sim/case/material_presets.h"

namespace weft::sim {

namespace {

// Gives each body without a material the only material of the case. A case without materials gets a
// material "default" with default values. Throws CaseError for a body without a material if the
// case has several materials.
void choose_materials(Case& target, const Locations& locations) {
  if (target.material.empty()) {
    target.material.emplace_back().name = "default";
  }
  for (std::size_t i = 0; i < target.body.size(); ++i) {
    BodyCase& body = target.body[i];
    if (!body.material.empty()) continue;
    if (target.material.size() > 1) {
      std::vector<std::string> names;
      for (const MaterialCase& material : target.material) names.push_back(material.name);
      throw CaseError(locations.value(join_path("body", i)),
                      "[[body]] " + in_quotes(body.name) + " has no \"material\"",
                      "expected \"material\", one of " + quoted_list(names));
    }
    body.material = target.material.front().name;
  }
}

bool changes_includes(const std::string& key) {
  return key.starts_with("include.") || key == "include";
}

// A tree with its overrides and included files, and whether the key of the last override takes
// whole numbers only.
struct OverriddenTree {
  toml::table root;
  std::vector<std::string> included;  // paths
  bool last_is_whole = false;
};

OverriddenTree tree_with_overrides(const std::string& text, const std::string& path,
                                   std::span<const CaseOverride> overrides) {
  OverriddenTree tree{parse_toml(text, path), {}};
  const auto apply_those = [&](const auto& condition) {
    for (const CaseOverride& each : overrides) {
      if (!condition(each.key)) continue;
      const bool is_whole = apply_override(tree.root, each);
      if (&each == &overrides.back()) tree.last_is_whole = is_whole;
    }
  };
  // Overrides of `include` choose the included files, so they precede the merge.
  apply_those(changes_includes);
  tree.included = merge_includes(tree.root, path);
  // Overrides that choose presets come next. The other overrides may then change values of a
  // preset.
  apply_those(changes_presets);
  add_presets(tree.root);
  apply_those(
      [](const std::string& key) { return !changes_includes(key) && !changes_presets(key); });
  remove_overridden_presets(tree.root);
  return tree;
}

}  // namespace

bool check_last_override(const std::string& text, const std::string& path,
                         std::span<const CaseOverride> overrides) {
  const OverriddenTree tree = tree_with_overrides(text, path, overrides);
  Case result;
  Locations locations(path);
  read_table(tree.root, describe(result), "", locations);
  return tree.last_is_whole;
}

Case parse_case(const std::string& text, const std::string& path,
                const std::vector<std::string>& overrides) {
  std::vector<CaseOverride> placed;
  for (const std::string& each : overrides) placed.push_back(override_of_option(each));
  return parse_case(text, path, std::span<const CaseOverride>(placed));
}

Case parse_case(const std::string& text, const std::string& path,
                std::span<const CaseOverride> overrides) {
  OverriddenTree tree = tree_with_overrides(text, path, overrides);
  Case result;
  result.path = path;
  result.included = std::move(tree.included);
  Locations locations(path);
  read_table(tree.root, describe(result), "", locations);
  for (OutputExpression& output : result.outputs)
    output.text = located_text(output.text.text, output.text.location, text);
  choose_materials(result, locations);
  result.method_given = locations.given("time.method");
  result.method_location = locations.value("time.method");
  result.accuracy_location = locations.value("time.accuracy");
  check_case(result, locations);
  result.resolved_text = case_text(result);
  return result;
}

Case read_case(const std::string& path, const std::vector<std::string>& overrides) {
  const FileText file = read_text(path);
  if (!file.fault.empty()) {
    throw CaseError({path}, file.fault, "expected a case file" + file.hint);
  }
  return parse_case(file.text, path, overrides);
}

}  // namespace weft::sim
