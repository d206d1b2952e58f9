// A serial SUNDIALS vector with Weft's own vectorised kernels: those of Debian's SUNDIALS are not
// vectorised (docs/decisions/0023).
#pragma once

#include <sundials/sundials_nvector.h>

namespace weft::sim {

// Returns an N_VNew_Serial vector of zeros. It and its clones use the vectorised kernels. Sums are
// formed in chunks of a fixed size, so any number of threads gives the same bits.
N_Vector make_vector(sunindextype length, int threads, SUNContext context);

}  // namespace weft::sim
