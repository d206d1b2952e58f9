// The Galerkin product P^T A P for matrices of 3x3 blocks.
#pragma once

#include <memory>
#include <unordered_set>
#include <utility>
#include <vector>

#include "sim/matrix/block_matrix.h"
#include "sim/solver/image_coarsening.h"

namespace weft::sim {

// Forms the product for every A of one pattern. The terms that make up a row of the result are
// found once. Rows made alike share one recipe, as most rows of an image do.
class GalerkinProduct {
 public:
  // Finds the pattern of the result and the recipes of its rows. The prolongation must outlive the
  // object. O(blocks), on one thread.
  GalerkinProduct(std::shared_ptr<const BlockPattern> fine, const Prolongation& prolongation);
  GalerkinProduct(GalerkinProduct&&) = default;  // a copy's rows would point to these recipes

  const std::shared_ptr<const BlockPattern>& pattern() const { return coarse_; }

  // coarse = P^T fine P, for matrices of the patterns above. Each row is summed in double by one
  // thread: the bits do not depend on the number of threads. O(blocks).
  void form(const SingleBlockMatrix& fine, SingleBlockMatrix& coarse, int threads) const;

 private:
  struct Term {
    int block;     // index into the blocks that list_blocks() lists
    float weight;  // product of both interpolation weights
    bool operator==(const Term&) const = default;
  };
  // The sums that make up a row of the result from its diagonal on, two per block. The first adds
  // upper blocks of the fine matrix. The second adds the upper blocks whose transposes stand below
  // the diagonal.
  struct Recipe {
    std::vector<Term> terms;
    std::vector<int> starts;  // of each sum, and the end of the last
    bool operator==(const Recipe&) const = default;
    Mat3 sum(int i, const std::vector<int>& blocks, const SingleBlockMatrix& fine) const;
  };
  struct Hash {
    std::size_t operator()(const Recipe& recipe) const;
  };
  struct Scratch {
    std::vector<int> place;                   // the first sum of its block, by column of the row
    std::vector<std::pair<int, Term>> terms;  // each with the number of its sum
    std::vector<int> next;                    // place of the next term, by sum
  };

  void write_recipe(int row, Scratch& scratch, Recipe& recipe) const;
  void list_blocks(int row, std::vector<int>& blocks) const;

  std::shared_ptr<const BlockPattern> fine_, coarse_;
  const Prolongation& prolongation_;
  std::unordered_set<Recipe, Hash> recipes_;
  std::vector<const Recipe*> recipe_of_row_;
};

}  // namespace weft::sim
