// The keys of a case to which a sweep gives values, to find those that hide the values of others.
#pragma once

#include <toml++/toml.h>

#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sim/case/case_override.h"

namespace weft::sim {

// Two keys overlap if they name the same value or one names a part of the other's: "time" and
// "time.duration". Names of entries count as their indices.
class SweepKeys {
 public:
  // `root`: tree of the base case with its included files. `fixed`: overrides of all runs, in their
  // order, of which the first `of_set` are those of [set]; the object keeps references to them.
  // Throws CaseError for a key of [set] that replaces the value of an earlier one.
  SweepKeys(toml::table root, std::span<const CaseOverride> fixed, std::size_t of_set);

  // Notes a key that varies. Throws CaseError if it overlaps another one that varies, and if its
  // values and that of a fixed override replace each other: the summary would list values that no
  // run has. A fixed table without the key, and a fixed array, may have parts that vary.
  void add_varying(const std::string& key, const SourceLocation& place);

 private:
  struct Known {
    std::string name;                     // as the sweep file or the option has it
    const CaseOverride* fixed = nullptr;  // null for a key that varies
  };
  using Entry = std::pair<const std::string, Known>;

  // Returns the known keys that `key`, written with indices, overlaps.
  std::vector<const Entry*> overlapping(const std::string& key) const;
  // Throws CaseError if an override of [set] replaces the value of an earlier one.
  void check_of_set(const CaseOverride& each, const std::string& key) const;

  toml::table root_;                   // with the fixed overrides
  std::map<std::string, Known> keys_;  // by keys with indices
};

}  // namespace weft::sim
