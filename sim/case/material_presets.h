// Published materials, whose values a [material.NAME] takes by preset = "NAME".
#pragma once

#include <toml++/toml.h>

#include <string>
#include <vector>

namespace weft::sim {

// A published number that a case would refuse, and the number that the preset has in its place.
struct PresetChange {
  std::string key;  // "measured_membrane.shear[1]"
  double published = 0, value = 0;
};

struct MaterialPreset {
  std::string name, description;
  std::string source;  // publication of its numbers
  toml::table keys;    // keys of a [material.NAME]; their place in the text is `preset "NAME"`
  std::vector<PresetChange> changes;
};

// Returns all presets, in the order of material_presets.inc.
const std::vector<MaterialPreset>& material_presets();
std::vector<std::string> preset_names();

// Returns true if an override KEY=VALUE sets the preset of a material, or replaces a whole
// material.
bool changes_presets(const std::string& override_text);
// Adds the keys of its preset to every material of the tree that names one. Keys that the material
// has stay. Throws CaseError for an unknown preset, with the nearest name.
void add_presets(toml::table& root);
// Removes the keys of presets that contradict the keys of the case itself: another kind of
// membrane, say, or a constant in place of a table.
void remove_overridden_presets(toml::table& root);

// Return the presets with their values, sources and changes: as text for people, or as one JSON
// object {"presets": [{"name", "description", "source", "keys": {...}, "changes": [{"key",
// "published", "value"}]}]}.
std::string material_presets_text();
std::string material_presets_json();

}  // namespace weft::sim
