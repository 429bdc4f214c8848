#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "angiogram/cone_beam.hpp"
#include "core/backend.hpp"
#include "core/progress.hpp"
#include "core/volume.hpp"

/// From the X-ray frames of a rotational run to a volume.
namespace angio::reconstruction {

/// The pictures of a run, read when they are needed.
class FrameReader {
 public:
  FrameReader() = default;
  FrameReader(const FrameReader&) = delete;
  FrameReader& operator=(const FrameReader&) = delete;
  virtual ~FrameReader() = default;
  /// Frames [first, first + count) one behind the other, rows from the top.
  /// @return pixels as the run has them, shape [count, rows, columns]
  [[nodiscard]] virtual std::vector<float> read(int first, int count) const = 0;
  /// The same, put where the caller wants them.
  virtual void read_into(int first, int count, float* pixels) const {
    const std::vector<float> all = read(first, count);
    std::copy(all.begin(), all.end(), pixels);
  }
  /// Frames that need not follow each other.
  /// @return shape [frames.size(), rows, columns]
  [[nodiscard]] virtual std::vector<float> read_some(const std::vector<int>& frames) const {
    std::vector<float> pixels;
    for (const int frame : frames) {
      const std::vector<float> one = read(frame, 1);
      pixels.insert(pixels.end(), one.begin(), one.end());
    }
    return pixels;
  }
};

/// How pixels tell the beam (DICOM PS3.3 C.8.7.1.1.2, Pixel Intensity Relationship).
enum class PixelRelation {
  linear,       ///< proportional to the beam's intensity
  logarithmic,  ///< to its logarithm, at a scale that is not said
};

/// Columns first, last, rows first, last, numbered from 0, that shutter and collimator leave open.
struct OpenField {
  int first_column = 0, last_column = 0, first_row = 0, last_row = 0;
};

inline OpenField whole_field(const angiogram::ConeBeamFrame& frame) {
  return {0, frame.columns - 1, 0, frame.rows - 1};
}

/// A rotational run: contrast medium in the vessels, and the same turn without it where there is
/// one.
struct RotationalRun {
  std::vector<angiogram::ConeBeamFrame> frames;  ///< in the order of time, all of one size
  const FrameReader* pictures = nullptr;
  const FrameReader* masks = nullptr;  ///< frame by frame, or null
  PixelRelation relation = PixelRelation::linear;
  std::optional<OpenField> open_field = {};
  std::vector<double> times_s = {};    ///< of each frame; empty: not known
  std::vector<double> r_waves_s = {};  ///< of the heart, on the same clock, ascending
};

/// The ramp filter's window: what it leaves of the finest detail, and of the noise.
enum class FilterWindow { ram_lak, shepp_logan, hann };
inline constexpr const char* kFilterWindowNames[] = {"ram-lak", "shepp-logan", "hann"};

/// Neighbouring frames that lie further apart than this are few views [degrees]: back-projection
/// then loses vessels in streaks, below it is the more accurate (docs/results/rotational-runs.md).
inline constexpr double kFewViewsDegrees = 16.0;

/// Frames that a volume is made of, at least.
inline constexpr int kLeastViews = 6;

/// How frames become a volume.
enum class Method {
  automatic,  ///< few_views where frames lie more than kFewViewsDegrees apart
  fdk,        ///< filtered back-projection: needs many frames, keeps bone and tissue
  few_views,  ///< the vessels alone, by iteration (detail/few_views.hpp)
};
inline constexpr const char* kMethodNames[] = {"auto", "fdk", "few-views"};

/// Whether the frames of one phase of the heart are taken alone.
enum class Gating {
  automatic,  ///< where the vessels move with the heart, and three beats or more are in the run
  off,
  on,  ///< also where nothing is seen to move, by R waves
};
inline constexpr const char* kGatingNames[] = {"auto", "off", "on"};

struct ReconstructionOptions {
  Method method = Method::automatic;
  Gating gating = Gating::automatic;
  double phase_percent = 75.0;  ///< of the way from R wave to R wave, [0, 100); 75: the heart rests
  double phase_width_percent = 20.0;  ///< that frames are taken from, around it, [2, 100]
  double voxel_mm = 0.0;   ///< edge of a voxel, [0.05, 5]; 0: a pixel's size at the isocentre
  int largest_side = 512;  ///< voxels along an edge, [16, 2048]; where `voxel_mm` is 0, the voxels
                           ///< grow until they are no more
  double air = 0.0;  ///< a pixel's value where nothing is in the beam, >= 0; 0: the brightest in
                     ///< it. Without air in the run that is too low, and so is all attenuation
  /// Find the C-arm's real path from the vessels where it is not the header's, by more than 0.3
  /// pixels (or voxels, where they are larger).
  bool calibrate = true;
  FilterWindow window = FilterWindow::shepp_logan;
  Backend backend = Backend::automatic;

