#pragma once

namespace angio::simulation::detail {

/// Of an array of a step's views.
enum class ArrayRole {
  model,  ///< constant
  state,  ///< lives from step to step
  work,   ///< no more than memory when a step begins
};

}  // namespace angio::simulation::detail
