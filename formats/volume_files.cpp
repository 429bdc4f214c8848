#include "formats/volume_files.hpp"

#include <zlib.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <sstream>
#include <string>

#include "core/atomic_file.hpp"
#include "core/error.hpp"

namespace angio::formats {
namespace {

static_assert(std::endian::native == std::endian::little, "volumes are written little-endian");

enum class Packing { zlib, gzip };

/// One stream of zlib or gzip; gzip's time stamp is zero.
std::string packed(const std::string& bytes, Packing packing) {
  constexpr int kLevel = 1;  // higher ones gain few per cent on such data, at length
  constexpr int kWindowBits = 15, kGzip = 16;
  z_stream stream{};
  if (deflateInit2(&stream, kLevel, Z_DEFLATED,
                   kWindowBits + (packing == Packing::gzip ? kGzip : 0), 9,
                   Z_DEFAULT_STRATEGY) != Z_OK)
    throw IoError("not enough memory to compress a volume. Close programs, or crop the volume");
  const std::unique_ptr<z_stream, int (*)(z_stream*)> end(&stream, deflateEnd);
  std::string out;
  std::string chunk(std::size_t(1) << 20, '\0');
  std::size_t given = 0;
  int status = Z_OK;
  do {
    if (stream.avail_in == 0 && given < bytes.size()) {
      const std::size_t count = std::min(bytes.size() - given, chunk.size());
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data() + given));
      stream.avail_in = uInt(count);
      given += count;
    }
    stream.next_out = reinterpret_cast<Bytef*>(chunk.data());
    stream.avail_out = uInt(chunk.size());
    status = deflate(&stream, given == bytes.size() ? Z_FINISH : Z_NO_FLUSH);
    out.append(chunk.data(), chunk.size() - stream.avail_out);
  } while (status == Z_OK || status == Z_BUF_ERROR);
  if (status != Z_STREAM_END) throw InternalError("zlib could not compress a volume");
  return out;
}

std::string bytes_of(const Volume<float>& volume) {
  return {reinterpret_cast<const char*>(volume.values.data()),
          volume.values.size() * sizeof(float)};
}

// ---- NIfTI-1 (nifti1.h) ------------------------------------------------------------------------

constexpr std::size_t kHeaderBytes = 348, kVoxelOffset = 352;

template <class Value>
void put(std::string& header, std::size_t offset, Value value) {
  std::memcpy(header.data() + offset, &value, sizeof value);
}

/// The unit quaternion (a, b, c, d) of a rotation, a >= 0: nifti1.h's, by the largest of the four.
struct Quaternion {
  double a = 1.0, b = 0.0, c = 0.0, d = 0.0;
};
Quaternion quaternion_of(const Mat3& r) {
  Quaternion q;
  const double trace = 1.0 + r(0, 0) + r(1, 1) + r(2, 2);
  if (trace > 0.5) {
    q.a = 0.5 * std::sqrt(trace);
    q.b = 0.25 * (r(2, 1) - r(1, 2)) / q.a;
    q.c = 0.25 * (r(0, 2) - r(2, 0)) / q.a;
    q.d = 0.25 * (r(1, 0) - r(0, 1)) / q.a;
    return q;
  }
  const double x = 1.0 + r(0, 0) - r(1, 1) - r(2, 2), y = 1.0 + r(1, 1) - r(0, 0) - r(2, 2),
               z = 1.0 + r(2, 2) - r(0, 0) - r(1, 1);
  if (x >= y && x >= z) {
    q.b = 0.5 * std::sqrt(x);
    q.c = 0.25 * (r(0, 1) + r(1, 0)) / q.b;
    q.d = 0.25 * (r(0, 2) + r(2, 0)) / q.b;
    q.a = 0.25 * (r(2, 1) - r(1, 2)) / q.b;
  } else if (y >= z) {
    q.c = 0.5 * std::sqrt(y);
    q.b = 0.25 * (r(0, 1) + r(1, 0)) / q.c;
    q.d = 0.25 * (r(1, 2) + r(2, 1)) / q.c;
    q.a = 0.25 * (r(0, 2) - r(2, 0)) / q.c;
  } else {
    q.d = 0.5 * std::sqrt(z);
    q.b = 0.25 * (r(0, 2) + r(2, 0)) / q.d;
    q.c = 0.25 * (r(1, 2) + r(2, 1)) / q.d;
    q.a = 0.25 * (r(1, 0) - r(0, 1)) / q.d;
  }
  return q.a < 0.0 ? Quaternion{-q.a, -q.b, -q.c, -q.d} : q;
}

