#include "sim/scene/patch_joints.h"

#include <algorithm>
#include <array>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

namespace weft::sim {

namespace {

// A border of a patch, with the control points in the row or column next to it.
struct Border {
  int patch = 0;
  const char* name = "";
  std::vector<int> points, beside;
  bool is_closed = false;

  int edges() const { return static_cast<int>(points.size()) - (is_closed ? 0 : 1); }
  std::pair<int, int> edge(int i) const {
    return std::minmax({points[i], points[(i + 1) % points.size()]});
  }
};

std::vector<Border> borders_of(const bsi::Atlas& atlas) {
  std::vector<Border> borders;
  for (int p = 0; p < static_cast<int>(atlas.patches().size()); ++p) {
    const bsi::Patch& patch = atlas.patches()[p];
    const auto add_row = [&](const char* name, int row, int next) {
      Border border{p, name, {}, {}, patch.wrap_u};
      for (int col = 0; col < patch.cols; ++col) {
        border.points.push_back(atlas.particle(p, row, col));
        border.beside.push_back(atlas.particle(p, next, col));
      }
      borders.push_back(std::move(border));
    };
    const auto add_column = [&](const char* name, int col, int next) {
      Border border{p, name, {}, {}, patch.wrap_v};
      for (int row = 0; row < patch.rows; ++row) {
        border.points.push_back(atlas.particle(p, row, col));
        border.beside.push_back(atlas.particle(p, row, next));
      }
      borders.push_back(std::move(border));
    };
    if (!patch.wrap_v) {
      add_row("first_row", 0, 1);
      add_row("last_row", patch.rows - 1, patch.rows - 2);
    }
    if (!patch.wrap_u) {
      add_column("first_col", 0, 1);
      add_column("last_col", patch.cols - 1, patch.cols - 2);
    }
  }
  return borders;
}

// Rotates and reverses the order of the points of `border` until they equal the points of `with`.
// Returns false if the borders have different points.
bool align(const Border& with, Border& border) {
  if (border.is_closed != with.is_closed || border.points.size() != with.points.size())
    return false;
  for (int turn = 0; turn < 2; ++turn) {
    const auto start = std::ranges::find(border.points, with.points.front());
    const auto shift = start - border.points.begin();
    if (border.is_closed && start != border.points.end()) {
      std::ranges::rotate(border.points, border.points.begin() + shift);
      std::ranges::rotate(border.beside, border.beside.begin() + shift);
    }
    if (border.points == with.points) return true;
    std::ranges::reverse(border.points);
    std::ranges::reverse(border.beside);
  }
  return false;
}

[[noreturn]] void refuse(const Border& border) {
  throw std::invalid_argument("patch " + std::to_string(border.patch) +
                              " shares a part of its border " + border.name +
                              " with another patch");
}

}  // namespace

std::vector<PatchJoint> find_patch_joints(const bsi::Atlas& atlas) {
  const std::vector<Border> borders = borders_of(atlas);
  // The one or two borders that contain an edge, as indices in `borders`; -1: no second border.
  std::map<std::pair<int, int>, std::array<int, 2>> users;
  for (int b = 0; b < static_cast<int>(borders.size()); ++b) {
    for (int i = 0; i < borders[b].edges(); ++i) {
      const auto [place, is_new] = users.try_emplace(borders[b].edge(i), std::array{b, -1});
      if (!is_new) place->second[1] = b;
    }
  }
  std::vector<PatchJoint> joints;
  for (int b = 0; b < static_cast<int>(borders.size()); ++b) {
    const Border& border = borders[b];
    for (int i = 0; i < border.edges(); ++i) {
      const auto [first, second] = users.at(border.edge(i));
      if (second < 0) continue;
      Border other = borders[first == b ? second : first];
      if (!align(border, other)) refuse(border);
      if (first == b && i == 0)
        joints.push_back({border.points, border.beside, other.beside, border.is_closed});
    }
  }
  return joints;
}

}  // namespace weft::sim
