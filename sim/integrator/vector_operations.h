// A serial SUNDIALS vector with kernels of our own. Debian builds SUNDIALS' kernels without
// vectorisation: they would take half the run time on small images.
#pragma once

#include <sundials/sundials_nvector.h>

namespace weft::sim {

// Returns an N_VNew_Serial vector with our kernels, which clones inherit. Sums are formed in chunks
// of a fixed size: any number of threads gives the same bits.
N_Vector make_vector(sunindextype length, int threads, SUNContext context);

}  // namespace weft::sim
