#include "datasets/phantom.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/units.hpp"
#include "datasets/detail/anatomy.hpp"
#include "datasets/detail/fine_surface.hpp"
#include "datasets/detail/lumen_surface.hpp"
#include "datasets/detail/scan.hpp"
#include "datasets/detail/truth.hpp"

namespace angio::datasets {
namespace {

constexpr double kMarginMm = 6.0;
constexpr double kDefaultBlurVoxels = 0.6;
constexpr std::size_t kLargestVoxelCount = 512u * 512u * 1024u;

/// A turn of the voxel grid around (1, 2, 3), so that no axis keeps its place (Rodrigues).
Mat3 turn(double degrees) {
  const double angle = degrees * units::kPi / 180.0;
  const Vec3 axis = normalized(Vec3{1.0, 2.0, 3.0});
  Mat3 rotation;
  for (int column = 0; column < 3; ++column) {
    Vec3 e;
    e[column] = 1.0;
    const Vec3 turned = std::cos(angle) * e + std::sin(angle) * cross(axis, e) +
                        (1.0 - std::cos(angle)) * dot(axis, e) * axis;
    for (int row = 0; row < 3; ++row) rotation(row, column) = turned[row];
  }
  return rotation;
}

Phantom make_cloth(const PhantomOptions& sized) {
  Phantom phantom;
  phantom.surface = detail::cloth_surface(sized.length_mm);
  return phantom;
}

void add_noise(Volume<float>& volume, double sd, std::uint64_t seed) {
  if (sd <= 0.0) return;
  const std::ptrdiff_t slice = std::ptrdiff_t(volume.geometry.size[0]) * volume.geometry.size[1];
  parallel_for(volume.geometry.size[2], [&](std::ptrdiff_t k) {
    for (std::ptrdiff_t i = k * slice; i < (k + 1) * slice; ++i)
      volume.values[std::size_t(i)] += float(sd * detail::normal_number(seed, std::uint64_t(i)));
  });
}

void check_size(const VolumeGeometry& geometry, double spacing_mm) {
  const double count =
      double(geometry.size[0]) * double(geometry.size[1]) * double(geometry.size[2]);
  if (count <= double(kLargestVoxelCount)) return;
  const double enough = spacing_mm * std::cbrt(count / double(kLargestVoxelCount));
  throw OptionError("phantom.spacing_mm = " + std::to_string(spacing_mm) + " makes " +
                    std::to_string(count * 1e-6) +
                    " million voxels (more than a computer holds). Use at least " +
                    std::to_string(enough));
}

Volume<float> scan(const detail::LumenShape& shape, const VolumeGeometry& geometry,
                   const PhantomOptions& sized, const Progress& progress) {
  const Progress first_part([&](double fraction, std::string_view) {
    progress.report(0.1 + 0.6 * fraction, "scanning the phantom");
  });
  Volume<float> volume = detail::lumen_fraction(shape, geometry, first_part);
  Vec3 blur_voxels{kDefaultBlurVoxels, kDefaultBlurVoxels, kDefaultBlurVoxels};
  for (int axis = 0; axis < 3 && sized.blur_mm > 0.0; ++axis)
    blur_voxels[axis] = sized.blur_mm / geometry.spacing[axis];
  detail::blur(volume, blur_voxels);
  progress.report(0.9, "adding noise");
  const float contrast = float(kLumenIntensity - kBackgroundIntensity);
  for (float& value : volume.values) value = float(kBackgroundIntensity) + contrast * value;
  add_noise(volume, sized.noise_sd * double(contrast), sized.seed);
  return volume;
}

}  // namespace

Phantom make_phantom_surface(const PhantomOptions& options) {
  const PhantomOptions sized = detail::with_size(options);
  if (sized.name == "cloth") return make_cloth(sized);
  const detail::Anatomy anatomy = detail::make_anatomy(sized);
  Phantom phantom;
  phantom.truth = detail::derive_truth(anatomy);
  phantom.surface = detail::usual_surface(anatomy.shape, sized.radius_mm);
  return phantom;
}

TriangleMesh make_paper_surface(const PhantomOptions& options) {
  constexpr int kTubeRing = 20, kTubeRings = 61, kForkRing = 40, kForkRows = 220;
  const PhantomOptions sized = detail::with_size(options);
  const bool is_fork = sized.name == "ytype";
  if (!is_fork && sized.name != "unilateral" && sized.name != "bilateral")
    throw OptionError("the paper gives no mesh that the phantom " + sized.name +
                      " could have (it does for unilateral, bilateral and ytype)");
  const detail::Anatomy anatomy = detail::make_anatomy(sized);
  return is_fork ? detail::fork_wall(anatomy.shape, kForkRing, kForkRows)
                 : detail::tube_wall(anatomy.shape, kTubeRing, kTubeRings);
}

Phantom make_phantom_scan(const PhantomOptions& options, const Progress& progress) {
  const PhantomOptions sized = detail::with_size(options);
  if (sized.name == "cloth")
    throw InputError(
        "the phantom cloth cannot be scanned (it is a sheet without a lumen). "
        "Use --format surface, or another phantom");
  const detail::Anatomy anatomy = detail::make_anatomy(sized);
  const double slice_mm = sized.slice_mm > 0.0 ? sized.slice_mm : sized.spacing_mm;
  const VolumeGeometry geometry =
      detail::grid_around(anatomy.shape, {sized.spacing_mm, sized.spacing_mm, slice_mm}, kMarginMm,
                          turn(sized.oblique_degrees));
  check_size(geometry, sized.spacing_mm);
  Phantom phantom;
  progress.report(0.0, "deriving the truth");
  phantom.truth = detail::derive_truth(anatomy);
  phantom.volume = scan(anatomy.shape, geometry, sized, progress);
  progress.report(1.0);
  return phantom;
}

Phantom make_phantom(const PhantomOptions& options, const Progress& progress) {
  Phantom phantom = make_phantom_scan(options, progress);
  const PhantomOptions sized = detail::with_size(options);
  phantom.surface = detail::usual_surface(detail::make_anatomy(sized).shape, sized.radius_mm);
  return phantom;
}

}  // namespace angio::datasets
