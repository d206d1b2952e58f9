// A serial SUNDIALS vector with vectorised kernels. The kernels in Debian's SUNDIALS are not
// vectorised and would take half the run time on small images.
#pragma once

#include <sundials/sundials_nvector.h>

namespace weft::sim {

// Returns an N_VNew_Serial vector of zeros with the vectorised kernels, which clones inherit. Sums
// are formed in chunks of a fixed size, so any number of threads gives the same bits.
N_Vector make_vector(sunindextype length, int threads, SUNContext context);

}  // namespace weft::sim
