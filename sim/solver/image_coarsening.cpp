#include "sim/solver/image_coarsening.h"

#include <algorithm>
#include <cmath>

#include "sim/base/parallel.h"

namespace weft::sim {

namespace {

// The nodes of a level along one axis of a patch.
struct Axis {
  int quads = 0;      // of the patch along this axis
  int intervals = 0;  // of the level along this axis
  bool wraps = false;

  int nodes() const { return wraps ? intervals : intervals + 1; }
  bool can_be_coarsened() const {
    return intervals == quads ? quads >= 4 : intervals % 2 == 0 && intervals >= 4;
  }
  // Returns the texel of node j, or `quads` for the node after the last of a wrapped axis. Halves
  // are rounded towards the middle of the axis. Hence an axis and its mirror image across a seam
  // keep equal texels.
  int texel(int j) const {
    const auto rounded = [&](int i) {
      return (2 * i * static_cast<long>(quads) + intervals) / (2L * intervals);
    };
    return static_cast<int>(2 * j <= intervals ? rounded(j) : quads - rounded(intervals - j));
  }
};

// Returns the number of intervals on the next coarser level. Below the finest level it is half.
// From the finest level it is 2, 3 or (4 .. 7) 2^k, whichever is nearest to half the quads by
// ratio. Such numbers can be halved often.
int fewer_intervals(const Axis& axis) {
  if (axis.intervals != axis.quads) return axis.intervals / 2;
  int best = axis.quads >= 5 ? 3 : 2;
  const auto distance = [&](int m) { return std::abs(std::log(0.5 * axis.quads / m)); };
  for (int scale = 1; scale <= axis.quads / 4; scale *= 2) {
    for (int m = 4 * scale; m < 8 * scale; m += scale) {
      if (distance(m) < distance(best)) best = m;
    }
  }
  return best;
}

// A patch on one level.
struct LevelImage {
  Axis rows, cols;
  std::vector<int> node;  // rows.nodes() x cols.nodes(); -1: no free finer node depends on it

  int at(int row, int col) const {
    return node[static_cast<std::size_t>(row % rows.nodes()) * cols.nodes() + col % cols.nodes()];
  }
};

std::vector<LevelImage> images_of(const Scene& scene) {
  std::vector<LevelImage> images;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const SceneBody& body = scene.bodies[b];
    const std::vector<bsi::Patch>& patches = body.atlas.patches();
    for (std::size_t p = 0; p < patches.size(); ++p) {
      LevelImage& image = images.emplace_back();
      image.rows = {patches[p].quad_rows(), patches[p].quad_rows(), patches[p].wrap_v};
      image.cols = {patches[p].quad_cols(), patches[p].quad_cols(), patches[p].wrap_u};
      const int first = body.atlas.first_texel(static_cast<int>(p));
      for (int i = 0; i < patches[p].texel_count(); ++i) {
        image.node.push_back(body.first_particle + body.atlas.particle_of_texel(first + i));
      }
    }
  }
  return images;
}

// The coarse nodes around a node of the fine axis: the index of the one before or at it, and the
// interpolation weight of the next one.
struct Place {
  int before = 0;
  double weight_after = 0;
};

std::vector<Place> places(const Axis& fine, const Axis& coarse) {
  std::vector<Place> result;
  int j = 0;
  for (int i = 0; i < fine.nodes(); ++i) {
    const int texel = fine.texel(i);
    while (j + 1 < coarse.nodes() && coarse.texel(j + 1) <= texel) ++j;
    const int start = coarse.texel(j);
    // A node at the end of an open axis has weight 0: no coarse node follows it.
    const double weight =
        texel == start ? 0 : (texel - start) / static_cast<double>(coarse.texel(j + 1) - start);
    result.push_back({j, weight});
  }
  return result;
}

// Makes the next coarser level of the `fine` images. `count` is the number of their nodes; `fixed`
// marks fixed nodes, or is empty if there are none.
class Coarsening {
 public:
  Coarsening(const std::vector<LevelImage>& fine, int count, std::span<const char> fixed)
      : number_(count, -1), parents_of_(count), fixed_(fixed) {
    for (const LevelImage& image : fine) keep(image);
    for (std::size_t i = 0; i < fine.size(); ++i) find_parents(fine[i], images_[i]);
    drop_childless();
  }
  const std::vector<LevelImage>& images() const { return images_; }
  Prolongation prolongation() const;

 private:
  struct Parent {
    int node = -1;
    double weight = 0;
  };

  // Numbers the nodes that the coarser image keeps.
  void keep(const LevelImage& fine) {
    LevelImage& coarse = images_.emplace_back(LevelImage{fine.rows, fine.cols, {}});
    if (fine.rows.can_be_coarsened() && fine.cols.can_be_coarsened()) {
      coarse.rows.intervals = fewer_intervals(fine.rows);
      coarse.cols.intervals = fewer_intervals(fine.cols);
    }
    const std::vector<int> rows = kept(fine.rows, coarse.rows), cols = kept(fine.cols, coarse.cols);
    for (int row : rows) {
      for (int col : cols) {
        const int node = fine.at(row, col);
        if (node >= 0 && number_[node] < 0) number_[node] = coarse_count_++;
        coarse.node.push_back(node < 0 ? -1 : number_[node]);
      }
    }
  }

  // Returns the indices, on the fine axis, of the nodes that the coarse axis keeps.
  static std::vector<int> kept(const Axis& fine, const Axis& coarse) {
    std::vector<int> result;
    int i = 0;
    for (int j = 0; j < coarse.nodes(); ++j) {
      while (fine.texel(i) < coarse.texel(j)) ++i;
      result.push_back(i);
    }
    return result;
  }

