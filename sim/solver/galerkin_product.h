// P^T A P for matrices of 3x3 blocks.
#pragma once

#include <memory>
#include <unordered_set>
#include <utility>
#include <vector>

#include "sim/matrix/block_matrix.h"
#include "sim/solver/image_coarsening.h"

namespace weft::sim {

// Forms the product for all A of one pattern. The blocks and weights that make up a row of the
// result are found once. They are kept once for all rows that are made alike, as most rows of an
// image are.
class GalerkinProduct {
 public:
  // Finds the pattern of the result and how its rows are made. The prolongation must outlive it.
  // O(blocks), on one thread.
  GalerkinProduct(std::shared_ptr<const BlockPattern> fine, const Prolongation& prolongation);
  GalerkinProduct(GalerkinProduct&&) = default;  // a copy's rows would point to these recipes

  const std::shared_ptr<const BlockPattern>& pattern() const { return coarse_; }

  // coarse = P^T fine P; the matrices have the patterns above. Summed in double, row by row of the
  // result: the same bits on any number of threads. O(blocks).
  void form(const SingleBlockMatrix& fine, SingleBlockMatrix& coarse, int threads) const;

 private:
  struct Term {
    int block;     // of those in the rows of the children, counted from the first child's first
    float weight;  // of both interpolations
    bool operator==(const Term&) const = default;
  };
  // Sums that make up a row of the result from its diagonal on, two per block. The first adds upper
  // blocks of the fine matrix as they are. The second adds upper blocks that stand for their mirror
  // images below the diagonal.
  struct Recipe {
    std::vector<Term> terms;
    std::vector<int> starts;  // of each sum; and where the last ends
    bool operator==(const Recipe&) const = default;
    Mat3 sum(int i, const std::vector<int>& blocks, const SingleBlockMatrix& fine) const;
  };
  struct Hash {
    std::size_t operator()(const Recipe& recipe) const;
  };
  struct Scratch {
    std::vector<int> place;                   // by row of the result
    std::vector<std::pair<int, Term>> terms;  // with the number of their sum
    std::vector<int> next;                    // place of a term, by sum
  };

  void write_recipe(int row, Scratch& scratch, Recipe& recipe) const;
  void list_blocks(int row, std::vector<int>& blocks) const;

  std::shared_ptr<const BlockPattern> fine_, coarse_;
  const Prolongation& prolongation_;
  std::unordered_set<Recipe, Hash> recipes_;
  std::vector<const Recipe*> recipe_of_row_;
};

}  // namespace weft::sim