  /// @throws OptionError naming the bad field
  void validate() const;
};

/// How a run's heartbeat was told, and used.
struct GatingQuality {
  bool is_gated = false;
  bool by_r_waves = false;          ///< otherwise by what is seen in the frames
  double heart_rate_per_min = 0.0;  ///< 0: not looked for
  double beats = 0.0;               ///< in the run
  /// The vessels' motion along the axis that comes back with each beat, root mean square, and how
  /// sure it is (detail/heart_signal.hpp).
  double signal_rms_mm = 0.0;
  double signal_f_ratio = 0.0;
};

/// What a run could give.
struct RunQuality {
  int frame_count = 0;
  double arc_degrees = 0.0;           ///< half a step beyond the first and the last frame
  double shortest_arc_degrees = 0.0;  ///< that sees all of the field from all sides: 180 + the fan
  double largest_step_degrees = 0.0;  ///< between frames
  double source_to_isocentre_mm = 0.0;
  double pixel_at_isocentre_mm = 0.0;
  double field_radius_mm = 0.0;    ///< around the axis, that every frame sees
  double unattenuated = 0.0;       ///< what a pixel has in air; 0 with masks, which need none
  double truncated_percent = 0.0;  ///< rows of frames that end within the body
  double noise_per_mm =
      0.0;  ///< sd between neighbouring voxels, of what is neither vessel nor edge
  bool is_subtracted = false;
  Method method = Method::fdk;  ///< that was used
  int iterations = 0;           ///< of few_views
  bool has_converged = true;    ///< those were enough
  /// Of few_views: between the frames' line integrals and the volume's, where vessels are, and
  /// the frames' own noise; root mean square.
  double line_integral_residual = std::numeric_limits<double>::quiet_NaN();
  double line_integral_noise = std::numeric_limits<double>::quiet_NaN();
  /// How far the frames see the vessels from where the volume has them, root mean square [pixels]:
  /// by the geometry as given, and as it was used. NaN: not measured, or nothing to measure by.
  double given_residual_pixels = std::numeric_limits<double>::quiet_NaN();
  double residual_pixels = std::numeric_limits<double>::quiet_NaN();
  int calibration_passes = 0;
  GatingQuality gating = {};
};

/// For how long a GPU computed, by its own clock, without reading and copying.
struct GpuSeconds {
  double filtering = 0.0;  ///< pixels to filtered frames on their planes
  double projecting = 0.0;
};

struct Reconstruction {
  /// Linear attenuation [1/mm]; subtracted, or of few views: that of the contrast medium alone.
  Volume<float> volume;
  std::vector<angiogram::ConeBeamFrame> frames;  ///< all, where they were taken to be
  std::vector<int> used;                         ///< those that the volume is made of, ascending
  RunQuality quality;
  std::string backend;  ///< "cpu" or "cuda"
  std::string device;   ///< the GPU's name; empty on the CPU
  GpuSeconds gpu;       ///< of the last pass
  /// Why vessels and their widths are not determined: the arc is over 20 degrees too short. Empty:
  /// they are. In phantoms a stenosis of 60 % is read 2 to 4 points off 15 degrees short, 10 points
  /// 30 short, 26 points 50 short, where there are false vessels, too.
  std::string doubt;
  std::vector<std::string> warnings;
};

/// What a run will give, by where its frames were taken alone.
struct RunForecast {
  RunQuality quality;   ///< as far as it needs no pixels
  VolumeGeometry grid;  ///< of the volume
  /// By which a radius may be wrong, root mean square, where the patient and the table stand still:
  /// a tenth of a pixel at the isocentre or a voxel, whichever is more; a fifth of it where streaks
  /// are to be expected (`is_sparse`). From phantoms (docs/results/rotational-runs.md). NaN where
  /// the arc is shorter than the field needs: vessels are blurred along one direction.
  double radius_error_mm = std::numeric_limits<double>::quiet_NaN();
  bool is_sparse = false;  ///< steps of more than 3.5 degrees (60 frames over 200 degrees)
};

/// @param frames     of one size
/// @param has_masks  are they to be subtracted?
/// @param open       RotationalRun::open_field
/// @throws InputError  as reconstruct_volume(), for what no pixels are needed
RunForecast forecast_run(const std::vector<angiogram::ConeBeamFrame>& frames, bool has_masks,
                         const ReconstructionOptions& options,
                         const std::optional<OpenField>& open = {});

/// What gating will leave of a run, should its vessels move.
struct HeartForecast {
  double beats_per_min = 0.0;
  double beats = 0.0;    ///< within the run
  int phase_frames = 0;  ///< of options.phase_percent
};
/// @return nothing without two R waves
std::optional<HeartForecast> forecast_heart(const std::vector<double>& times_s,
                                            const std::vector<double>& r_waves_s,
                                            const ReconstructionOptions& options);

/// Reconstructs a volume. Where the vessels are seen to move with the heart, the frames of one of
/// its phases are taken alone (detail/gating.hpp); few frames are iterated over
/// (detail/few_views.hpp), many go through filtered back-projection (Feldkamp, Davis, Kress, J.
/// Opt. Soc. Am. A 1:612, 1984, eq. 34), on an arc of any length:
///
///     f(x) = sum_i dbeta_i (R / (R - x . s_i))^2 (w p R / sqrt(R^2 + u^2 + v^2) * h)(u(x), v(x))
///
/// p: line integrals; u, v: on the plane through the axis that faces the source; s: towards the
/// source, from the axis; h: the ramp; w: the weight of a ray that is measured more than once
/// (detail/ray_weights.hpp). Any path of the source near a circle does: each frame is first brought
/// onto its plane.
///
/// @param run  at least 40 degrees of arc, kLeastViews frames
/// @return     voxels outside the field that every frame sees have the median of those inside
/// @throws InputError   with what the run is, and what would do
/// @throws Error        ExitCode::unavailable: Backend::cuda, and the GPU fails or there is none
Reconstruction reconstruct_volume(const RotationalRun& run, const ReconstructionOptions& options,
                                  const Progress& progress = {});

}  // namespace angio::reconstruction
