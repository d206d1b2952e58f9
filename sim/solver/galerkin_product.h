// The Galerkin product P^T A P for matrices of 3x3 blocks.
#pragma once

#include <memory>
#include <unordered_set>
#include <utility>
#include <vector>

#include "sim/matrix/block_matrix.h"
#include "sim/solver/image_coarsening.h"

namespace weft::sim {

// Forms the product P^T A P for any number of matrices A of one pattern. The terms that make up
// each row of the result are found once, as a recipe. Rows with equal terms share one recipe, as
// most rows of an image do.
class GalerkinProduct {
 public:
  // Finds the pattern of the result and the recipes of its rows. The prolongation must outlive the
  // object. O(blocks), on one thread.
  GalerkinProduct(std::shared_ptr<const BlockPattern> fine, const Prolongation& prolongation);
  GalerkinProduct(GalerkinProduct&&) = default;  // no copies: they would share these recipes

  const std::shared_ptr<const BlockPattern>& pattern() const { return coarse_; }

  // Computes coarse = P^T fine P, for matrices of the patterns above. One thread sums each row, in
  // double, so the bits do not depend on the number of threads. O(blocks).
  void form(const SingleBlockMatrix& fine, SingleBlockMatrix& coarse, int threads) const;

 private:
  struct Term {
    int block;     // index into the blocks that list_blocks() lists
    float weight;  // product of the interpolation weights of the block's row and column
    bool operator==(const Term&) const = default;
  };
  // The terms of the upper blocks of one row of the result, as two sums per block. The first sum is
  // of fine blocks as stored. The second is of stored blocks whose transposes are needed, so the
  // transposed sum is added.
  struct Recipe {
    std::vector<Term> terms;
    std::vector<int> starts;  // first term of each sum, and one past the last term
    bool operator==(const Recipe&) const = default;
    Mat3 sum(int i, const std::vector<int>& blocks, const SingleBlockMatrix& fine) const;
  };
  struct Hash {
    std::size_t operator()(const Recipe& recipe) const;
  };
  struct Scratch {
    std::vector<int> place;                   // by column of the coarse row: first sum of its block
    std::vector<std::pair<int, Term>> terms;  // number of a sum, and a term of it
    std::vector<int> next;                    // by sum: place of its next term
  };

  void write_recipe(int row, Scratch& scratch, Recipe& recipe) const;
  void list_blocks(int row, std::vector<int>& blocks) const;

  std::shared_ptr<const BlockPattern> fine_, coarse_;
  const Prolongation& prolongation_;
  std::unordered_set<Recipe, Hash> recipes_;
  std::vector<const Recipe*> recipe_of_row_;
};

}  // namespace weft::sim
