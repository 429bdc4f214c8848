#include "benchmarks/texture_limit.hpp"

#ifndef ANGIO_HAS_CUDA
namespace angio::benchmarks {

double texture_fetches_per_second() { return 0.0; }

}  // namespace angio::benchmarks
#endif
