#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <type_traits>

#include "core/error.hpp"
#include "segmentation/detail/format_number.hpp"
#include "segmentation/detail/volume_file.hpp"

namespace angio::segmentation::detail {
namespace {

constexpr std::size_t kSize1 = 348;  ///< of a header of NIfTI-1
constexpr std::size_t kSize2 = 540;
constexpr double kSameNiftiSpacing = 0.01;  ///< relative
constexpr int kMaxSize = 1 << 20;

/// What a header of either version states.
struct Header {
  std::array<std::int64_t, 8> sizes{};  ///< the count of axes, then voxels along each
  std::array<double, 8> voxel{};        ///< the hand of the qform, then voxel sizes
  int type = 0;
  std::int64_t offset = 0;  ///< of the first voxel in the file
  double slope = 0.0;       ///< value = slope * stored + intercept; 0: as stored
  double intercept = 0.0;
  bool has_qform = false;
  bool has_sform = false;
  std::array<double, 6> turn{};  ///< quaternion b, c, d, and the origin
  std::array<double, 12> rows{};
  double unit = 1.0;     ///< [mm]
  bool swapped = false;  ///< written on a computer of the other byte order
};

using Gzip = std::unique_ptr<gzFile_s, int (*)(gzFile)>;

[[noreturn]] void fail(const std::string& name) {
  throw InputError("cannot read " + name +
                   " (truncated, damaged, or not a NIfTI file). Copy or export it again");
}

template <class Number>
Number number_at(const unsigned char* bytes, bool swapped) {
  std::array<unsigned char, sizeof(Number)> ordered{};
  std::copy_n(bytes, ordered.size(), ordered.begin());
  if (swapped) std::reverse(ordered.begin(), ordered.end());
  Number number;
  std::memcpy(&number, ordered.data(), sizeof number);
  return number;
}

/// Takes fields of one type off a header, at their places.
class Fields {
 public:
  Fields(const std::array<unsigned char, kSize2>& bytes, bool swapped)
      : bytes_(bytes.data()), swapped_(swapped) {}
  template <class Stored, class Wanted>
  void get(std::size_t place, Wanted& wanted) const {
    const Stored number = number_at<Stored>(bytes_ + place, swapped_);
    if constexpr (std::is_floating_point_v<Stored> && std::is_integral_v<Wanted>)
      wanted = std::abs(number) < Stored(std::numeric_limits<int>::max()) ? Wanted(number) : -1;
    else
      wanted = Wanted(number);
  }
  template <class Stored, class Wanted, std::size_t count>
  void get(std::size_t place, std::array<Wanted, count>& wanted) const {
    for (std::size_t n = 0; n < count; ++n) get<Stored>(place + n * sizeof(Stored), wanted[n]);
  }

