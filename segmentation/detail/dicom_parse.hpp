#pragma once

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>

#include <cmath>
#include <optional>
#include <string>

#include "core/vec3.hpp"
#include "segmentation/detail/dicom_header.hpp"
#include "segmentation/detail/dicom_load.hpp"

/// DICOM attributes as plain values; only for what runs in a guarded child.
namespace angio::segmentation::detail {

inline std::string text(DcmItem& item, const DcmTagKey& tag, unsigned long position = 0) {
  OFString value;
  if (item.findAndGetOFString(tag, value, position).bad()) return {};
  return {value.c_str()};
}

/// A number of whatever representation (DS, IS, US, UL, FL, FD).
///
/// @param deep  look also into the sequences of the item
inline std::optional<double> number(DcmItem& item, const DcmTagKey& tag, unsigned long position = 0,
                                    bool deep = false) {
  Float64 value = 0.0;
  if (item.findAndGetFloat64(tag, value, position, deep).bad()) {
    OFString written;
    OFBool ok = OFFalse;
    if (item.findAndGetOFString(tag, written, position, deep).bad()) return {};
    value = OFStandard::atof(written.c_str(), &ok);
    if (!ok) return {};
  }
  return std::isfinite(value) ? std::optional<double>(value) : std::nullopt;
}

inline int integer(DcmItem& item, const DcmTagKey& tag) {
  Uint16 value = 0;
  return item.findAndGetUint16(tag, value).good() ? int(value) : 0;
}

inline std::optional<Vec3> vector(DcmItem& item, const DcmTagKey& tag, unsigned long first = 0) {
  Vec3 v;
  for (unsigned long axis = 0; axis < 3; ++axis) {
    const auto value = number(item, tag, first + axis);
    if (!value) return {};
    v[int(axis)] = *value;
  }
  return v;
}

/// The first item of a sequence, or null.
inline DcmItem* first_item(DcmItem& item, const DcmTagKey& sequence) {
  DcmItem* found = nullptr;
  return item.findAndGetSequenceItem(sequence, found, 0).good() ? found : nullptr;
}

/// One file's header, or nothing if it is not DICOM (or is a DICOMDIR).
std::optional<DicomHeader> parse_header(DicomLoader& loader, const DicomSource& source);

/// Geometry, rescale and phase of every frame.
void parse_frames(DcmDataset& dataset, int frame_count, DicomHeader& header);

/// Angles, distances, spacing and field of a run of projections.
ProjectionRun parse_projection_run(DcmDataset& dataset, int frame_count);

/// When the frames of a run were taken, and when the heart beat, as ProjectionRun holds it.
///
///     frame pointer's R wave k:   t(frame k)                  (PS3.3, C.8.7.1)
///     enhanced, of each frame:    t(frame) - trigger delay    (C.7.6.16.2.7), once a beat
///
/// Times that do not fit the number of frames are left out, with a note.
void parse_run_times(DcmDataset& dataset, int frame_count, ProjectionRun& run);

/// Every value of an attribute of decimal numbers; none where one is not finite.
std::vector<double> decimal_numbers(DcmItem& item, const DcmTagKey& tag);

}  // namespace angio::segmentation::detail