double determinant(const Mat3& m) {
  return m(0, 0) * (m(1, 1) * m(2, 2) - m(1, 2) * m(2, 1)) -
         m(0, 1) * (m(1, 0) * m(2, 2) - m(1, 2) * m(2, 0)) +
         m(0, 2) * (m(1, 0) * m(2, 1) - m(1, 1) * m(2, 0));
}

std::string nifti_header(const VolumeGeometry& grid) {
  std::string header(kVoxelOffset, '\0');
  put(header, 0, std::int32_t(kHeaderBytes));
  put(header, 40, std::int16_t(3));  // dim
  for (std::size_t axis = 0; axis < 3; ++axis)
    put(header, 42 + 2 * axis, std::int16_t(grid.size[axis]));
  for (std::size_t axis = 3; axis < 7; ++axis) put(header, 42 + 2 * axis, std::int16_t(1));
  put(header, 70, std::int16_t(16));  // datatype: float32
  put(header, 72, std::int16_t(32));  // bitpix
  Mat3 ras;                           // of the axes: x and y the other way
  for (int row = 0; row < 3; ++row)
    for (int axis = 0; axis < 3; ++axis)
      ras(row, axis) = (row < 2 ? -1.0 : 1.0) * grid.direction(row, axis);
  const double handedness = determinant(ras) < 0.0 ? -1.0 : 1.0;
  put(header, 76, float(handedness));  // pixdim
  for (std::size_t axis = 0; axis < 3; ++axis)
    put(header, 80 + 4 * axis, float(grid.spacing[int(axis)]));
  put(header, 108, float(kVoxelOffset));
  put(header, 112, 1.0F);             // scl_slope
  header[123] = 2;                    // xyzt_units: mm
  put(header, 252, std::int16_t(1));  // qform_code
  put(header, 254, std::int16_t(1));  // sform_code
  Mat3 proper = ras;
  for (int row = 0; row < 3; ++row) proper(row, 2) *= handedness;
  const Quaternion q = quaternion_of(proper);
  put(header, 256, float(q.b));
  put(header, 260, float(q.c));
  put(header, 264, float(q.d));
  const double origin[3] = {-grid.origin.x, -grid.origin.y, grid.origin.z};
  for (int row = 0; row < 3; ++row) {
    put(header, 268 + 4 * std::size_t(row), float(origin[row]));
    for (int axis = 0; axis < 3; ++axis)
      put(header, 280 + 16 * std::size_t(row) + 4 * std::size_t(axis),
          float(ras(row, axis) * grid.spacing[axis]));
    put(header, 292 + 16 * std::size_t(row), float(origin[row]));
  }
  std::memcpy(header.data() + 344, "n+1", 4);
  return header;
}

}  // namespace

void write_mha(const std::filesystem::path& path, const Volume<float>& volume) {
  const VolumeGeometry& grid = volume.geometry;
  const std::string voxels = packed(bytes_of(volume), Packing::zlib);
  std::ostringstream text;
  text.precision(17);
  text << "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
       << "CompressedData = True\nCompressedDataSize = " << voxels.size() << "\nTransformMatrix =";
  for (int axis = 0; axis < 3; ++axis)  // the axes one after the other
    for (int row = 0; row < 3; ++row) text << ' ' << grid.direction(row, axis);
  text << "\nOffset = " << grid.origin.x << ' ' << grid.origin.y << ' ' << grid.origin.z
       << "\nCenterOfRotation = 0 0 0\nAnatomicalOrientation = RAI\nElementSpacing = "
       << grid.spacing.x << ' ' << grid.spacing.y << ' ' << grid.spacing.z
       << "\nDimSize = " << grid.size[0] << ' ' << grid.size[1] << ' ' << grid.size[2]
       << "\nElementType = MET_FLOAT\nElementDataFile = LOCAL\n";
  write_text_atomically(path, text.str() + voxels);
}

void write_nifti(const std::filesystem::path& path, const Volume<float>& volume) {
  for (const int size : volume.geometry.size)
    if (size > std::numeric_limits<std::int16_t>::max())
      throw InputError("an axis of " + std::to_string(size) +
                       " voxels is more than NIfTI-1 can say. Write .nrrd or .mha");
  write_text_atomically(path,
                        packed(nifti_header(volume.geometry) + bytes_of(volume), Packing::gzip));
}

}  // namespace angio::formats
