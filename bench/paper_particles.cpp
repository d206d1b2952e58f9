#include "bench/experiments.h"
namespace weft::bench {
int run_paper_particles(const PaperOptions&) { return 0; }
}  // namespace weft::bench
