#pragma once

#include <filesystem>
#include <vector>

#include "core/progress.hpp"

namespace angio::pipeline {

/// Whose a case's DICOM objects are said to be.
enum class DicomLink {
  none,    ///< nobody's: the case's name stands for the patient, the study is one of its own
  source,  ///< the scan's patient and study, with references to its images
};

/// Writes a finished case as DICOM objects, for an archive: report.dcm, the report as encapsulated
/// PDF; measurements.dcm, its numbers as a structured report; lumen.dcm, the lumen as segmentation,
/// on the scan's slices where it is linked to it, otherwise on its own grid (not of a case that
/// began with a surface). The same case gives the same bytes.
///
/// @param link  `source` needs what `angio run --keep-link` left, and the scan where it was then
/// @return the files
/// @throws InputError (66) if the case has no report, or no link to its source
std::vector<std::filesystem::path> write_dicom_folder(const std::filesystem::path& case_folder,
                                                      const std::filesystem::path& folder,
                                                      DicomLink link,
                                                      const Progress& progress = {});

/// The report of a case as PDF.
/// @throws InputError (66) if it has none
void write_case_pdf(const std::filesystem::path& case_folder, const std::filesystem::path& file);

}  // namespace angio::pipeline
