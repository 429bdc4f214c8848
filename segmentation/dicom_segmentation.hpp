#pragma once

#include <cstdint>
#include <filesystem>

#include "core/volume.hpp"
#include "dicom/identity.hpp"
#include "segmentation/read_volume.hpp"

namespace angio::segmentation {

struct DicomSegmentationOptions {
  /// Copy the patient's and the study's attributes (name, number, dates) from the source, so that
  /// an archive files the object with its scan. Without it these are left empty.
  bool keep_patient = false;
};

/// Writes the lumen as a DICOM Segmentation object on the slices of the scan that it was found in.
///
/// A pixel of a source slice is lumen if the level set is below zero at its centre, by trilinear
/// interpolation; slices without lumen are left out. The object refers to the source's study,
/// series, frame of reference and, frame by frame, its slices, as viewers need to show it: it holds
/// these UIDs, and is readable by its owner only (0600). Its own UIDs follow from the source's and
/// from the lumen: the same input gives the same bytes.
///
/// @param path            of the object, e.g. "lumen_segmentation.dcm"
/// @param level_set       [mm], negative inside, on any grid in LPS
/// @param source          what was given to read_volume, DICOM; it is read again for its UIDs
/// @param source_options  as given to read_volume, so that the same series is taken
/// @throws InputError if the source is not DICOM, or the lumen does not lie in it
void write_dicom_segmentation(const std::filesystem::path& path, const Volume<float>& level_set,
                              const std::filesystem::path& source,
                              const ReadOptions& source_options,
                              const DicomSegmentationOptions& options = {});

/// The same of a mask on a grid of its own, without a source: for a case whose link to its scan is
/// not kept, or that has none.
///
/// @param mask      1 inside, on any grid in LPS
/// @param identity  whose it is said to be
/// @throws InputError if the mask is empty
void write_dicom_segmentation(const std::filesystem::path& path, const Volume<std::uint8_t>& mask,
                              const dicom::StudyIdentity& identity);

}  // namespace angio::segmentation
