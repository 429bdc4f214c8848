#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "core/error.hpp"
#include "formats/detail/append_number.hpp"
#include "formats/detail/header_text.hpp"
#include "formats/detail/surface_formats.hpp"
#include "formats/tokens.hpp"

static_assert(std::endian::native == std::endian::little, "STL and PLY are written little-endian");

namespace angio::formats::detail {
namespace {

constexpr std::size_t kHeaderBytes = 80;
constexpr std::size_t kFacetBytes = 50;

std::uint32_t binary_facet_count(std::string_view bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + kHeaderBytes, sizeof(count));
  return count;
}

/// A binary file's size follows from its facet count. Its first word does not tell: many programs
/// begin the free header with "solid" too.
bool is_binary(std::string_view bytes) {
  return bytes.size() >= kHeaderBytes + 4 &&
         bytes.size() == kHeaderBytes + 4 + kFacetBytes * binary_facet_count(bytes);
}

void add_triangle(TriangleMesh& mesh) {
  const auto last = int(mesh.vertices.size()) - 1;
  mesh.triangles.push_back({last - 2, last - 1, last});
}

/// The normal and the corners of a facet of a binary file.
std::array<float, 12> facet_numbers(std::string_view bytes, std::size_t facet) {
  std::array<float, 12> numbers;
  std::memcpy(numbers.data(), bytes.data() + kHeaderBytes + 4 + kFacetBytes * facet,
              sizeof(numbers));
  return numbers;
}

ParsedSurface parse_binary(std::string_view bytes) {
  ParsedSurface result;
  result.in_ras = says_ras(bytes.substr(0, kHeaderBytes));
  result.data.unit = stated_unit(bytes.substr(0, kHeaderBytes));
  TriangleMesh& mesh = result.data.mesh;
  const std::size_t count = binary_facet_count(bytes);
  mesh.vertices.reserve(3 * count);
  mesh.triangles.reserve(count);
  for (std::size_t facet = 0; facet < count; ++facet) {
    const std::array<float, 12> numbers = facet_numbers(bytes, facet);
    for (std::size_t c = 3; c < 12; c += 3)
      mesh.vertices.push_back({double(numbers[c]), double(numbers[c + 1]), double(numbers[c + 2])});
    add_triangle(mesh);
  }
  return result;
}

/// How many whole facets a binary file has room for behind its header.
std::size_t whole_facets(std::string_view bytes) {
  return bytes.size() < kHeaderBytes + 4 ? 0 : (bytes.size() - kHeaderBytes - 4) / kFacetBytes;
}

/// Whether a facet's numbers are some: what is no STL at all holds patterns that are none.
bool is_facet(const std::array<float, 12>& numbers) {
  constexpr float kMost = 1e9f;
  return std::all_of(numbers.begin(), numbers.end(),
                     [](float number) { return std::abs(number) < kMost; });
}

/// Whether whole facets are there and something else behind them, as some programs write it. What
/// is no STL at all would ask for more facets than it is long, or hold numbers that are none.
bool has_more_behind(std::string_view bytes) {
  if (whole_facets(bytes) == 0) return false;
  const std::size_t count = binary_facet_count(bytes);
  if (count == 0 || whole_facets(bytes) < count) return false;
  for (std::size_t facet = 0; facet < count; ++facet)
    if (!is_facet(facet_numbers(bytes, facet))) return false;
  return true;
}

/// Whether a binary file ends before its last facet. Its header is filled with zeros, as text never
/// is, or its first facet has a normal of length one, or none; and that facet's numbers are some.
bool is_cut_short(std::string_view bytes) {
  const bool has_count = bytes.size() >= kHeaderBytes + 4;
  if (has_count && binary_facet_count(bytes) <= whole_facets(bytes)) return false;
  const bool has_zeros = bytes.substr(0, kHeaderBytes).find('\0') != std::string_view::npos;
  if (whole_facets(bytes) == 0) return has_zeros;
  const std::array<float, 12> first = facet_numbers(bytes, 0);
  if (has_zeros || !is_facet(first)) return is_facet(first);
  const float length = std::hypot(first[0], first[1], first[2]);
  return length == 0.0f || std::abs(length - 1.0f) < 0.01f;
}

std::string lengths(std::string_view bytes) {
  if (bytes.size() < kHeaderBytes + 4) return "it has not even the 84 bytes of a header";
  const std::uint64_t count = binary_facet_count(bytes);
  return "its header says " + std::to_string(count) + " triangles, so 84 + 50 x " +
         std::to_string(count) + " = " +
         std::to_string(kHeaderBytes + 4 + kFacetBytes * std::size_t(count)) + " bytes; it has " +
         std::to_string(bytes.size());
}

ParsedSurface parse_ascii(std::string_view text, const std::string& name) {
  ParsedSurface result;
  result.in_ras = says_ras(text.substr(0, text.find('\n')));
  result.data.unit = stated_unit(text.substr(0, text.find('\n')));
  TriangleMesh& mesh = result.data.mesh;
  Tokens tokens(text);
  int corner_count = 0;
  bool ended = false;
  for (std::string_view word = tokens.next(); !word.empty(); word = tokens.next()) {
    if (word == "vertex") {
      Vec3 point;
      for (int axis = 0; axis < 3; ++axis) {
        const auto number = parse_number<double>(tokens.next());
        if (!number)
          throw InputError(name + " has a corner that is not three numbers (facet " +
                           std::to_string(mesh.triangles.size() + 1) +
                           "; the file is damaged). Export the surface again");
        point[axis] = *number;
      }
      mesh.vertices.push_back(point);
      ++corner_count;
    } else if (word == "endfacet") {
      if (corner_count != 3)
        throw InputError(name + " has a facet of " + std::to_string(corner_count) +
                         " corners (STL facets have three). Export the surface again");
      add_triangle(mesh);
      corner_count = 0;
    } else if (word == "facet" || word == "endsolid") {
      ended = word == "endsolid";
    }
  }
  if (corner_count != 0)
    throw InputError(name +
                     " ends in the middle of a facet (it was cut short). Copy or export it "
                     "again");
  if (!ended)
    throw InputError(name +
                     " ends without \"endsolid\" (it was cut short). Copy or export it "
                     "again, or add that line if no facet is missing");
  return result;
}

void append_float3(std::string& bytes, const Vec3& v) {
  for (int axis = 0; axis < 3; ++axis) append_number(bytes, float(v[axis]));
}

}  // namespace