 private:
  const unsigned char* bytes_;
  bool swapped_;
};

void read_version_1(const Fields& fields, Header& header) {
  int qform = 0;
  int sform = 0;
  fields.get<std::int16_t>(40, header.sizes);
  fields.get<std::int16_t>(70, header.type);
  fields.get<float>(76, header.voxel);
  fields.get<float>(108, header.offset);
  fields.get<float>(112, header.slope);
  fields.get<float>(116, header.intercept);
  fields.get<std::int16_t>(252, qform);
  fields.get<std::int16_t>(254, sform);
  fields.get<float>(256, header.turn);
  fields.get<float>(280, header.rows);
  header.has_qform = qform > 0;
  header.has_sform = sform > 0;
}

void read_version_2(const Fields& fields, Header& header) {
  int qform = 0;
  int sform = 0;
  fields.get<std::int16_t>(12, header.type);
  fields.get<std::int64_t>(16, header.sizes);
  fields.get<double>(104, header.voxel);
  fields.get<std::int64_t>(168, header.offset);
  fields.get<double>(176, header.slope);
  fields.get<double>(184, header.intercept);
  fields.get<std::int32_t>(344, qform);
  fields.get<std::int32_t>(348, sform);
  fields.get<double>(352, header.turn);
  fields.get<double>(400, header.rows);
  header.has_qform = qform > 0;
  header.has_sform = sform > 0;
}

Header read_header(gzFile file, const std::string& name) {
  std::array<unsigned char, kSize2> bytes{};
  const int count = gzread(file, bytes.data(), unsigned(bytes.size()));
  if (count < int(kSize1)) fail(name);
  Header header;
  int unit_code = 0;
  for (const bool swapped : {false, true}) {
    const auto stated = number_at<std::int32_t>(bytes.data(), swapped);
    const Fields fields(bytes, swapped);
    header.swapped = swapped;
    if (stated == std::int32_t(kSize1) && std::memcmp(bytes.data() + 344, "n+1", 4) == 0) {
      read_version_1(fields, header);
      unit_code = bytes[123] & 7;
    } else if (stated == std::int32_t(kSize2) && count == int(kSize2) &&
               std::memcmp(bytes.data() + 4, "n+2", 4) == 0) {
      read_version_2(fields, header);
      fields.get<std::int32_t>(500, unit_code);
      unit_code &= 7;
    } else {
      continue;
    }
    header.unit = unit_code == 1 ? 1000.0 : unit_code == 3 ? 1e-3 : 1.0;
    return header;
  }
  fail(name);
}

void check_sizes(const Header& header, const std::string& name) {
  const std::int64_t axis_count = header.sizes[0];
  if (axis_count < 1 || axis_count > 7) fail(name);
  if (axis_count < 3) throw InputError(name + " is not three-dimensional. Give a volume");
  for (std::size_t axis = 1; axis <= std::size_t(axis_count); ++axis) {
    if (header.sizes[axis] < 1 || header.sizes[axis] > kMaxSize) fail(name);
    if (axis > 3 && header.sizes[axis] > 1)
      throw InputError(name + " has several time points (one volume is needed). Give one of them");
  }
}

/// Columns: one voxel's step along i, j, k, and the origin; RAS, in the file's unit.
struct Affine {
  Mat3 steps;
  Vec3 origin;
};

Affine sform(const Header& header) {
  Affine affine;
  for (int row = 0; row < 3; ++row) {
    for (int axis = 0; axis < 3; ++axis)
      affine.steps(row, axis) = header.rows[std::size_t(4 * row + axis)];
    affine.origin[row] = header.rows[std::size_t(4 * row + 3)];
  }
  return affine;
}

/// The rotation of a unit quaternion; the third axis turned round if pixdim[0] is negative.
/// Source: NIfTI-1 standard (nifti1.h), "METHOD 2".
Affine qform(const Header& header) {
  const double b = header.turn[0];
  const double c = header.turn[1];
  const double d = header.turn[2];
  const double a = std::sqrt(std::max(0.0, 1.0 - (b * b + c * c + d * d)));
  const Mat3 turn = {{{a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)},
                      {2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b)},
                      {2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - c * c - b * b}}};
  Affine affine;
  for (int axis = 0; axis < 3; ++axis) {
    const double size = header.voxel[std::size_t(axis + 1)];
    const double hand = axis == 2 && header.voxel[0] < 0.0 ? -1.0 : 1.0;
    for (int row = 0; row < 3; ++row) affine.steps(row, axis) = turn(row, axis) * size * hand;
    affine.origin[axis] = header.turn[std::size_t(axis + 3)];
  }
  return affine;
}

Affine voxel_sizes(const Header& header) {
  Affine affine;
  for (int axis = 0; axis < 3; ++axis)
    affine.steps(axis, axis) = header.voxel[std::size_t(axis + 1)];
  return affine;
}

