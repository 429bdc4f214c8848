#pragma once

#include <string>

#include "segmentation/detail/dicom_header.hpp"

namespace angio::segmentation::detail {

/// Does a run say that it turns: by as many degrees as depth needs, or by its motion?
/// @param run  its angles settled
bool turns(const ProjectionRun& run);

/// Why it is not known how a picture sees the patient, and what would do; empty: it is.
std::string refusal_of_distances(const ProjectionRun& run);

/// Why no volume can be made of a run that turns, and what would do; empty: one can.
std::string refusal_of_turn(const DicomHeader& header, const ProjectionRun& run);

}  // namespace angio::segmentation::detail
