#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/centerline.hpp"
#include "core/volume.hpp"

/// What a person read in a case (datasets/public_readings.csv, datasets/public_ends.csv), and how a
/// run compares with it.
namespace angio {

/// A place in the file's own coordinates and unit.
struct ReadEnd {
  Vec3 place;
  double diameter = 0.0;  ///< 0: not told
  bool is_by_eye = false;
};

struct Reading {
  std::string case_name, file, split, certainty;
  std::optional<int> ends;  ///< inlets and outlets; unset: not counted
  std::vector<ReadEnd> placed_ends;
  std::vector<Vec3> inlets;  ///< any of them is right; empty: not read
  bool inlets_are_voxels = false;
  std::optional<int> stenoses;  ///< over 50 %
  std::vector<Vec3> stenosis_places, doubtful_places;
};

/// @throws InputError where a table is not as datasets/README.md says
std::vector<Reading> read_readings(const std::filesystem::path& readings_csv,
                                   const std::filesystem::path& ends_csv);

/// From a file's coordinates to the case's: what the program did when it read the file.
struct ReadingFrame {
  double scale = 1.0;   ///< millimetres of the file's unit
  bool is_ras = false;  ///< the file says so
  [[nodiscard]] Vec3 operator()(const Vec3& in_file) const;
};

/// Tells the unit by the boxes of the file's surface and of the case's: the one of mm, inch, cm and
/// m that fits best, so parts that were left out do not matter. Volumes are read in LPS and mm.
ReadingFrame frame_of_case(const std::filesystem::path& input,
                           const std::filesystem::path& case_folder);

/// The reading in the case's coordinates [mm].
///
/// @param volume  voxels to LPS, for readings in voxels; unset: those have no inlet
Reading in_case(Reading reading, const ReadingFrame& frame,
                const std::optional<VolumeGeometry>& volume);

/// Where a line of the tree begins or ends.
struct LineEnd {
  Vec3 place;
  double radius = 0.0;  ///< of the vessel there, by radius_at_end [mm]
};
/// The inlet, then the outlets.
std::vector<LineEnd> ends_of(const CenterlineTree& tree);

/// How many of the ends a person placed have a line's end of their own within 1.5 radii of the
/// vessel there; for those picked by eye, at least within kEyeMm.
int count_found_ends(const std::vector<ReadEnd>& read, const std::vector<LineEnd>& ends);
inline constexpr double kEyeMm = 2.0;  ///< how well a person points on a picture

/// Whether the lines begin within two radii of one of the inlets. @param inlets  not empty
bool is_inlet_right(const std::vector<Vec3>& inlets, const LineEnd& begin,
                    const std::vector<ReadEnd>& placed_ends);

/// A stenosis that the program lists.
struct ListedStenosis {
  std::vector<Vec3> places;  ///< of the line between its edges, and where it is narrowest
  double reference_mm = 0.0;
  double percent = 0.0;  ///< not a number: too narrow to be measured
};
std::vector<ListedStenosis> read_stenoses(const std::filesystem::path& lesions_json,
                                          const CenterlineTree& tree);

struct StenosisCount {
  int found = 0;  ///< of the read ones
  int wrong = 0;  ///< listed, over 50 %, and neither read nor doubtful there
};
/// A listed stenosis of 50 % or more is a read one that lies within a healthy diameter of it.
StenosisCount count_stenoses(const Reading& reading, const std::vector<ListedStenosis>& listed);

}  // namespace angio
