#include "sim/case/case_include.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <utility>
#include <vector>

#include "sim/case/case_error.h"
#include "sim/case/case_schema.h"
#include "sim/case/case_table_reader.h"
#include "sim/case/case_text.h"
#include "sim/case/case_tree.h"

namespace weft::sim {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_nested_files = 32;
constexpr const char* contents = "[material.NAME], [[obstacle]] and [[include]]";

struct Include {
  std::string path;
  SourceLocation where;
};

// Removes the [[include]] tables from the tree of `file`. Returns the paths that they name, and the
// places of these paths in `file`.
std::vector<Include> take_includes(toml::table& tree, const std::string& file) {
  const toml::node* node = tree.get("include");
  if (node == nullptr) return {};
  Case prototype;
  Locations locations(file);
  read_field(*describe(prototype).find("include"), *node, "include", locations);
  std::vector<Include> includes;
  for (std::size_t i = 0; i < prototype.include.size(); ++i) {
    includes.push_back(
        {prototype.include[i].path, locations.value(join_path(join_path("include", i), "path"))});
  }
  tree.erase("include");
  return includes;
}

// Returns the canonical path of a file, without symbolic links, "." and "..", or `file` itself if
// the canonical path cannot be found. Paths to one file have one canonical path, except hard links.
std::string identity_of(const std::string& file) {
  std::error_code error;
  const fs::path identity = fs::weakly_canonical(file, error);
  return error ? file : identity.string();
}

void refuse_other_keys(const toml::table& tree) {
  const std::vector<std::string> allowed = {"material", "obstacle", "include"};
  const toml::key* other = first_key_beside(allowed, tree);
  if (other == nullptr) return;
  const std::string name(other->str());
  const SourceLocation where = location_of(other->source());
  Case prototype;
  if (describe(prototype).find(name) != nullptr) {
    throw CaseError(
        where, in_quotes(name) + " does not belong in an included file",
        "expected it in the case file; an included file holds " + std::string(contents));
  }
  throw CaseError(where, "unknown key " + in_quotes(name) + " in an included file",
                  name_hint(name, allowed));
}

[[noreturn]] void fail_kind(const toml::node& node, const std::string& key,
                            const std::string& expected) {
  throw CaseError(location_of(node.source()), in_quotes(key) + " is " + kind_of(node),
                  "expected " + expected);
}

// Makes the path of an obstacle's shape file, if the shape has one, relative to the case file. An
// absolute path does not change. `folder` is the folder of the included file, relative to that of
// the case file or absolute.
void move_shape_path(toml::table& obstacle, const fs::path& folder) {
  if (auto* path = obstacle["shape"]["path"].as_string()) *path = (folder / path->get()).string();
}

class Merger {
 public:
  Merger(toml::table& root, const std::string& path)
      : root_(root), chain_{{path, identity_of(path)}}, seen_{identity_of(path)} {}

  // Merges the files that `tree`, the tree of the last file in `chain_`, includes. `folder` is the
  // folder of that last file, relative to that of the case file or absolute.
  void merge_includes_of(toml::table& tree, const fs::path& folder) {
    for (const Include& include : take_includes(tree, chain_.back().path)) {
      merge_file(include, folder);
    }
  }
  const std::vector<std::string>& merged() const { return merged_; }

 private:
  struct File {
    std::string path, identity;
  };

  void merge_file(const Include& include, const fs::path& folder) {
    const std::string path = (fs::path(chain_.back().path).parent_path() / include.path).string();
    File file{path, identity_of(path)};
    refuse_circle(include, file);
    if (!seen_.insert(file.identity).second) return;
    const FileText text = read_text(path);
    if (!text.fault.empty()) {
      throw CaseError(include.where, in_quotes(include.path) + ' ' + text.fault,
                      "expected a TOML file with materials and obstacles, here " + path);
    }
    toml::table tree = parse_toml(text.text, path);
    refuse_other_keys(tree);
    const fs::path inner = folder / fs::path(include.path).parent_path();
    merged_.push_back(path);
    merge_materials(tree);
    merge_obstacles(tree, inner);
    chain_.push_back(std::move(file));
    merge_includes_of(tree, inner);
    chain_.pop_back();
  }

  void refuse_circle(const Include& include, const File& file) const {
    const auto first = std::ranges::find(chain_, file.identity, &File::identity);
    if (first == chain_.end()) {
      if (chain_.size() < most_nested_files) return;
      throw CaseError(include.where,
                      "more than " + std::to_string(most_nested_files) + " files in each other",
                      "expected a few levels of [[include]]");
    }
    std::string circle;
    for (auto each = first; each != chain_.end(); ++each) circle += each->path + " -> ";
    throw CaseError(include.where, "the includes form a circle",
                    "expected files that do not include each other: " + circle + file.path);
  }

  void merge_materials(toml::table& tree) {
    toml::node* source = tree.get("material");
    if (source == nullptr) return;
    if (!source->is_table()) fail_kind(*source, "material", "tables [material.NAME]");
    toml::table* target = list_in_root<toml::table>(tree, "material");
    if (target == nullptr) return;
    for (auto&& [key, node] : *source->as_table()) {
      if (const auto first = target->find(key.str()); first != target->end()) {
        refuse_second_material(key, first->first);
      }
      target->insert_or_assign(key, std::move(node));
    }
  }

  [[noreturn]] static void refuse_second_material(const toml::key& second, const toml::key& first) {
    throw CaseError(location_of(second.source()),
                    "a second " + heading(join_path("material", std::string(second.str()))),
                    "expected a name that no other material has; the first is at " +
                        place_text(location_of(first.source())));
  }

  void merge_obstacles(toml::table& tree, const fs::path& folder) {
    toml::node* source = tree.get("obstacle");
    if (source == nullptr) return;
    if (!source->is_array_of_tables()) fail_kind(*source, "obstacle", "tables [[obstacle]]");
    toml::array* target = list_in_root<toml::array>(tree, "obstacle");
    if (target == nullptr) return;
    for (toml::node& node : *source->as_array()) {
      move_shape_path(*node.as_table(), folder);
      target->push_back(std::move(node));
    }
  }

  // Returns the case's table or array `name`. If the case has none, creates an empty one with the
  // source location of this key in `tree`. Returns null if the case's value is not a List; the
  // reader will refuse it. Precondition: `tree` has the key.
  template <class List>
  List* list_in_root(const toml::table& tree, const char* name) {
    if (root_.get(name) == nullptr) root_.insert(tree.find(name)->first, List{});
    return root_.get(name)->as<List>();
  }

  toml::table& root_;
  std::vector<File> chain_;          // from the case file to the file being merged
  std::set<std::string> seen_;       // identities of all files reached so far
  std::vector<std::string> merged_;  // paths of all files merged so far
};

}  // namespace

std::vector<std::string> merge_includes(toml::table& root, const std::string& path) {
  Merger merger(root, path);
  merger.merge_includes_of(root, {});
  return merger.merged();
}

}  // namespace weft::sim
