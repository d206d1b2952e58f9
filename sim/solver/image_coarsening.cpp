#include "sim/solver/image_coarsening.h"

#include <algorithm>
#include <cmath>

#include "sim/base/parallel.h"
#include "sim/scene/spline_surface.h"
#include "sim/solver/coarse_axis.h"

namespace weft::sim {

namespace {

// A patch on one level.
struct LevelImage {
  CoarseAxis rows, cols;
  // Indices of the nodes, rows.nodes() x cols.nodes(). -1: no free finer node depends on the node.
  std::vector<int> node;

  int at(int row, int col) const {
    return node[static_cast<std::size_t>(row % rows.nodes()) * cols.nodes() + col % cols.nodes()];
  }
};

CoarseAxis axis_of(int quads, int points, bool wraps, const SceneBody& body) {
  if (!body.spline) return {quads, quads, wraps};
  const int degree = body.spline->degree(), elements = wraps ? points : points - degree;
  return {elements, elements, wraps, degree};
}

// Appends an image of 2 x 2 equal nodes for each sphere. It is too small to be coarsened, so that
// spheres stay single on all levels.
void append_spheres(const SceneBody& spheres, std::vector<LevelImage>& images) {
  constexpr CoarseAxis one_quad{1, 1, false};
  for (int i = 0; i < spheres.particle_count(); ++i)
    images.push_back({one_quad, one_quad, std::vector<int>(4, spheres.first_particle + i)});
}

std::vector<LevelImage> images_of(const Scene& scene) {
  std::vector<LevelImage> images;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const SceneBody& body = scene.bodies[b];
    if (body.spheres != nullptr) {
      append_spheres(body, images);
      continue;
    }
    const std::vector<bsi::Patch>& patches = body.atlas.patches();
    for (std::size_t p = 0; p < patches.size(); ++p) {
      LevelImage& image = images.emplace_back();
      image.rows = axis_of(patches[p].quad_rows(), patches[p].rows, patches[p].wrap_v, body);
      image.cols = axis_of(patches[p].quad_cols(), patches[p].cols, patches[p].wrap_u, body);
      const int first = body.atlas.first_texel(static_cast<int>(p));
      for (int i = 0; i < patches[p].texel_count(); ++i) {
        image.node.push_back(body.first_particle + body.atlas.particle_of_texel(first + i));
      }
    }
  }
  return images;
}

// Makes the next coarser level of the `fine` images. `count` is the number of nodes of the fine
// level. `fixed` marks fixed nodes, and is empty if no node is fixed.
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

  // Appends the next coarser image. Each of its nodes stands for one fine node: the texel that it
  // keeps or, for a spline, the nearest fine node. number_ gives that fine node a coarse index.
  void keep(const LevelImage& fine) {
    LevelImage& coarse = images_.emplace_back(LevelImage{fine.rows, fine.cols, {}});
    if (fine.rows.can_be_coarsened() && fine.cols.can_be_coarsened()) {
      coarse.rows = fine.rows.coarser();
      coarse.cols = fine.cols.coarser();
    }
    const std::vector<int> rows = fine.rows.nearest_nodes(coarse.rows),
                           cols = fine.cols.nearest_nodes(coarse.cols);
    for (int row : rows) {
      for (int col : cols) {
        const int node = fine.at(row, col);
        if (node >= 0 && number_[node] < 0) number_[node] = coarse_count_++;
        coarse.node.push_back(node < 0 ? -1 : number_[node]);
      }
    }
  }

  // Sets the parents of the free fine nodes: the coarse nodes from which they are interpolated. A
  // texel that is kept has one parent, itself. The weights of any other node are the products of
  // its weights along both axes. If several images contain a node, the first image decides.
  void find_parents(const LevelImage& fine, const LevelImage& coarse) {
    const auto rows = fine.rows.shares(coarse.rows), cols = fine.cols.shares(coarse.cols);
    for (int row = 0; row < fine.rows.nodes(); ++row) {
      for (int col = 0; col < fine.cols.nodes(); ++col) {
        const int node = fine.at(row, col);
        if (node < 0 || !parents_of_[node].empty() || (!fixed_.empty() && fixed_[node] != 0))
          continue;
        if (fine.rows.degree == 0 && number_[node] >= 0) {
          parents_of_[node] = {{number_[node], 1.0}};
          continue;
        }
        for (const auto& [coarse_row, along_rows] : rows[row]) {
          for (const auto& [coarse_col, along_cols] : cols[col])
            add(parents_of_[node], coarse.at(coarse_row, coarse_col), along_rows * along_cols);
        }
      }
    }
  }

  // Adds a parent. The same node may be added twice, on a short wrapped axis or in a row of the
  // image that is a single point. Its weights are then added.
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

  std::vector<int> number_;  // coarse index of each fine node before drop_childless(); -1: not kept
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
