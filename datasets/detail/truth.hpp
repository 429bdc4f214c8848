#pragma once

#include "datasets/detail/anatomy.hpp"
#include "datasets/phantom.hpp"

namespace angio::datasets::detail {

/// Centre lines, radii, sections and the lesion, from the shape's definition: inscribed radii are
/// r(s) itself. Ends count as if the vessel went on past them. The reference diameter is that of
/// the vessel without the stenosis at the narrowest place.
PhantomTruth derive_truth(const Anatomy& anatomy);

}  // namespace angio::datasets::detail
