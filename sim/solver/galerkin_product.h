// The Galerkin product P^T A P for matrices of 3x3 blocks.
#pragma once

#include <memory>
#include <unordered_set>
#include <utility>
#include <vector>

#include "sim/matrix/block_matrix.h"
#include "sim/solver/image_coarsening.h"

namespace weft::sim {

// Forms the product P^T A P for any number of matrices A of one pattern. A recipe lists the terms
// that make up a row of the result. The recipes are found once. Rows with equal terms use the same
// recipe, as most rows of an image do.
class GalerkinProduct {
 public:
  // Finds the pattern of the result and the recipes of its rows. The prolongation must outlive the
  // object. O(blocks), on one thread.
  GalerkinProduct(std::shared_ptr<const BlockPattern> fine, const Prolongation& prolongation);
  // Move-only: recipe_of_row_ of a copy would point to the recipes of the original.
  GalerkinProduct(GalerkinProduct&&) = default;

  const std::shared_ptr<const BlockPattern>& pattern() const { return coarse_; }

  // Computes coarse = P^T fine P. Precondition: `fine` has the constructor's pattern, and `coarse`
  // has pattern(). Each row is summed by one thread and in double, so the bits do not depend on the
  // number of threads. O(blocks).
  void form(const SingleBlockMatrix& fine, SingleBlockMatrix& coarse, int threads) const;

 private:
  struct Term {
    int block;     // index into the blocks that list_blocks() lists
    float weight;  // product of the interpolation weights of the block's row and column
    bool operator==(const Term&) const = default;
  };
  // The terms of one row of the result. Each of its upper blocks is the first of two sums plus the
  // transpose of the second. The second sum is of fine blocks that are stored only as their
  // transposes.
  struct Recipe {
    std::vector<Term> terms;
    std::vector<int> starts;  // index of the first term of each sum, then the number of terms
    bool operator==(const Recipe&) const = default;
    Mat3 sum(int i, const std::vector<int>& blocks, const SingleBlockMatrix& fine) const;
  };
  struct Hash {
    std::size_t operator()(const Recipe& recipe) const;
  };
  struct Scratch {
    std::vector<int> place;  // for each coarse column: index of the first sum of its block
    std::vector<std::pair<int, Term>> terms;  // index of a sum, and one of its terms
    std::vector<int> next;                    // for each sum: index of its next term
  };

  void write_recipe(int row, Scratch& scratch, Recipe& recipe) const;
  void list_blocks(int row, std::vector<int>& blocks) const;

  std::shared_ptr<const BlockPattern> fine_, coarse_;
  const Prolongation& prolongation_;
  std::unordered_set<Recipe, Hash> recipes_;
  std::vector<const Recipe*> recipe_of_row_;
};

}  // namespace weft::sim
