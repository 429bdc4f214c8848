#pragma once

namespace angio::benchmarks {

/// How many values a second the GPU's texture units give, where nothing else is in their way: a
/// kernel that does nothing but look up an image that its caches hold, linearly between four
/// samples of single precision, neighbouring threads at neighbouring samples. Median of five.
/// @return 0 without CUDA or without a GPU
double texture_fetches_per_second();

}  // namespace angio::benchmarks
