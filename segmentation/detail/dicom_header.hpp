#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/progress.hpp"
#include "core/vec3.hpp"
#include "segmentation/detail/dicom_source.hpp"
#include "segmentation/read_volume.hpp"

namespace angio::segmentation::detail {

/// What can tell slices at the same place apart, in the order in which it is asked.
enum class Phase {
  stack,
  temporal,
  trigger_time,
  echo,
  acquisition,
  image_type,
  time,
  content_time
};
constexpr int kPhaseCount = 8;

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
  std::array<double, kPhaseCount> phase{};  ///< by Phase; 0 if the object does not say
};

enum class DicomKind {
  volume,       ///< slices of a volume: CT, MR, X-Ray 3D Angiographic
  capture,      ///< secondary capture: a volume only if it carries the whole geometry
  projection,   ///< X-ray projections: never a volume
  unsupported,  ///< anything else
};

/// How the pixels of a DICOM object are stored.
struct DicomPixels {
  int rows = 0;
  int columns = 0;
  int bits_allocated = 0;
  int bits_stored = 0;
  int high_bit = 0;
  bool is_signed = false;
  bool is_monochrome1 = false;
  bool has_modality_lut = false;
  bool has_padding = false;
  int padding_first = 0;  ///< stored values from this one
  int padding_last = 0;   ///< to this one mark what lies outside the scanned field

  [[nodiscard]] std::size_t per_frame() const { return std::size_t(rows) * std::size_t(columns); }
};

/// The header of one DICOM object, free of identity but for the UIDs, which stay inside.
struct DicomHeader {
  DicomSource source;
  std::string sop_class_uid;
  std::string sop_class_name;  ///< in words
  DicomKind kind = DicomKind::unsupported;
  std::string series_uid;
  std::string instance_uid;
  std::string concatenation_uid;  ///< of an object that was cut into several files
  std::string transfer_syntax_name;
  bool compressed = false;
  bool jpeg_2000 = false;
  bool lossy = false;
  bool multi_frame_object = false;  ///< an object that is a whole series by itself
  bool is_of_the_heart = false;     ///< the body part that was examined
  bool burned_in = false;           ///< text is written into the pixels
  int instance_number = 0;
  DicomPixels pixels;
  std::vector<DicomFrame> frames;
  std::optional<ProjectionRun> projection;
  std::string problem;  ///< why the object cannot be used, empty if it can
};

/// Reads the headers of some files with DCMTK, the pixels left on disk, in a child process: a file
/// that breaks the parser comes back as a header with a problem. Files that are not DICOM, and a
/// DICOMDIR, are left out.
std::vector<DicomHeader> read_dicom_headers(const std::vector<DicomSource>& sources,
                                            const Progress& progress = {});

}  // namespace angio::segmentation::detail