ParsedSurface parse_stl(std::string_view bytes, const std::string& name) {
  if (is_binary(bytes)) {
    if (binary_facet_count(bytes) > std::numeric_limits<int>::max() / 3)
      throw InputError(name + " has too many triangles (" +
                       std::to_string(binary_facet_count(bytes)) + "). Decimate it first");
    return parse_binary(bytes);
  }
  if (Tokens(bytes).next() == "solid" && bytes.find("facet") != std::string_view::npos)
    return parse_ascii(bytes, name);
  if (has_more_behind(bytes)) return parse_binary(bytes);
  throw InputError(name +
                   (is_cut_short(bytes)
                        ? " was cut short (" + lengths(bytes) + ")."
                        : " is not an STL surface (neither binary nor ASCII STL).") +
                   " Copy or export it again");
}

std::string stl_bytes(const TriangleMesh& mesh) {
  std::string bytes = "SPACE=LPS unit=mm binary STL";  // must not begin with "solid"
  bytes.resize(kHeaderBytes, '\0');
  bytes.reserve(kHeaderBytes + 4 + kFacetBytes * mesh.triangles.size());
  append_number(bytes, std::uint32_t(mesh.triangles.size()));
  for (const Triangle& triangle : mesh.triangles) {
    append_float3(bytes, normalized(area_vector_doubled(mesh, triangle)));
    for (const int corner : triangle) append_float3(bytes, mesh.vertices[std::size_t(corner)]);
    append_number(bytes, std::uint16_t(0));
  }
  return bytes;
}

}  // namespace angio::formats::detail
