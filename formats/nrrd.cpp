#include "formats/nrrd.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>

#include "core/error.hpp"
#include "core/frames.hpp"
#include "formats/detail/surface_cleanup.hpp"
#include "formats/tokens.hpp"

namespace angio::formats {
namespace {

constexpr std::size_t kMaxVoxels = 4'000'000'000ull;

[[noreturn]] void fail(const std::string& name, const std::string& why) {
  throw InputError(name + " cannot be read (" + why + "). Run the segmentation stage again");
}

struct Header {
  std::map<std::string, std::string> fields;
  std::size_t size = 0;  ///< [byte]

  [[nodiscard]] std::string get(const std::string& key) const {
    const auto found = fields.find(key);
    return found == fields.end() ? std::string() : found->second;
  }
};

Header parse_header(std::string_view bytes, const std::string& name) {
  Header header;
  Lines lines(bytes);
  const auto magic = lines.next();
  if (!magic || !magic->starts_with("NRRD000")) fail(name, "it is not an NRRD file");
  while (const auto line = lines.next()) {
    if (line->empty()) {
      header.size = lines.position();
      return header;
    }
    const auto colon = line->find(": ");
    if (line->front() != '#' && colon != std::string_view::npos)
      header.fields[std::string(line->substr(0, colon))] = line->substr(colon + 2);
  }
  fail(name, "its header has no end");
}

/// "(1,2,3)" and lists of such.
std::vector<double> parse_numbers(std::string text) {
  for (char& letter : text)
    if (letter == '(' || letter == ')' || letter == ',') letter = ' ';
  std::vector<double> numbers;
  Tokens tokens(text);
  for (auto word = tokens.next(); !word.empty(); word = tokens.next())
    numbers.push_back(
        parse_number<double>(word).value_or(std::numeric_limits<double>::quiet_NaN()));
  return numbers;
}

VolumeGeometry parse_geometry(const Header& header, const std::string& name) {
  VolumeGeometry grid;
  const auto sizes = parse_numbers(header.get("sizes"));
  if (header.get("dimension") != "3" || sizes.size() != 3) fail(name, "it is not a 3D volume");
  double count = 1.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(sizes[axis] >= 1.0 && sizes[axis] < 1e6)) fail(name, "its size is absurd");
    grid.size[axis] = int(sizes[axis]);
    count *= sizes[axis];
  }
  if (count > double(kMaxVoxels)) fail(name, "its size is absurd");
  auto axes = parse_numbers(header.get("space directions"));
  auto origin = parse_numbers(header.get("space origin"));
  if (axes.size() != 9 || origin.size() != 3) fail(name, "its place in the patient is missing");
  const std::string space = header.get("space");
  if (space == "right-anterior-superior" || space == "RAS") {
    for (std::size_t i = 0; i < 9; ++i)
      if (i % 3 != 2) axes[i] = -axes[i];
    origin[0] = -origin[0];
    origin[1] = -origin[1];
  } else if (space != "left-posterior-superior" && space != "LPS") {
    fail(name, "its space is neither LPS nor RAS");
  }
  grid.origin = {origin[0], origin[1], origin[2]};
  for (int axis = 0; axis < 3; ++axis) {
    const auto first = std::size_t(axis) * 3;
    const Vec3 step{axes[first], axes[first + 1], axes[first + 2]};
    grid.spacing[axis] = norm(step);
    if (!(grid.spacing[axis] > 0.0) || !std::isfinite(grid.spacing[axis]))
      fail(name, "its voxels have no size");
    for (int row = 0; row < 3; ++row) grid.direction(row, axis) = step[row] / grid.spacing[axis];
  }
  return grid;
}

