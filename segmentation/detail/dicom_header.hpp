#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/vec3.hpp"

namespace angio::segmentation::detail {

/// What a DICOM object says of one frame (a single-frame object has one).
struct DicomFrame {
  bool has_position = false;
  bool has_orientation = false;
  bool has_spacing = false;
  Vec3 position;           ///< of the first pixel's centre, LPS [mm]
  Vec3 axis_i;             ///< direction of growing column index, as written
  Vec3 axis_j;             ///< direction of growing row index, as written
  double spacing_i = 0.0;  ///< between columns [mm]
  double spacing_j = 0.0;  ///< between rows [mm]
  double slope = 1.0;      ///< value = slope * stored + intercept
  double intercept = 0.0;
};

enum class DicomKind {
  volume,       ///< slices of a volume: CT, MR, X-Ray 3D Angiographic
  capture,      ///< secondary capture: a volume only if it carries the whole geometry
  projection,   ///< X-ray projections: never a volume
  unsupported,  ///< anything else
};

/// The header of one DICOM object, free of identity but for the UIDs, which stay inside.
struct DicomHeader {
  std::filesystem::path path;
  std::string sop_class_uid;
  std::string sop_class_name;  ///< in words
  DicomKind kind = DicomKind::unsupported;
  std::string series_uid;
  std::string instance_uid;
  std::string transfer_syntax_uid;
  std::string transfer_syntax_name;
  bool compressed = false;
  bool jpeg_2000 = false;
  bool lossy = false;
  bool multi_frame_object = false;  ///< an object that is a whole series by itself
  int rows = 0;
  int columns = 0;
  int bits_allocated = 0;
  int bits_stored = 0;
  int high_bit = 0;
  bool is_signed = false;
  bool is_monochrome1 = false;
  bool has_modality_lut = false;
  std::optional<int> padding_value;  ///< stored value outside the scanned field
  std::vector<DicomFrame> frames;
  std::string problem;  ///< why the object cannot be used, empty if it can
};

/// Reads one file's header with DCMTK, the pixels left on disk.
///
/// @return nothing if the file is not DICOM (or is a DICOMDIR)
std::optional<DicomHeader> read_dicom_header(const std::filesystem::path& path);

}  // namespace angio::segmentation::detail
