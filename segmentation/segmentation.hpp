#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/progress.hpp"
#include "core/volume.hpp"

namespace angio::segmentation {

/// How a warning begins that says why what was found may be bone, bowel or muscle.
inline constexpr const char* kDoubtfulLumen = "the lumen may be no vessel: ";
/// The same of one that many pieces beside it outweigh: organs beside a true aorta do so, too.
inline constexpr const char* kOutweighedLumen = "more looks like vessel than was taken: ";

/// A box along the patient's axes.
struct LpsBox {
  Vec3 low;   ///< LPS [mm]
  Vec3 high;  ///< LPS [mm], above low along each axis
};

struct SegmentationOptions {
  double smallest_radius_mm = 0.4;      ///< thinnest vessel looked for, [0.1, 20]
  double largest_radius_mm = 6.0;       ///< widest vessel looked for by shape, [0.2, 30]
  int scale_count = 4;                  ///< scales of the vessel enhancement, [1, 8]
  std::vector<Vec3> seeds_lps_mm;       ///< points inside the vessel; empty: found automatically
  std::optional<double> intensity_min;  ///< lowest intensity of the lumen; unset: automatic
  std::optional<double> intensity_max;  ///< highest intensity of the lumen; unset: automatic
  bool exclude_bone = true;  ///< keeps bones and organs out that are no vessels by what is inside,
                             ///< and objects that are brighter than the vessels by half their
                             ///< contrast and no tubes (metal, calcium); not with intensity_max
  std::optional<LpsBox> region_lps_mm;  ///< only vessels in it are looked for; unset: everywhere.
                                        ///< In a turned volume: the voxel box around it
  double min_component_mm3 = 5.0;       ///< smaller pieces are noise, [0, 1e6]
  double max_diameter_mm = 0.0;  ///< wider parts are left out, as the heart's chambers beside
                                 ///< coronaries (detail/wide_parts.hpp); 0: none, or [1, 60]
  std::vector<double> labels;  ///< of a label map: those that are lumen; empty: all but background

  void validate() const;  ///< @throws OptionError naming the field
};

struct Segmentation {
  Volume<std::uint8_t> mask;  ///< 1 = lumen; same grid as the level set
  Volume<float> level_set;    ///< signed distance to the lumen's boundary [mm], negative inside
  std::vector<Vec3> seeds_lps_mm;  ///< the seeds that were used
  double lumen_intensity = 0.0;    ///< typical, in the volume's unit
  double background_intensity = 0.0;
  double blur_sd_mm = 0.0;  ///< standard deviation of the scanner's blur, told from the image
  std::vector<Vec3> narrow_lps_mm;  ///< places narrower than the voxels can show, kept open
  std::vector<std::string> warnings;
};

/// Whether a volume holds numbers of structures and no intensities (detail/label_map.hpp).
bool is_label_map(const Volume<float>& volume);

/// Finds the contrast-filled vessels and their sub-voxel boundary. Of a volume that is a label map
/// (detail/label_map.hpp) the lumen is what the labels say, with a smooth boundary.
/// @throws InputError if there is no vessel in it, saying what to try
Segmentation segment_vessels(const Volume<float>& volume, const SegmentationOptions& options,
                             const Progress& progress = {});

}  // namespace angio::segmentation
