#pragma once

/// Marks a function that runs on the CPU and, compiled by nvcc, on the GPU.
/// Such a function allocates nothing, does no I/O and knows no thread index.
#if defined(__CUDACC__)
#define ANGIO_HOST_DEVICE __host__ __device__
#else
#define ANGIO_HOST_DEVICE
#endif

/// Keeps a function that one thread of many runs out of its callers, so that its registers are not
/// theirs.
#if defined(__CUDACC__)
#define ANGIO_OUT_OF_LINE __noinline__
#else
#define ANGIO_OUT_OF_LINE
#endif
