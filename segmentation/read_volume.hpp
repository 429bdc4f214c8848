#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/progress.hpp"
#include "core/units.hpp"
#include "core/volume.hpp"

namespace angio::segmentation {

/// In the warning of a volume that does not say how it lies in the patient.
inline constexpr const char* kNoPatientSpace = "no patient space";

/// In the description of a volume whose DICOM names heart or coronary arteries as the body part.
inline constexpr const char* kOfTheHeart = "of the heart";

/// How a projection run's angle increments are meant.
enum class AngleIncrements {
  from_base,   ///< angle_i = base + increment_i, as the standard says (DICOM PS3.3 C.8.7.5.1.3)
  cumulative,  ///< angle_i = angle_(i-1) + increment_i, as some writers mean it
};

struct ReadOptions {
  std::string series = {};   ///< number (1...) or hash from `inspect`; empty: by rule (most voxels)
  std::string views = {};    ///< numbers from `inspect`, as "1,3", of runs of a C-arm that stood
                             ///< still; empty: by rule (segmentation/read_views.hpp)
  bool allow_lossy = false;  ///< measure on lossy-compressed pixels all the same
  /// For a series or file that states none (anonymised): voxel size between columns, rows and
  /// slices [mm], in (1e-4, 100); zeros: refuse such a series. Never overrules what a file states.
  std::array<double, 3> spacing_mm{0.0, 0.0, 0.0};
  /// Of a volume file; unset: as it says, or mm, or by its size where in mm nothing is so small.
  std::optional<LengthUnit> unit = {};
  bool resample = false;  ///< bring unevenly spaced or missing slices onto an even grid
  AngleIncrements angles = AngleIncrements::from_base;
  double max_memory_gib =
      0.0;  ///< refuse what needs more, [0, 65536]; 0: what the computer has free

  /// `views` as numbers, each once, in their order; empty: by rule.
  /// @throws OptionError  they are no numbers from 1, or fewer than two
  [[nodiscard]] std::vector<int> view_numbers() const;
  /// @throws OptionError naming the bad field
  void validate() const;
};

struct LoadedVolume {
  Volume<float> volume;
  std::string source_description;     ///< "CT Image Storage, 256 slices, of the heart"; no identity
  std::vector<std::string> warnings;  ///< e.g. series that were left out, and why
};

/// Reads a DICOM folder, file, DICOMDIR or zip archive, .nrrd .nhdr .mha .mhd .nii .nii.gz .vti
/// .vtk .tif .tiff. Whatever the input holds, the program survives it: files are parsed in a child
/// process.
///
/// @throws InputError (65, or 66 if there is nothing) with the reason and what to do
LoadedVolume read_volume(const std::filesystem::path& path, const ReadOptions& options,
                         const Progress& progress = {});

/// Where lengths on a projection hold.
enum class SpacingPlane {
  unknown,
  detector,    ///< nothing in the patient has this size: it is magnified
  isocentre,   ///< scaled by source-isocentre / source-detector
  calibrated,  ///< of the object that the picture was calibrated on
};

/// What a run of X-ray projections (XA, XRF) says of itself.
struct ProjectionRun {
  std::vector<double> primary_angles_degrees;           ///< one, or one per frame; RAO to LAO grows
  std::vector<double> secondary_angles_degrees;         ///< one, or one per frame; CAU to CRA grows
  std::array<double, 2> base_angles_degrees{0.0, 0.0};  ///< primary, secondary
  bool has_base_angle = true;  ///< false: primary increments count from an angle that is not stated
  std::optional<double> source_to_detector_mm;
  std::optional<double> source_to_isocentre_mm;
  std::optional<double> magnification;         ///< at the isocentre
  std::array<double, 2> spacing_mm{0.0, 0.0};  ///< between columns, rows; 0: not stated
  SpacingPlane spacing_plane = SpacingPlane::unknown;
  std::optional<double> frame_time_ms;  ///< mean
  std::vector<double> frame_times_ms;   ///< of each frame since the first; empty: not stated
  /// Of the heart's R waves, on the same clock, ascending, also outside the run; empty: not stated.
  std::vector<double> r_wave_times_ms;
  std::vector<int> mask_frames;  ///< numbered from 1; digital subtraction
  std::string mask_operation;    ///< e.g. "AVG_SUB", "NONE"; empty: no subtraction
  /// Columns first, last, rows first, last, numbered from 1, that shutter and collimator leave
  /// open.
  std::optional<std::array<int, 4>> open_field;
  /// What each round or polygonal shutter or collimator leaves open: its corners, column and row in
  /// turn, numbered from 1; a pixel is open if it lies within all.
  std::vector<std::vector<double>> open_shapes;
  bool burned_in_text = false;
  std::string positioner_motion;  ///< "STATIC" or "DYNAMIC"; empty: not stated
  std::string pixel_relation;     ///< to the beam's intensity: "LIN", "LOG", "DISP"; empty
  bool is_inverted = false;  ///< less beam has a higher value in the file (Relationship Sign -1)
  bool has_contrast_medium = false;                     ///< one is named
  double table_travel_mm = 0.0;                         ///< from the first frame to the farthest
  std::array<double, 2> detector_spacing_mm{0.0, 0.0};  ///< between columns, rows; 0: not stated
  /// How the picture was turned, clockwise, and then mirrored, since the detector had it.
  double picture_turn_degrees = 0.0;
  bool picture_is_mirrored = false;
  /// Of the picture's middle from the detector's, along columns and rows as the detector has them.
  std::array<double, 2> middle_offset_mm{0.0, 0.0};
  std::vector<std::string> notes;  ///< what is doubtful, and how the spacing was told
};

/// A number that a label map gives to a structure.
struct Label {
  double value = 0.0;
  std::size_t voxel_count = 0;
};

/// One series (or volume file) as `angio inspect` lists it. Nothing in it identifies a patient.
struct SeriesSummary {
  std::string key;   ///< short hash of the series UID, or the file's format
  std::string kind;  ///< SOP class in words, e.g. "CT Image Storage"
  std::string transfer_syntax;
  std::string pixel_format;  ///< e.g. "16 bits, 12 stored, unsigned, MONOCHROME2"
  VolumeGeometry geometry;   ///< meaningful if usable; else the size alone: columns, rows, frames
  int file_count = 0;
  int frame_count = 0;
  bool usable = false;
  bool lossy = false;
  bool resampled = false;     ///< the slices do not lie on a grid; they will be interpolated
  double tilt_degrees = 0.0;  ///< of the stack against its slices (gantry tilt)
  std::string verdict;        ///< "regular grid", or why it is refused and what to do
  std::vector<std::string> warnings;
  std::optional<ProjectionRun> projection;  ///< of a run of projections
  bool is_rotational = false;               ///< it turns, so that a volume can be made of it
  std::vector<Label> labels;  ///< of a volume file that is a label map; empty: an image
};

/// Is it a file, and named as a volume file is? .nrrd .nhdr .mha .mhd .nii .nii.gz .vti .vtk .tif
/// .tiff
bool is_volume_file(const std::filesystem::path& path);

/// Does a folder hold a DICOM object, of whatever kind? Reads headers only.
bool holds_dicom(const std::filesystem::path& folder, const ReadOptions& options = {});

/// Reads headers only; of a volume file the voxels, too, which tells a label map from an image.
std::vector<SeriesSummary> inspect(const std::filesystem::path& path,
                                   const ReadOptions& options = {});

/// Reads the volume of any volume file (no DICOM).
Volume<float> read_volume_file(const std::filesystem::path& path);

}  // namespace angio::segmentation
