#pragma once

#include <cuda_runtime_api.h>

#include "simulation/contact/candidate_search.hpp"

/// Launching candidate_search.hpp on a GPU.
namespace angio::simulation::detail {

/// What launch_search needs for `count` = vertices + 1.
std::size_t scan_bytes(int count);

/// Finds the candidates where the bodies are when the stream comes to it.
///
/// @param scan_memory  scan_bytes(vertices + 1) of the device's
template <class Real>
cudaError_t launch_search(const CandidateSearch<Real>& search, void* scan_memory,
                          cudaStream_t stream);

}  // namespace angio::simulation::detail
