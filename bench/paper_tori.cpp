#include "bench/experiments.h"
namespace weft::bench {
int run_paper_tori(const PaperOptions&) { return 0; }
}  // namespace weft::bench
