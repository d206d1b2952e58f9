// A serial SUNDIALS vector whose kernels are ours: Debian builds its own without vectorisation, and
// they would take half the run time on small images.
#pragma once

#include <sundials/sundials_nvector.h>

namespace weft::sim {

// N_VNew_Serial of this length with the operations below in place of Debian's; clones inherit them.
// Sums are formed in chunks of a fixed size, so that any number of threads gives the same bits.
N_Vector make_vector(sunindextype length, int threads, SUNContext context);

}  // namespace weft::sim
