#pragma once

#include <future>

#include "core/backend.hpp"

namespace angio::simulation {

/// Makes the GPU ready beside the caller if simulations on `backend` may use one: it takes a tenth
/// of a second, which else is part of `simulate`. What is wrong with the GPU is reported there.
std::future<void> wake_gpu(Backend backend);

}  // namespace angio::simulation
