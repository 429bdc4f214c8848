#include "segmentation/detail/volume_file.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/error.hpp"
#include "segmentation/detail/format_number.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kOrthogonalTolerance = 1e-3;
constexpr std::size_t kMaxVoxelCount = std::size_t(1) << 31;

std::string lower_name(const std::filesystem::path& path) {
  std::string name = path.filename().string();
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return char(std::tolower(c)); });
  return name;
}

Vec3 column(const Mat3& m, int c) { return {m(0, c), m(1, c), m(2, c)}; }

void set_columns(Mat3& m, const Vec3& i, const Vec3& j, const Vec3& k) {
  for (int row = 0; row < 3; ++row) {
    m(row, 0) = i[row];
    m(row, 1) = j[row];
    m(row, 2) = k[row];
  }
}

void check_grid(const VolumeGeometry& geometry, const std::string& name) {
  for (int axis = 0; axis < 3; ++axis) {
    const double spacing = geometry.spacing[axis];
    if (geometry.size[std::size_t(axis)] < 2)
      throw InputError(name +
                       " is not three-dimensional (an axis has fewer than 2 voxels). Give "
                       "a volume");
    if (!(spacing > 1e-4 && spacing < 100.0) || !std::isfinite(geometry.origin[axis]))
      throw InputError(name + " has an impossible spacing of " + format_number(spacing) +
                       " mm along an axis (no length can be measured). Correct the header");
  }
  if (geometry.voxel_count() > kMaxVoxelCount)
    throw InputError(name + " has more than 2^31 voxels (too many for this program). Crop it");
}

}  // namespace

bool is_volume_file_name(const std::filesystem::path& path) {
  return !volume_file_format(path).empty();
}

std::string volume_file_format(const std::filesystem::path& path) {
  const std::string name = lower_name(path);
  if (name.ends_with(".nrrd") || name.ends_with(".nhdr")) return "NRRD";
  if (name.ends_with(".mha") || name.ends_with(".mhd")) return "MetaImage";
  if (name.ends_with(".nii") || name.ends_with(".nii.gz")) return "NIfTI";
  if (name.ends_with(".vti")) return "VTK image";
  return {};
}

VolumeFile load_volume_file(const std::filesystem::path& path, VolumePart part) {
  VolumeFile file =
      volume_file_format(path) == "VTK image" ? load_vti(path, part) : load_with_itk(path, part);
  make_right_handed(file, path.filename().string());
  return file;
}

void make_right_handed(VolumeFile& file, const std::string& name) {
  VolumeGeometry& geometry = file.volume.geometry;
  check_grid(geometry, name);
  const Vec3 i = normalized(column(geometry.direction, 0));
  const Vec3 j = normalized(column(geometry.direction, 1));
  const Vec3 k = normalized(column(geometry.direction, 2));
  const double skew = std::max({std::abs(dot(i, j)), std::abs(dot(i, k)), std::abs(dot(j, k))});
  if (!(skew < kOrthogonalTolerance))
    throw InputError(name +
                     " has axes that are not at right angles (lengths would be wrong). "
                     "Resample it to a regular grid");
  const Vec3 third = normalized(cross(i, j));
  const Vec3 second = cross(third, i);
  set_columns(geometry.direction, i, second, third);
  if (dot(third, k) > 0.0) return;

  // Left-handed: the last slice becomes the first.
  const int last = geometry.size[2] - 1;
  geometry.origin = geometry.origin + (geometry.spacing.z * double(last)) * k;
  file.warnings.push_back("the axes were left-handed; the slices were reversed");
  if (file.volume.values.empty()) return;
  const std::size_t slice = std::size_t(geometry.size[0]) * std::size_t(geometry.size[1]);
  auto& values = file.volume.values;
  for (std::size_t a = 0, b = std::size_t(last); a < b; ++a, --b)
    std::swap_ranges(values.begin() + std::ptrdiff_t(a * slice),
                     values.begin() + std::ptrdiff_t((a + 1) * slice),
                     values.begin() + std::ptrdiff_t(b * slice));
}

}  // namespace angio::segmentation::detail
