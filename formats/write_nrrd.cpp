#include <zlib.h>

#include <bit>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <sstream>
#include <vector>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "formats/nrrd.hpp"

namespace angio::formats {
namespace {

static_assert(std::endian::native == std::endian::little, "NRRD is written little-endian");

constexpr int kCompressionLevel = 1;  ///< higher ones gain few per cent on such data, at length
constexpr int kGzipWindowBits = 15 + 16;
constexpr std::size_t kChunkBytes = std::size_t(1) << 20;

/// The axes are vectors in LPS: three times "(x,y,z)".
std::string nrrd_header(const VolumeGeometry& geometry, const char* type, const char* encoding) {
  std::ostringstream text;
  text.precision(17);
  text << "NRRD0005\n"
       << "type: " << type << "\ndimension: 3\nspace: left-posterior-superior\nsizes:";
  for (int size : geometry.size) text << ' ' << size;
  text << "\nspace directions:";
  for (int axis = 0; axis < 3; ++axis) {
    text << " (";
    for (int row = 0; row < 3; ++row)
      text << (row > 0 ? "," : "") << geometry.direction(row, axis) * geometry.spacing[axis];
    text << ')';
  }
  text << "\nkinds: domain domain domain\nendian: little\nencoding: " << encoding
       << "\nspace origin: (" << geometry.origin.x << ',' << geometry.origin.y << ','
       << geometry.origin.z << ")\n\n";
  return text.str();
}

/// Appends the gzip stream of some bytes; its time stamp is zero, so that it is reproducible.
void write_gzip(std::ofstream& file, const unsigned char* bytes, std::size_t size) {
  z_stream stream{};
  if (deflateInit2(&stream, kCompressionLevel, Z_DEFLATED, kGzipWindowBits, 9,
                   Z_DEFAULT_STRATEGY) != Z_OK)
    throw IoError("not enough memory to compress a volume. Close programs, or crop the volume");
  const std::unique_ptr<z_stream, int (*)(z_stream*)> end(&stream, deflateEnd);
  std::vector<unsigned char> out(kChunkBytes);
  int status = Z_OK;
  do {
    if (stream.avail_in == 0 && size > 0) {
      const std::size_t count = std::min(size, kChunkBytes);
      stream.next_in = const_cast<unsigned char*>(bytes);  // zlib only reads it
      stream.avail_in = uInt(count);
      bytes += count;
      size -= count;
    }
    stream.next_out = out.data();
    stream.avail_out = uInt(out.size());
    status = deflate(&stream, size == 0 ? Z_FINISH : Z_NO_FLUSH);
    file.write(reinterpret_cast<const char*>(out.data()),
               std::streamsize(out.size() - stream.avail_out));
  } while (status == Z_OK || status == Z_BUF_ERROR);
  if (status != Z_STREAM_END) throw InternalError("zlib could not compress a volume");
}

template <class Value>
void write(const std::filesystem::path& path, const Volume<Value>& volume, const char* type,
           NrrdEncoding encoding) {
  const bool is_packed = encoding == NrrdEncoding::gzip;
  if (path.extension() != ".nrrd") throw InternalError("volumes are written as .nrrd only");
  write_atomically(path, [&](const std::filesystem::path& temporary) {
    errno = 0;
    std::ofstream file(temporary, std::ios::binary);
    if (!file)
      throw IoError("cannot create " + path.string() + " (" + std::strerror(errno) +
                        "). Check the folder's permissions, or choose another with -o",
                    ExitCode::cannot_create);
    const std::string header = nrrd_header(volume.geometry, type, is_packed ? "gzip" : "raw");
    file.write(header.data(), std::streamsize(header.size()));
    const auto* bytes = reinterpret_cast<const unsigned char*>(volume.values.data());
    const std::size_t size = volume.values.size() * sizeof(Value);
    if (is_packed)
      write_gzip(file, bytes, size);
    else
      file.write(reinterpret_cast<const char*>(bytes), std::streamsize(size));
    file.close();
    if (!file)
      throw IoError("could not write " + path.string() + " (" + std::strerror(errno) +
                    "). Is the disk full?");
  });
}

}  // namespace

void write_nrrd(const std::filesystem::path& path, const Volume<float>& volume,
                NrrdEncoding encoding) {
  write(path, volume, "float", encoding);
}

void write_nrrd(const std::filesystem::path& path, const Volume<std::uint8_t>& volume,
                NrrdEncoding encoding) {
  write(path, volume, "uint8", encoding);
}

}  // namespace angio::formats
