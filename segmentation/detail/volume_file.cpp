#include "segmentation/detail/volume_file.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <system_error>

#include "core/child_process.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "segmentation/detail/available_memory.hpp"
#include "segmentation/detail/file_completeness.hpp"
#include "segmentation/detail/format_number.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr double kMostSkew = 1e-3;
constexpr double kRoundedDecimals = 1e-5;  ///< skew that needs no word
constexpr std::size_t kMaxVoxelCount = std::size_t(1) << 31;

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
  const std::string name = lower_case(path.filename().string());
  if (name.ends_with(".nrrd") || name.ends_with(".nhdr")) return "NRRD";
  if (name.ends_with(".mha") || name.ends_with(".mhd")) return "MetaImage";
  if (name.ends_with(".nii") || name.ends_with(".nii.gz")) return "NIfTI";
  if (name.ends_with(".vti") || name.ends_with(".vtk")) return "VTK image";
  if (name.ends_with(".tif") || name.ends_with(".tiff")) return "TIFF";
  return {};
}

namespace {

VolumeFile parse(const std::filesystem::path& path, VolumePart part, const ReadOptions& options) {
  const std::string format = volume_file_format(path);
  if (format == "VTK image") check_complete(path, part);  // VTK reads the voxels for a header, too
  VolumeFile file = format == "VTK image" ? load_vti(path, part)
                    : format == "NIfTI"   ? load_nifti(path, part)
                                          : load_with_itk(path, part, options);
  make_right_handed(file, path.filename().string());
  if (format != "VTK image") check_complete(path, part);  // after what is refused by name
  return file;
}

/// A header of VTK's holds the whole image, so it may take as much as the file.
ChildLimits limits_for(const std::filesystem::path& path, std::uint64_t voxel_count) {
  std::error_code ignored;
  const auto size = std::size_t(std::filesystem::file_size(path, ignored));
  constexpr std::size_t kWorstBytesPerVoxel = 24;  // doubles, converted and copied
  constexpr std::size_t kBytesPerSecond = std::size_t(1) << 20;
  // MetaIO never comes back from some headers; a busy machine may take longer than its processor.
  constexpr int kOfProcessor = 20, kInAll = 120;
  const int for_bytes = int(std::min<std::size_t>(size / kBytesPerSecond, 86400));
  const std::string extension = lower_extension(path);
  const bool lies_beside = extension == ".mhd" || extension == ".nhdr";
  return {(std::size_t(2) << 30) + 32 * std::min(size, std::size_t(1) << 38) +
              kWorstBytesPerVoxel * std::size_t(voxel_count),
          kOfProcessor + for_bytes,
          double(kInAll + for_bytes),
          {{lies_beside ? std::filesystem::absolute(path).parent_path() : path}, {}}};
}

VolumeFile load_guarded(const std::filesystem::path& path, VolumePart part,
                        const ReadOptions& options, std::uint64_t voxel_count) {
  VolumeFile file;
  const ChildResult result = run_guarded(
      limits_for(path, voxel_count),
      [&](ChildOutput& output) {
        const VolumeFile parsed = parse(path, part, options);
        output.put(parsed.volume.geometry);
        output.put(parsed.unit_mm);
        output.put(std::uint64_t(parsed.warnings.size()));
        for (const auto& warning : parsed.warnings) output.put(warning);
        output.write(parsed.volume.values.data(), parsed.volume.values.size() * sizeof(float));
      },
      [&](ChildInput& input) {
        input.get(file.volume.geometry);
        input.get(file.unit_mm);
        std::uint64_t warning_count = 0;
        input.get(warning_count);
        for (std::uint64_t w = 0; w < warning_count; ++w) input.get(file.warnings.emplace_back());
        if (file.volume.geometry.voxel_count() != voxel_count) return;  // changed while it was read
        file.volume.values.resize(voxel_count);
        input.read(file.volume.values.data(), voxel_count * sizeof(float));
      });
  if (result.end == ChildEnd::refused) throw InputError(result.message);
  if (result.end != ChildEnd::done)
    throw InputError("cannot read " + path.filename().string() +
                     (result.end == ChildEnd::timed_out
                          ? " (it takes minutes: damaged, or on a slow disk). Copy it again"
                      : result.end == ChildEnd::out_of_memory
                          ? " (it asks for more memory than its voxels could take; it is damaged, "
                            "or memory is short). Copy it again, or close programs"
                          : " (it is damaged). Copy or export it again"));
  return file;
}

}  // namespace

VolumeFile load_volume_file(const std::filesystem::path& path, VolumePart part,
                            const ReadOptions& options) {
  VolumeFile header = load_guarded(path, VolumePart::header, options, 0);
  if (part == VolumePart::header) return header;
  const std::uint64_t voxel_count = header.volume.geometry.voxel_count();
  const std::string name = path.filename().string();
  check_memory(3 * voxel_count * sizeof(float), options.max_memory_gib, name);
  VolumeFile whole = load_guarded(path, part, options, voxel_count);
  if (whole.volume.values.size() != voxel_count)
    throw InputError("cannot read " + name + " (it changed while it was read). Try again");
  return whole;
}

void make_right_handed(VolumeFile& file, const std::string& name) {
  VolumeGeometry& geometry = file.volume.geometry;
  check_grid(geometry, name);
  const Vec3 i = normalized(column(geometry.direction, 0));
  const Vec3 j = normalized(column(geometry.direction, 1));
  const Vec3 k = normalized(column(geometry.direction, 2));
  const double skew = std::max({std::abs(dot(i, j)), std::abs(dot(i, k)), std::abs(dot(j, k))});
  if (!(skew < kMostSkew))
    throw InputError(name +
                     " has axes that are not at right angles (lengths would be wrong). "
                     "Resample it to a regular grid");
  if (skew > kRoundedDecimals)
    file.warnings.push_back("the axes were off the right angle by " + format_number(skew) +
                            "; they were made orthogonal");
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