VolumeGeometry in_lps(const Affine& affine, double unit) {
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

/// By the sform, else the qform, else the voxel sizes alone.
VolumeGeometry geometry_of(const Header& header, const std::string& name,
                           std::vector<std::string>& warnings) {
  if (!header.has_sform && !header.has_qform)
    warnings.push_back(std::string("the file states ") + kNoPatientSpace +
                       "; its axes were taken along the patient's");
  const Affine affine = header.has_sform   ? sform(header)
                        : header.has_qform ? qform(header)
                                           : voxel_sizes(header);
  VolumeGeometry geometry = in_lps(affine, header.unit);
  for (int axis = 0; axis < 3; ++axis) {
    const double stated = header.unit * std::abs(header.voxel[std::size_t(axis + 1)]);
    const double used = geometry.spacing[axis];
    if (stated > 0.0 && std::abs(stated - used) > kSameNiftiSpacing * std::max(stated, used))
      throw InputError(name + " states two voxel sizes, " + format_number(stated) + " and " +
                       format_number(used) +
                       " mm (pixdim and sform disagree, so no length can be trusted). Correct its "
                       "header");
    geometry.size[std::size_t(axis)] = int(header.sizes[std::size_t(axis + 1)]);
  }
  return geometry;
}

/// Reads the voxels slice by slice, as `Stored`, and scales them.
template <class Stored>
void read_voxels(gzFile file, const Header& header, const std::string& name,
                 Volume<float>& volume) {
  const double slope = header.slope == 0.0 || !std::isfinite(header.slope) ? 1.0 : header.slope;
  const double intercept =
      header.slope == 0.0 || !std::isfinite(header.intercept) ? 0.0 : header.intercept;
  const auto& size = volume.geometry.size;
  const std::size_t row = std::size_t(size[0]) * sizeof(Stored);
  std::vector<unsigned char> bytes(row);
  volume.values.reserve(volume.geometry.voxel_count());
  for (std::size_t j = 0; j < std::size_t(size[1]) * std::size_t(size[2]); ++j) {
    if (gzread(file, bytes.data(), unsigned(row)) != int(row)) fail(name);
    for (std::size_t at = 0; at < row; at += sizeof(Stored)) {
      const auto stored = number_at<Stored>(bytes.data() + at, header.swapped);
      volume.values.push_back(float(slope * double(stored) + intercept));
    }
  }
}

/// A compressed stream must come to its end, which holds its checksum.
void check_end(gzFile file, const std::string& name) {
  std::array<unsigned char, 4096> rest{};
  int count = 0;
  while ((count = gzread(file, rest.data(), unsigned(rest.size()))) > 0) {
  }
  int state = Z_OK;
  gzerror(file, &state);
  if (count < 0 || (state != Z_OK && state != Z_STREAM_END)) fail(name);
}

void read_voxels(gzFile file, const Header& header, const std::string& name,
                 Volume<float>& volume) {
  switch (header.type) {
    case 2:
      return read_voxels<std::uint8_t>(file, header, name, volume);
    case 4:
      return read_voxels<std::int16_t>(file, header, name, volume);
    case 8:
      return read_voxels<std::int32_t>(file, header, name, volume);
    case 16:
      return read_voxels<float>(file, header, name, volume);
    case 64:
      return read_voxels<double>(file, header, name, volume);
    case 256:
      return read_voxels<std::int8_t>(file, header, name, volume);
    case 512:
      return read_voxels<std::uint16_t>(file, header, name, volume);
    case 768:
      return read_voxels<std::uint32_t>(file, header, name, volume);
    case 1024:
      return read_voxels<std::int64_t>(file, header, name, volume);
    default:
      return read_voxels<std::uint64_t>(file, header, name, volume);
  }
}

void check_type(int type, const std::string& name) {
  constexpr std::array kNumbers = {2, 4, 8, 16, 64, 256, 512, 768, 1024, 1280};
  if (std::find(kNumbers.begin(), kNumbers.end(), type) != kNumbers.end()) return;
  throw InputError(name + " has voxels of type " + std::to_string(type) +
                   " (colours, complex numbers or bits, not intensities). Give a volume with one "
                   "number per voxel");
}

}  // namespace

VolumeFile load_nifti(const std::filesystem::path& path, VolumePart part) {
  const std::string name = path.filename().string();
  const Gzip gzip(gzopen(path.c_str(), "rb"), gzclose);  // reads plain files, too
  if (!gzip) fail(name);
  const Header header = read_header(gzip.get(), name);
  check_sizes(header, name);
  check_type(header.type, name);
  VolumeFile file;
  file.volume.geometry = geometry_of(header, name, file.warnings);
  file.unit_mm = header.unit;
  if (part == VolumePart::header) return file;
  if (header.offset < std::int64_t(kSize1) ||
      gzseek(gzip.get(), z_off_t(header.offset), SEEK_SET) < 0)
    fail(name);
  read_voxels(gzip.get(), header, name, file.volume);
  check_end(gzip.get(), name);
  return file;
}

}  // namespace angio::segmentation::detail