/// Unpacks gzip data into exactly `size` bytes.
void inflate_gzip(std::string_view packed, void* bytes, std::size_t size, const std::string& name) {
  z_stream stream{};
  constexpr int kGzipWindow = 15 + 16;
  if (inflateInit2(&stream, kGzipWindow) != Z_OK) fail(name, "zlib failed");
  std::size_t read = 0, written = 0;
  int status = Z_OK;
  constexpr std::size_t kChunk = 1u << 30;  // zlib counts in 32 bits
  while (status == Z_OK && written < size) {
    const std::size_t in = std::min(kChunk, packed.size() - read);
    const std::size_t out = std::min(kChunk, size - written);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data() + read));
    stream.avail_in = uInt(in);
    stream.next_out = static_cast<Bytef*>(bytes) + written;
    stream.avail_out = uInt(out);
    status = inflate(&stream, Z_NO_FLUSH);
    const std::size_t used = in - stream.avail_in, made = out - stream.avail_out;
    if (used == 0 && made == 0) break;
    read += used;
    written += made;
  }
  inflateEnd(&stream);
  if (written != size) fail(name, "its data are damaged or were cut short");
}

template <class Stored>
std::vector<float> convert(std::string_view bytes, std::size_t count, bool is_big_endian) {
  std::vector<float> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    std::array<char, sizeof(Stored)> raw;
    std::memcpy(raw.data(), bytes.data() + i * sizeof(Stored), sizeof(Stored));
    if (is_big_endian) std::reverse(raw.begin(), raw.end());
    Stored value;
    std::memcpy(&value, raw.data(), sizeof(Stored));
    values[i] = float(value);
  }
  return values;
}

struct NumberType {
  std::size_t size = 0;  ///< [byte]
  std::vector<float> (*convert)(std::string_view, std::size_t, bool) = nullptr;
};

NumberType number_type(const std::string& type, const std::string& name) {
  const auto is = [&](std::initializer_list<const char*> names) {
    return std::find(names.begin(), names.end(), type) != names.end();
  };
  if (is({"float"})) return {4, convert<float>};
  if (is({"double"})) return {8, convert<double>};
  if (is({"signed char", "int8", "int8_t"})) return {1, convert<std::int8_t>};
  if (is({"uchar", "unsigned char", "uint8", "uint8_t"})) return {1, convert<std::uint8_t>};
  if (is({"short", "short int", "signed short", "signed short int", "int16", "int16_t"}))
    return {2, convert<std::int16_t>};
  if (is({"ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"}))
    return {2, convert<std::uint16_t>};
  if (is({"int", "signed int", "int32", "int32_t"})) return {4, convert<std::int32_t>};
  if (is({"uint", "unsigned int", "uint32", "uint32_t"})) return {4, convert<std::uint32_t>};
  fail(name, "its numbers are of type " + type);
}

}  // namespace

Volume<float> read_nrrd(const std::filesystem::path& path) {
  const std::string name = path.string();
  const std::string file = detail::read_input(path);
  const Header header = parse_header(file, name);
  Volume<float> volume;
  volume.geometry = parse_geometry(header, name);
  const NumberType type = number_type(header.get("type"), name);
  const std::size_t count = volume.geometry.voxel_count();
  const std::string_view body = std::string_view(file).substr(header.size);
  const std::string encoding = header.get("encoding");
  const bool is_big_endian = header.get("endian") == "big";
  if (encoding == "raw") {
    if (body.size() < count * type.size) fail(name, "it was cut short");
    volume.values = type.convert(body, count, is_big_endian);
  } else if (encoding == "gzip" || encoding == "gz") {
    // Data do not shrink more than about a thousandfold: a larger claim is damage.
    if (count * type.size / 1100 > body.size() + 1) fail(name, "it was cut short");
    if (header.get("type") == "float" && !is_big_endian) {  // as we write it: no second copy
      volume.values.resize(count);
      inflate_gzip(body, volume.values.data(), count * sizeof(float), name);
      return volume;
    }
    std::string bytes(count * type.size, '\0');
    inflate_gzip(body, bytes.data(), bytes.size(), name);
    volume.values = type.convert(bytes, count, is_big_endian);
  } else {
    fail(name, "its encoding is " + encoding);
  }
  return volume;
}

}  // namespace angio::formats
