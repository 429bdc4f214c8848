#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "angiogram/cone_beam.hpp"
#include "core/progress.hpp"
#include "datasets/phantom.hpp"

namespace angio::datasets {

/// How a phantom is seen by a C-arm that turns around it, or stands still at some places.
struct RotationalRunOptions {
  int frames = 200;  ///< [3, 2000]; of each view, where there are some, [1, 2000]
  /// Where the C-arm stands still, a run for each, up to 12; empty: it turns.
  std::vector<angiogram::CArmAngles> views = {};
  double arc_degrees = 200.0;             ///< from the first frame to the last, [1, 400]
  double source_to_detector_mm = 1200.0;  ///< above the next
  double source_to_isocentre_mm = 800.0;  ///< [300, 2000]
  double noise = 0.02;    ///< sd of a pixel behind the body's middle, as a part of it, [0, 0.5]
  bool body = true;       ///< tissue and bone around the vessels, wider than the detector
  bool mask_run = false;  ///< the same turn once more, before the contrast medium
  double contrast_per_mm = 0.1;  ///< attenuation of the medium above that of blood, (0, 1]: 130 mg
                                 ///< of iodine in a mL
  /// The C-arm's way beside the one that the header tells, drawn for each frame: by which all of it
  /// (each view, where it stands still) is shifted along each axis, and turned around each, sd.
  double wobble_mm = 0.0;       ///< [0, 5]
  double wobble_degrees = 0.0;  ///< [0, 5]
  double frame_time_ms = 33.0;  ///< from a frame to the next, [1, 10000]
  /// The heart's motion: the longest way of a place of the wall from rest to the end of systole, on
  /// which all others depend (detail/organ_motion.hpp). The header then names the R waves.
  double heartbeat_mm = 0.0;         ///< [0, 20]
  double heart_rate_per_min = 70.0;  ///< [30, 200]
  double breathing_mm = 0.0;         ///< the way of all vessels with each breath, [0, 30]
  double breaths_per_min = 15.0;     ///< [4, 60]
  double inflow_s = 0.0;  ///< from the first frame until the medium fills the vessels, everywhere
                          ///< alike, [0, 30]
  bool tells_r_waves = true;  ///< otherwise the header says nothing of the heart

  [[nodiscard]] bool moves() const {
    return heartbeat_mm > 0.0 || breathing_mm > 0.0 || inflow_s > 0.0;
  }
  void validate() const;  ///< @throws OptionError naming the field
};

/// What moves during a run, frame by frame.
struct RunMotion {
  std::vector<double> cardiac_phases;     ///< part of the beat that is over, [0, 1)
  std::vector<double> heart_excursions;   ///< 0: where the truth is; 1: end of systole
  std::vector<Vec3> breathing_shifts_mm;  ///< from breathed out, where the truth is
  std::vector<double> filled_parts;       ///< of the contrast medium, [0, 1]
  std::vector<int> r_wave_frames;         ///< numbered from 0: the nearest to each R wave
};

/// A run around a phantom. The isocentre, which is the origin, lies in the middle of the lumen's
/// box; the detector's field covers the lumen with 6 mm around it, with pixels of the phantom's
/// `spacing_mm` at the isocentre.
struct RotationalRunOfPhantom {
  Phantom phantom;  ///< surface and truth, moved to the isocentre
  RotationalRunOptions options;
  angiogram::CArmMount mount;
  std::vector<double> primary_angles_degrees;    ///< as the header tells
  std::vector<double> secondary_angles_degrees;  ///< the same
  std::vector<angiogram::ConeBeamFrame> frames;  ///< as they are, with the wobble
  RunMotion motion;                              ///< the truth stands for its rest
  std::vector<std::uint16_t> pictures;           ///< shape [frames, rows, columns]
  std::vector<std::uint16_t> masks;              ///< the same, or empty
};

/// Projects a phantom: the way of each ray through the lumen's fine surface, whose vertices lie on
/// the analytic wall (under 0.001 of the radius off between them), and through ellipsoids of tissue
/// and bone; the mean beam of four rays a pixel; quantum noise, whose variance is the beam's.
RotationalRunOfPhantom make_rotational_run(const PhantomOptions& phantom,
                                           const RotationalRunOptions& run,
                                           const Progress& progress = {});

/// Writes the run as multi-frame X-Ray Angiographic objects, run/IM0001.dcm and, of a mask run,
/// run/IM0002.dcm, and truth.json beside, which also holds the true 3 x 4 matrices. Views of a
/// C-arm that stands still are an object each, xa_views/IM0001.dcm, IM0002.dcm, ...
/// @return the folder `run`, or `xa_views`
std::filesystem::path write_rotational_run(const RotationalRunOfPhantom& run,
                                           const PhantomOptions& options,
                                           const std::filesystem::path& folder);

}  // namespace angio::datasets
