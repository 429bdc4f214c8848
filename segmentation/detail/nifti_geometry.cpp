#include <zlib.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>

#include "core/error.hpp"
#include "segmentation/detail/format_number.hpp"
#include "segmentation/detail/volume_file.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr int kHeaderBytes = 348;
constexpr double kSameSpacing = 0.01;  ///< relative

/// The fields of a NIfTI-1 header at their places, in the byte order of the file.
class Header {
 public:
  /// @return whether the file is a NIfTI-1
  bool read(const std::filesystem::path& path) {
    const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(gzopen(path.c_str(), "rb"), gzclose);
    if (!file || gzread(file.get(), bytes_.data(), kHeaderBytes) != kHeaderBytes) return false;
    swapped_ = at<std::int32_t>(0) != kHeaderBytes;
    return at<std::int32_t>(0) == kHeaderBytes && bytes_[344] == 'n';
  }

  template <class Number>
  [[nodiscard]] Number at(std::size_t place) const {
    std::array<unsigned char, sizeof(Number)> bytes{};
    for (std::size_t b = 0; b < bytes.size(); ++b)
      bytes[b] = bytes_[place + (swapped_ ? bytes.size() - 1 - b : b)];
    Number number;
    std::memcpy(&number, bytes.data(), sizeof number);
    return number;
  }
  [[nodiscard]] double voxel_size(int axis) const {
    return double(at<float>(76 + 4 * std::size_t(axis + 1)));
  }
  [[nodiscard]] bool has_qform() const { return at<std::int16_t>(252) > 0; }
  [[nodiscard]] bool has_sform() const { return at<std::int16_t>(254) > 0; }
  /// [mm]
  [[nodiscard]] double unit() const {
    const int code = bytes_[123] & 7;
    return code == 1 ? 1000.0 : code == 3 ? 1e-3 : 1.0;
  }

 private:
  std::array<unsigned char, kHeaderBytes> bytes_{};
  bool swapped_ = false;
};

/// Columns: one voxel's step along i, j, k, and the origin; RAS, in the file's unit.
struct Affine {
  Mat3 steps;
  Vec3 origin;
};

Affine sform(const Header& header) {
  Affine affine;
  for (int row = 0; row < 3; ++row) {
    for (int axis = 0; axis < 3; ++axis)
      affine.steps(row, axis) = double(header.at<float>(280 + std::size_t(16 * row + 4 * axis)));
    affine.origin[row] = double(header.at<float>(280 + std::size_t(16 * row + 12)));
  }
  return affine;
}

/// The rotation of a unit quaternion; the third axis turned round if pixdim[0] is negative.
/// Source: NIfTI-1 standard (nifti1.h), "METHOD 2".
Affine qform(const Header& header) {
  const double b = double(header.at<float>(256));
  const double c = double(header.at<float>(260));
  const double d = double(header.at<float>(264));
  const double a = std::sqrt(std::max(0.0, 1.0 - (b * b + c * c + d * d)));
  const Mat3 turn = {{{a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)},
                      {2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b)},
                      {2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - c * c - b * b}}};
  const double handed = header.at<float>(76) < 0.0f ? -1.0 : 1.0;
  Affine affine;
  for (int row = 0; row < 3; ++row) {
    for (int axis = 0; axis < 3; ++axis)
      affine.steps(row, axis) =
          turn(row, axis) * header.voxel_size(axis) * (axis == 2 ? handed : 1.0);
    affine.origin[row] = double(header.at<float>(268 + std::size_t(4 * row)));
  }
  return affine;
}

Affine voxel_sizes(const Header& header) {
  Affine affine;
  for (int axis = 0; axis < 3; ++axis) affine.steps(axis, axis) = header.voxel_size(axis);
  return affine;
}

VolumeGeometry geometry_of(const Affine& affine, double unit) {
  VolumeGeometry geometry;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 step = {-affine.steps(0, axis), -affine.steps(1, axis), affine.steps(2, axis)};
    const double length = norm(step);
    geometry.spacing[axis] = unit * length;
    for (int row = 0; row < 3; ++row)
      geometry.direction(row, axis) = length > 0.0 ? step[row] / length : 0.0;
  }
  geometry.origin = {-unit * affine.origin.x, -unit * affine.origin.y, unit * affine.origin.z};
  return geometry;
}

}  // namespace

std::optional<VolumeGeometry> read_nifti_geometry(const std::filesystem::path& path,
                                                  std::vector<std::string>& warnings) {
  Header header;
  if (!header.read(path)) return {};
  const std::string name = path.filename().string();
  if (!header.has_sform() && !header.has_qform())
    warnings.push_back("the file states no patient space; its axes were taken along the patient's");
  const Affine affine = header.has_sform()   ? sform(header)
                        : header.has_qform() ? qform(header)
                                             : voxel_sizes(header);
  const VolumeGeometry geometry = geometry_of(affine, header.unit());
  for (int axis = 0; axis < 3; ++axis) {
    const double stated = header.unit() * std::abs(header.voxel_size(axis));
    const double used = geometry.spacing[axis];
    if (stated > 0.0 && std::abs(stated - used) > kSameSpacing * std::max(stated, used))
      throw InputError(name + " states two voxel sizes, " + format_number(stated) + " and " +
                       format_number(used) +
                       " mm (pixdim and sform disagree, so no length can be trusted). Correct its "
                       "header");
  }
  return geometry;
}

}  // namespace angio::segmentation::detail
