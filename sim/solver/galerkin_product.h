// P^T A P for matrices of 3x3 blocks.
#pragma once

#include <memory>
#include <span>

#include "sim/forces/block_matrix.h"
#include "sim/solver/image_coarsening.h"

namespace weft::sim {

// The pattern of P^T A P for an A of the pattern `fine`. O(blocks).
std::shared_ptr<const BlockPattern> galerkin_pattern(const BlockPattern& fine,
                                                     const Prolongation& prolongation);

// coarse = P^T fine P; coarse has the pattern above. Summed in double, row by row of the result:
// the same bits on any number of threads. O(blocks).
void galerkin_product(const SingleBlockMatrix& fine, const Prolongation& prolongation,
                      SingleBlockMatrix& coarse, int threads);

}  // namespace weft::sim