  // Sets the parents of the free fine nodes, from which they are interpolated. A kept node is its
  // own parent. Any other has the corners of the coarse quad around it. If several images contain a
  // node, the first decides.
  void find_parents(const LevelImage& fine, const LevelImage& coarse) {
    const std::vector<Place> rows = places(fine.rows, coarse.rows),
                             cols = places(fine.cols, coarse.cols);
    for (int row = 0; row < fine.rows.nodes(); ++row) {
      for (int col = 0; col < fine.cols.nodes(); ++col) {
        const int node = fine.at(row, col);
        if (node < 0 || !parents_of_[node].empty() || (!fixed_.empty() && fixed_[node] != 0))
          continue;
        if (number_[node] >= 0) {
          parents_of_[node] = {{number_[node], 1.0}};
          continue;
        }
        for (int corner = 0; corner < 4; ++corner) {
          const int down = corner / 2, right = corner % 2;
          const double weight = (down == 1 ? rows[row].weight_after : 1 - rows[row].weight_after) *
                                (right == 1 ? cols[col].weight_after : 1 - cols[col].weight_after);
          if (weight == 0) continue;
          add(parents_of_[node], coarse.at(rows[row].before + down, cols[col].before + right),
              weight);
        }
      }
    }
  }

  // Adds a parent. Two corners may be the same node on a short wrapped axis; their weights then
  // add up.
  static void add(std::vector<Parent>& parents, int node, double weight) {
    if (node < 0) return;
    const auto same = std::find_if(parents.begin(), parents.end(),
                                   [&](const Parent& parent) { return parent.node == node; });
    if (same != parents.end()) {
      same->weight += weight;
    } else {
      parents.push_back({node, weight});
    }
  }

  // Removes coarse nodes from which no free node is interpolated: they are not unknowns.
  void drop_childless() {
    std::vector<int> renumbered(coarse_count_, -1);
    for (const auto& parents : parents_of_) {
      for (const Parent& parent : parents) renumbered[parent.node] = 0;
    }
    coarse_count_ = 0;
    for (int& number : renumbered) {
      if (number == 0) number = coarse_count_++;
    }
    for (auto& parents : parents_of_) {
      for (Parent& parent : parents) parent.node = renumbered[parent.node];
    }
    for (LevelImage& image : images_) {
      for (int& node : image.node) node = node < 0 ? -1 : renumbered[node];
    }
  }

  std::vector<int> number_;  // by fine node: its number on the coarse level; -1: not kept
  std::vector<std::vector<Parent>> parents_of_;
  std::span<const char> fixed_;
  std::vector<LevelImage> images_;
  int coarse_count_ = 0;
};

Prolongation Coarsening::prolongation() const {
  Prolongation result;
  result.child_start.assign(coarse_count_ + 1, 0);
  result.row_start.push_back(0);
  for (std::vector<Parent> parents : parents_of_) {
    std::sort(parents.begin(), parents.end(),
              [](const Parent& a, const Parent& b) { return a.node < b.node; });
    for (const Parent& parent : parents) {
      result.column.push_back(parent.node);
      result.weight.push_back(static_cast<float>(parent.weight));
      ++result.child_start[parent.node + 1];
    }
    result.row_start.push_back(static_cast<int>(result.column.size()));
  }
  for (int i = 0; i < coarse_count_; ++i) result.child_start[i + 1] += result.child_start[i];
  result.child.resize(result.column.size());
  result.child_weight.resize(result.column.size());
  std::vector<int> next(result.child_start.begin(), result.child_start.end() - 1);
  for (int fine = 0; fine < result.fine_count(); ++fine) {
    for (const Parent& parent : parents_of_[fine]) {
      const int place = next[parent.node]++;
      result.child[place] = fine;
      result.child_weight[place] = static_cast<float>(parent.weight);
    }
  }
  return result;
}

}  // namespace

void Prolongation::restrict_to(std::span<const Vec3> fine, std::span<Vec3> coarse,
                               int threads) const {
  parallel_chunks(coarse_count(), threads, [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      Vec3 sum = Vec3::Zero();
      for (int k = child_start[i]; k < child_start[i + 1]; ++k)
        sum += static_cast<double>(child_weight[k]) * fine[child[k]];
      coarse[i] = sum;
    }
  });
}

void Prolongation::add_to(std::span<const Vec3> coarse, std::span<Vec3> fine, int threads) const {
  parallel_chunks(fine_count(), threads, [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      for (int k = row_start[i]; k < row_start[i + 1]; ++k)
        fine[i] += static_cast<double>(weight[k]) * coarse[column[k]];
    }
  });
}

std::vector<Prolongation> coarsen_images(const Scene& scene) {
  std::vector<LevelImage> images = images_of(scene);
  std::vector<Prolongation> result;
  int count = scene.dynamic_particles;
  const auto can_be_coarsened = [](const LevelImage& image) {
    return image.rows.can_be_coarsened() && image.cols.can_be_coarsened();
  };
  do {
    const Coarsening coarsening(
        images, count,
        result.empty() ? std::span<const char>(scene.pinned) : std::span<const char>());
    result.push_back(coarsening.prolongation());
    images = coarsening.images();
    count = result.back().coarse_count();
  } while (std::any_of(images.begin(), images.end(), can_be_coarsened));
  return result;
}

}  // namespace weft::sim
