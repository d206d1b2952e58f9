// Presets: published materials whose values a [material.NAME] takes over by the key `preset`.
#pragma once

#include <toml++/toml.h>

#include <string>
#include <vector>

namespace weft::sim {

// A published number that a case would refuse, and the number that the preset has instead.
struct PresetChange {
  std::string key;  // path of the number, such as "measured_membrane.shear[1]"
  double published = 0, value = 0;
};

struct MaterialPreset {
  std::string name, description;
  std::string source;  // publication from which the numbers come
  toml::table keys;    // keys of a material; their source file is, for example, `preset "cotton"`
  std::vector<PresetChange> changes;
};

// Returns all presets, in the order of material_presets.inc.
const std::vector<MaterialPreset>& material_presets();
std::vector<std::string> preset_names();

// True if an override of `key` sets the preset of a material, or replaces one material or all
// materials as a whole.
bool changes_presets(const std::string& key);
// Adds the keys of the preset to every material that names a preset. Keys that the material itself
// has are not replaced. Throws CaseError for an unknown preset, with the hint of name_hint().
void add_presets(toml::table& root);
// Removes keys of presets that do not go with keys of the case itself, or that a switch of their
// table turns off. For example, a membrane_stiffness in the case removes a preset's
// measured_membrane.
void remove_overridden_presets(toml::table& root);

// Return all presets with their values, sources and changes. The first function returns text for
// people, the second function a JSON object {"presets": [{"name", "description", "source", "keys":
// {...}, "changes": [{"key", "published", "value"}]}]}.
std::string material_presets_text();
std::string material_presets_json();

}  // namespace weft::sim
