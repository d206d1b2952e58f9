#include "sim/sweep/sweep_keys.h"

#include <algorithm>
#include <sstream>
#include <utility>

#include "sim/case/case_error.h"
#include "sim/case/case_text.h"

namespace weft::sim {

namespace {

bool is_index(const std::string& part) {
  return !part.empty() && part.find_first_not_of("0123456789") == std::string::npos;
}

// Returns the index, as text, of an entry of a list that a key names; or the name if no entry has
// it.
std::string index_text(const toml::array& list, const std::string& name) {
  for (std::size_t i = 0; i < list.size(); ++i) {
    const toml::table* entry = list[i].as_table();
    if (entry != nullptr && (*entry)["name"].value<std::string>() == name) return std::to_string(i);
  }
  return name;
}

struct KeyInCase {
  // The key with the indices of all entries that it names, which is the same text for all names of
  // one value: "body.0.position.2" for "body.cloth.position.2".
  std::string text;
  bool is_in_table = false;  // a table of the case has this key; entries of arrays have none
};

KeyInCase find_key(const toml::table& root, const std::string& key) {
  std::istringstream parts(key);
  const toml::node* node = &root;
  KeyInCase result;
  for (std::string part; std::getline(parts, part, '.');) {
    const toml::array* list = node == nullptr ? nullptr : node->as_array();
    const toml::table* table = node == nullptr ? nullptr : node->as_table();
    if (list != nullptr) part = index_text(*list, part);
    if (table == nullptr && is_index(part))
      part.erase(0, std::min(part.find_first_not_of('0'), part.size() - 1));
    result.text += (result.text.empty() ? "" : ".") + part;
    node = table != nullptr ? table->get(part) : nullptr;
    result.is_in_table = node != nullptr;
    if (list != nullptr && is_index(part) && part.size() < 10) node = list->get(std::stoul(part));
  }
  return result;
}

bool is_part_of(const std::string& key, const std::string& whole) {
  return key.size() > whole.size() && key.starts_with(whole) && key[whole.size()] == '.';
}

// Applies an override as far as names of entries depend on it.
void apply_for_names(toml::table& root, const CaseOverride& each) {
  try {
    apply_override(root, each);
  } catch (const CaseError&) {
    // An array that only the preset of a material has is not there, so no entry of it can be set.
    // Its entries have no names.
  }
}

}  // namespace

SweepKeys::SweepKeys(toml::table root, std::span<const CaseOverride> fixed, std::size_t of_set)
    : root_(std::move(root)) {
  for (std::size_t i = 0; i < fixed.size(); ++i) {
    const std::string key = find_key(root_, fixed[i].key).text;
    if (i < of_set) check_of_set(fixed[i], key);
    // An option may change a value of [set], or of an option before.
    keys_.insert_or_assign(key, Known{fixed[i].key, &fixed[i]});
    apply_for_names(root_, fixed[i]);
  }
}

std::vector<const SweepKeys::Entry*> SweepKeys::overlapping(const std::string& key) const {
  std::vector<const Entry*> found;
  for (std::size_t end = key.find('.');; end = key.find('.', end + 1)) {
    const auto known = keys_.find(key.substr(0, end));
    if (known != keys_.end()) found.push_back(&*known);
    if (end == std::string::npos) break;
  }
  for (auto part = keys_.lower_bound(key + '.');
       part != keys_.end() && is_part_of(part->first, key); ++part)
    found.push_back(&*part);
  return found;
}

void SweepKeys::check_of_set(const CaseOverride& each, const std::string& key) const {
  for (const Entry* entry : overlapping(key)) {
    const auto& [other, known] = *entry;
    if (other == key) {
      throw CaseError(each.key_place,
                      in_quotes(each.key) + " is the same key as " + in_quotes(known.name),
                      "expected it once in a sweep");
    }
    if (!is_part_of(other, key)) continue;
    throw CaseError(each.key_place,
                    in_quotes(each.key) + " replaces " + in_quotes(known.name) +
                        ", a part of it that [set] has before",
                    "expected the part after the whole, or one of the two");
  }
}

void SweepKeys::add_varying(const std::string& key, const SourceLocation& place) {
  const KeyInCase found = find_key(root_, key);
  for (const Entry* entry : overlapping(found.text)) {
    const auto& [other, known] = *entry;
    if (other == found.text) {
      throw CaseError(place, in_quotes(key) + " is the same key as " + in_quotes(known.name),
                      "expected it once in a sweep");
    }
    const bool is_whole = is_part_of(other, found.text);
    if (known.fixed == nullptr) {
      throw CaseError(place,
                      in_quotes(is_whole ? known.name : key) + " is a part of " +
                          in_quotes(is_whole ? key : known.name) + ", and both vary in this sweep",
                      "expected one of the two");
    }
    if (is_whole) {
      throw CaseError(known.fixed->key_place,
                      in_quotes(known.name) + " is a part of " + in_quotes(key) +
                          ", which varies in this sweep",
                      "expected a key that is no part of a factor");
    }
    if (!found.is_in_table) continue;
    throw CaseError(known.fixed->key_place,
                    in_quotes(known.name) + " has a value of " + in_quotes(key) +
                        ", which varies in this sweep",
                    "expected a value without that key");
  }
  keys_.emplace(found.text, Known{key});
}

}  // namespace weft::sim
