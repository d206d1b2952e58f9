#include "sim/solver/galerkin_product.h"

#include <functional>
#include <numeric>
#include <string_view>

#include "sim/base/parallel.h"

namespace weft::sim {

namespace {

std::shared_ptr<const BlockPattern> product_pattern(const BlockPattern& fine,
                                                    const Prolongation& prolongation) {
  std::vector<std::vector<int>> neighbours(prolongation.coarse_count());
  std::vector<int> last_row(prolongation.coarse_count(), -1);
  for (int row = 0; row < prolongation.coarse_count(); ++row) {
    for (int c = prolongation.child_start[row]; c < prolongation.child_start[row + 1]; ++c) {
      const int child = prolongation.child[c];
      for (int slot = fine.row_begin(child); slot < fine.row_end(child); ++slot) {
        const int column = fine.column(slot);
        for (int k = prolongation.row_start[column]; k < prolongation.row_start[column + 1]; ++k) {
          const int parent = prolongation.column[k];
          if (last_row[parent] == row) continue;
          last_row[parent] = row;
          neighbours[row].push_back(parent);
        }
      }
    }
  }
  return std::make_shared<const BlockPattern>(neighbours);
}

}  // namespace

GalerkinProduct::GalerkinProduct(std::shared_ptr<const BlockPattern> fine,
                                 const Prolongation& prolongation)
    : fine_(std::move(fine)),
      coarse_(product_pattern(*fine_, prolongation)),
      prolongation_(prolongation),
      recipe_of_row_(coarse_->rows()) {
  Scratch scratch;
  scratch.place.resize(coarse_->rows());
  Recipe recipe;
  for (int row = 0; row < coarse_->rows(); ++row) {
    write_recipe(row, scratch, recipe);
    recipe_of_row_[row] = &*recipes_.insert(recipe).first;
  }
}

std::size_t GalerkinProduct::Hash::operator()(const Recipe& recipe) const {
  static_assert(sizeof(Term) == sizeof(int) + sizeof(float));
  return std::hash<std::string_view>()(
      {reinterpret_cast<const char*>(recipe.terms.data()), recipe.terms.size() * sizeof(Term)});
}

void GalerkinProduct::write_recipe(int row, Scratch& scratch, Recipe& recipe) const {
  const int begin = coarse_->diagonal_slot(row), end = coarse_->row_end(row);
  for (int slot = begin; slot < end; ++slot)
    scratch.place[coarse_->column(slot)] = 2 * (slot - begin);
  scratch.terms.clear();
  recipe.starts.assign(2 * (end - begin) + 1, 0);
  int block = 0;
  for (int c = prolongation_.child_start[row]; c < prolongation_.child_start[row + 1]; ++c) {
    const int child = prolongation_.child[c], diagonal = fine_->diagonal_slot(child);
    for (int slot = fine_->row_begin(child); slot < fine_->row_end(child); ++slot, ++block) {
      // Blocks of the result left of its diagonal (parent < row) are skipped: by symmetry, earlier
      // rows hold their mirror images.
      const int column = fine_->column(slot);
      for (int k = prolongation_.row_start[column]; k < prolongation_.row_start[column + 1]; ++k) {
        const int parent = prolongation_.column[k];
        if (parent < row) continue;
        const int sum = scratch.place[parent] + (slot < diagonal ? 1 : 0);
        ++recipe.starts[sum + 1];
        scratch.terms.push_back(
            {sum, {block, prolongation_.child_weight[c] * prolongation_.weight[k]}});
      }
    }
  }
  std::partial_sum(recipe.starts.begin(), recipe.starts.end(), recipe.starts.begin());
  scratch.next = recipe.starts;
  recipe.terms.resize(scratch.terms.size());
  for (const auto& [sum, term] : scratch.terms) recipe.terms[scratch.next[sum]++] = term;
}

// Returns sum `i` of the recipe. Each column is read as four numbers, of which the last is ignored.
// The read of the last column goes one number past the end of the block.
Mat3 GalerkinProduct::Recipe::sum(int i, const std::vector<int>& blocks,
                                  const SingleBlockMatrix& fine) const {
  using Four = Eigen::Array4d;
  Four sum0 = Four::Zero(), sum1 = Four::Zero(), sum2 = Four::Zero();
  for (int k = starts[i]; k < starts[i + 1]; ++k) {
    const float* const block = fine.upper_block(blocks[terms[k].block]).data();
    const auto column = [block](int c) {
      return Eigen::Map<const Eigen::Array4f>(block + 3 * c).cast<double>();
    };
    const double weight = terms[k].weight;
    sum0 += weight * column(0);
    sum1 += weight * column(1);
    sum2 += weight * column(2);
  }
  Mat3 sum;
  sum << sum0.head<3>().matrix(), sum1.head<3>().matrix(), sum2.head<3>().matrix();
  return sum;
}

// Lists the stored blocks of the fine matrix for the rows of the children of `row`, child by child
// and in the order of their slots. A block below the diagonal is stored as its mirror image.
void GalerkinProduct::list_blocks(int row, std::vector<int>& blocks) const {
  blocks.clear();
  for (int c = prolongation_.child_start[row]; c < prolongation_.child_start[row + 1]; ++c) {
    const int child = prolongation_.child[c], begin = fine_->row_begin(child);
    const int below = fine_->diagonal_slot(child) - begin;
    const std::size_t before = blocks.size();
    blocks.resize(before + fine_->row_end(child) - begin);
    int* const of_child = blocks.data() + before;
    for (int i = 0; i < below; ++i) of_child[i] = fine_->mirror(child, begin + i);
    std::iota(of_child + below, blocks.data() + blocks.size(), fine_->upper_diagonal(child));
  }
}

void GalerkinProduct::form(const SingleBlockMatrix& fine, SingleBlockMatrix& coarse,
                           int threads) const {
  parallel_chunks(coarse_->rows(), threads, [&](int first, int last) {
    std::vector<int> blocks;
    for (int row = first; row < last; ++row) {
      list_blocks(row, blocks);
      const Recipe& recipe = *recipe_of_row_[row];
      const int diagonal = coarse_->upper_diagonal(row);
      for (int upper = diagonal; upper < coarse_->upper_end(row); ++upper) {
        const int i = 2 * (upper - diagonal);
        coarse.upper_block(upper) =
            (recipe.sum(i, blocks, fine) + recipe.sum(i + 1, blocks, fine).transpose())
                .cast<float>();
      }
    }
  });
}

}  // namespace weft::sim
