// Published materials that a [material.NAME] begins with: preset = "NAME".
#pragma once

#include <toml++/toml.h>

#include <string>
#include <vector>

namespace weft::sim {

// A number of a source that a case would refuse, and the number that the preset has in its place.
struct PresetChange {
  std::string key;  // "measured_membrane.shear[1]"
  double published = 0, value = 0;
};

struct MaterialPreset {
  std::string name, description;
  std::string source;  // of its numbers
  toml::table keys;    // those of a [material.NAME]; their place in the text is `preset "NAME"`
  std::vector<PresetChange> changes;
};

// All presets, in the order of material_presets.inc.
const std::vector<MaterialPreset>& material_presets();
std::vector<std::string> preset_names();

// True if an override chooses a preset, or replaces a material that may have one.
bool changes_presets(const std::string& override_text);
// Adds the keys of its preset to every material of the tree that names one, where the material
// lacks them. Throws CaseError for an unknown preset, with the nearest name.
void add_presets(toml::table& root);
// Removes the keys of presets that do not go with what the case itself says: another kind of
// membrane, say, or a constant in place of a table.
void remove_overridden_presets(toml::table& root);

// The presets with their values, sources and changes, as text for people and as one JSON object:
// {"presets": [{"name", "description", "source", "keys": {...}, "changes": [{"key", "published",
// "value"}]}]}.
std::string material_presets_text();
std::string material_presets_json();

}  // namespace weft::sim
