#include "datasets/rotational_run.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/units.hpp"
#include "datasets/detail/anatomy.hpp"
#include "datasets/detail/fine_surface.hpp"
#include "datasets/detail/organ_motion.hpp"
#include "datasets/detail/scan.hpp"
#include "datasets/detail/truth.hpp"

namespace angio::datasets {
namespace {

using angiogram::CArmMount;
using angiogram::ConeBeamFrame;

constexpr double kMarginOfFieldMm = 6.0;
constexpr double kAir = 60000.0;  ///< a pixel's value where nothing is in the beam
constexpr double kTissue =
    0.0206;                       ///< [1/mm] at 60 keV: water (NIST, Hubbell, Seltzer, NISTIR 5632)
constexpr double kBone = 0.0604;  ///< cortical bone of 1.92 g/mL, the same source

/// An ellipsoid around the isocentre and what it adds to what lies there.
struct Ellipsoid {
  Vec3 middle, half_axes;
  double attenuation = 0.0;
};

/// A head: skin to skin 150 x 190 x 230 mm, a skull of 6 mm, its base a denser piece behind.
const std::array<Ellipsoid, 4> kBody = {
    {{{}, {75.0, 95.0, 115.0}, kTissue},
     {{}, {70.0, 90.0, 110.0}, kBone - kTissue},
     {{}, {64.0, 84.0, 104.0}, kTissue - kBone},
     {{12.0, 55.0, -20.0}, {18.0, 14.0, 12.0}, kBone - kTissue}}};

double chord(const Ellipsoid& e, const Vec3& from, const Vec3& ray) {
  const auto scaled = [&](const Vec3& v) {
    return Vec3{v.x / e.half_axes.x, v.y / e.half_axes.y, v.z / e.half_axes.z};
  };
  const Vec3 p = scaled(from - e.middle), d = scaled(ray);
  const double a = dot(d, d), b = dot(p, d), c = dot(p, p) - 1.0, root = b * b - a * c;
  return root > 0.0 ? 2.0 * std::sqrt(root) / a : 0.0;
}

double through_body(const Vec3& from, const Vec3& to) {
  const Vec3 ray = normalized(to - from);
  double sum = 0.0;
  for (const Ellipsoid& e : kBody) sum += e.attenuation * chord(e, from, ray);
  return sum;
}

void move(TriangleMesh& mesh, PhantomTruth& truth, const Vec3& by) {
  for (Vec3& vertex : mesh.vertices) vertex += by;
  for (CenterlinePath& path : truth.tree.paths)
    for (Vec3& point : path.points) point += by;
  truth.lesion_point += by;
  for (LesionTruth& lesion : truth.lesions) lesion.lesion_point += by;
}

/// A detector that sees the mesh from all sides.
CArmMount mount_around(const TriangleMesh& mesh, double spacing_mm,
                       const RotationalRunOptions& run) {
  double radius = 0.0, height = 0.0;
  for (const Vec3& v : mesh.vertices) {
    radius = std::max(radius, run.views.empty() ? std::hypot(v.x, v.y) : norm(v));
    height = std::max(height, run.views.empty() ? std::abs(v.z) : norm(v));
  }
  const double margin = kMarginOfFieldMm + run.heartbeat_mm + run.breathing_mm;
  radius += margin;
  height += margin;
  const double away = run.source_to_isocentre_mm;
  if (radius > 0.5 * away)
    throw OptionError("the phantom is too large for a C-arm with its source " +
                      std::to_string(int(away)) + " mm from the isocentre. Use a smaller one");
  const double zoom = run.source_to_detector_mm / away;
  CArmMount mount;
  mount.source_to_detector_mm = run.source_to_detector_mm;
  mount.source_to_isocentre_mm = away;
  mount.column_spacing_mm = mount.row_spacing_mm = spacing_mm * zoom;
  const double half_width = radius * away / std::sqrt(away * away - radius * radius);
  const double half_height = height * away / (away - radius);
  mount.columns = 2 * int(std::ceil(half_width / spacing_mm));
  mount.rows = 2 * int(std::ceil(half_height / spacing_mm));
  mount.central_column = 0.5 * (mount.columns - 1);
  mount.central_row = 0.5 * (mount.rows - 1);
  constexpr int kLargest = 4096;
  if (mount.columns > kLargest || mount.rows > kLargest)
    throw OptionError("phantom.spacing_mm makes frames of " + std::to_string(mount.columns) +
                      " x " + std::to_string(mount.rows) + " pixels. Use a larger one");
  return mount;
}

Vec3 turned(const Vec3& v, const Vec3& axis, double angle) {  // Rodrigues
  return std::cos(angle) * v + std::sin(angle) * cross(axis, v) +
         (1.0 - std::cos(angle)) * dot(axis, v) * axis;
}

/// All of the C-arm shifted and turned around the isocentre.
ConeBeamFrame wobbled(ConeBeamFrame frame, int index, std::uint64_t seed,
                      const RotationalRunOptions& run) {
  const auto drawn = [&](int which) {
    return detail::normal_number(seed ^ 0x77b3ULL, std::uint64_t(8 * index + which));
  };
  const Vec3 shift = run.wobble_mm * Vec3{drawn(0), drawn(1), drawn(2)};
  const Vec3 turn = run.wobble_degrees * units::kPi / 180.0 * Vec3{drawn(3), drawn(4), drawn(5)};
  const double angle = norm(turn);
  const Vec3 axis = normalized(turn);
  frame.source = turned(frame.source, axis, angle) + shift;
  frame.first_pixel = turned(frame.first_pixel, axis, angle) + shift;
  frame.column_step = turned(frame.column_step, axis, angle);
  frame.row_step = turned(frame.row_step, axis, angle);
  return frame;
}

/// Twice as many rays along both sides.
ConeBeamFrame finer(const ConeBeamFrame& frame) {
  ConeBeamFrame fine = frame;
  fine.first_pixel = frame.place(-0.25, -0.25);
  fine.column_step = 0.5 * frame.column_step;
  fine.row_step = 0.5 * frame.row_step;
  fine.columns = 2 * frame.columns;
  fine.rows = 2 * frame.rows;
  return fine;
}

/// The mean beam of each pixel, as a part of the unattenuated one.
struct Beam {
  std::vector<double> filled, empty;  ///< with contrast medium and without
};
Beam beam(const TriangleMesh& lumen, const ConeBeamFrame& frame, const RotationalRunOptions& run,
          double filled_part) {
  const ConeBeamFrame fine = finer(frame);
  const std::vector<double> chords = angiogram::chord_lengths(lumen, fine);
  Beam beam;
  const std::size_t count = std::size_t(frame.columns) * std::size_t(frame.rows);
  beam.filled.assign(count, 0.0);
  beam.empty.assign(count, 0.0);
  for (int row = 0; row < fine.rows; ++row)
    for (int c = 0; c < fine.columns; ++c) {
      const double body = run.body ? through_body(fine.source, fine.place(c, row)) : 0.0;
      const double way = chords[std::size_t(row) * std::size_t(fine.columns) + std::size_t(c)];
      const std::size_t pixel =
          std::size_t(row / 2) * std::size_t(frame.columns) + std::size_t(c / 2);
      beam.empty[pixel] += 0.25 * std::exp(-body);
      beam.filled[pixel] += 0.25 * std::exp(-body - filled_part * run.contrast_per_mm * way);
    }
  return beam;
}

/// Pixel values with quantum noise: of n quanta the sd is sqrt(n).
void expose(const std::vector<double>& beam, double quanta, std::uint64_t seed,
            std::uint64_t first_number, std::uint16_t* pixels) {
  for (std::size_t p = 0; p < beam.size(); ++p) {
    double value = beam[p];
    if (quanta > 0.0)
      value += std::sqrt(beam[p] / quanta) * detail::normal_number(seed, first_number + p);
    pixels[p] = std::uint16_t(std::clamp(std::round(kAir * value), 0.0,
                                         double(std::numeric_limits<std::uint16_t>::max())));
  }
}

/// Quanta of an unattenuated pixel, so that the noise behind the body's middle is as asked for.
double quanta_in_air(const RotationalRunOptions& run) {
  if (run.noise <= 0.0) return 0.0;
  const Vec3 behind{0.0, run.source_to_isocentre_mm, 0.0};
  const double left = run.body ? std::exp(-through_body(behind, -behind)) : 1.0;
  return 1.0 / (left * run.noise * run.noise);
}

}  // namespace

void RotationalRunOptions::validate() const {
  const auto require = [](bool ok, const char* message) {
    if (!ok) throw OptionError(message);
  };
  constexpr std::size_t kMostViews = 12;
  require(frames >= (views.empty() ? 3 : 1) && frames <= 2000,
          "run.frames: must be in [3, 2000], of views in [1, 2000]");
  require(views.size() <= kMostViews, "run.views: must be 12 at most");
  require(views.empty() || !mask_run, "run.mask_run: views have none");
  for (const angiogram::CArmAngles& view : views)
    require(std::abs(view.primary_degrees) <= 180.0 && std::abs(view.secondary_degrees) <= 90.0,
            "run.views: primary angles must be in [-180, 180], secondary ones in [-90, 90]");
  require(arc_degrees >= 1.0 && arc_degrees <= 400.0, "run.arc_degrees: must be in [1, 400]");
  require(source_to_isocentre_mm >= 300.0 && source_to_isocentre_mm <= 2000.0,
          "run.source_to_isocentre_mm: must be in [300, 2000]");
  require(source_to_detector_mm > source_to_isocentre_mm && source_to_detector_mm <= 4000.0,
          "run.source_to_detector_mm: must be above source_to_isocentre_mm, up to 4000");
  require(noise >= 0.0 && noise <= 0.5, "run.noise: must be in [0, 0.5]");
  require(contrast_per_mm > 0.0 && contrast_per_mm <= 1.0,
          "run.contrast_per_mm: must be in (0, 1]");
  require(wobble_mm >= 0.0 && wobble_mm <= 5.0, "run.wobble_mm: must be in [0, 5]");
  require(wobble_degrees >= 0.0 && wobble_degrees <= 5.0, "run.wobble_degrees: must be in [0, 5]");
  require(frame_time_ms >= 1.0 && frame_time_ms <= 10000.0,
          "run.frame_time_ms: must be in [1, 10000]");
  require(heartbeat_mm >= 0.0 && heartbeat_mm <= 20.0, "run.heartbeat_mm: must be in [0, 20]");
  require(heart_rate_per_min >= 30.0 && heart_rate_per_min <= 200.0,
          "run.heart_rate_per_min: must be in [30, 200]");
  require(breathing_mm >= 0.0 && breathing_mm <= 30.0, "run.breathing_mm: must be in [0, 30]");
  require(breaths_per_min >= 4.0 && breaths_per_min <= 60.0,
          "run.breaths_per_min: must be in [4, 60]");
  require(inflow_s >= 0.0 && inflow_s <= 30.0, "run.inflow_s: must be in [0, 30]");
}

RotationalRunOfPhantom make_rotational_run(const PhantomOptions& phantom,
                                           const RotationalRunOptions& run,
                                           const Progress& progress) {
  run.validate();
  const PhantomOptions sized = detail::with_size(phantom);
  if (sized.name == "cloth")
    throw InputError(
        "the phantom cloth cannot be projected (it is a sheet without a lumen). Use another "
        "phantom");
  const detail::Anatomy anatomy = detail::make_anatomy(sized);
  RotationalRunOfPhantom result;
  result.options = run;
  result.phantom.truth = detail::derive_truth(anatomy);
  result.phantom.surface = detail::fine_surface(anatomy.shape, sized.radius_mm);
  move(result.phantom.surface, result.phantom.truth,
       -0.5 * (anatomy.shape.lower_corner() + anatomy.shape.upper_corner()));
  result.mount = mount_around(result.phantom.surface, sized.spacing_mm, run);
  const int frame_count = run.frames * std::max(1, int(run.views.size()));
  for (int f = 0; f < frame_count; ++f) {
    const angiogram::CArmAngles angles =
        run.views.empty()
            ? angiogram::CArmAngles{run.arc_degrees * (double(f) / (run.frames - 1) - 0.5), 0.0}
            : run.views[std::size_t(f / run.frames)];
    result.primary_angles_degrees.push_back(angles.primary_degrees);
    result.secondary_angles_degrees.push_back(angles.secondary_degrees);
    result.frames.push_back(wobbled(angiogram::c_arm_frame(angles, result.mount),
                                    run.views.empty() ? f : f / run.frames, sized.seed, run));
  }
  result.motion = detail::plan_motion(run, sized.seed);
  const std::vector<Vec3> ways =
      run.heartbeat_mm > 0.0 ? detail::systolic_ways(result.phantom.surface, run.heartbeat_mm)
                             : std::vector<Vec3>();
  const std::size_t pixels = std::size_t(result.mount.columns) * std::size_t(result.mount.rows);
  const double quanta = quanta_in_air(run);
  result.pictures.resize(pixels * result.frames.size());
  if (run.mask_run) result.masks.resize(result.pictures.size());
  int done = 0;
  parallel_for_uneven(frame_count, [&](std::ptrdiff_t f) {
    const std::size_t first = std::size_t(f) * pixels;
    const std::size_t frame = std::size_t(f), in_run = frame % std::size_t(run.frames);
    const Beam seen =
        beam(detail::moved_surface(result.phantom.surface, ways, result.motion, in_run),
             result.frames[frame], run, result.motion.filled_parts[in_run]);
    expose(seen.filled, quanta, sized.seed, first, result.pictures.data() + first);
    if (run.mask_run)
      expose(seen.empty, quanta, sized.seed + 1, first, result.masks.data() + first);
#pragma omp critical(angio_rotational_run)
    progress.report(double(++done) / frame_count, "projecting the phantom");
  });
  return result;
}

}  // namespace angio::datasets
