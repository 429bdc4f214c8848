#pragma once

#include "core/backend.hpp"

namespace angio::pipeline {

/// Refuses a backend that this computer does not have, before anything else is computed.
/// @throws Error (69) if the GPU is asked for, and the program was built without CUDA or no GPU
/// works
void require_backend(Backend backend);

}  // namespace angio::pipeline
