#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>

#include "core/error.hpp"
#include "formats/detail/append_number.hpp"
#include "formats/detail/header_text.hpp"
#include "formats/detail/surface_cleanup.hpp"
#include "formats/detail/surface_formats.hpp"
#include "formats/tokens.hpp"

namespace angio::formats::detail {
namespace {

enum class Encoding { ascii, little_endian, big_endian };

struct Property {
  std::string name;
  std::string type;
  std::string count_type;  ///< of a list; empty for a single number
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Encoding encoding = Encoding::ascii;
  std::vector<Element> elements;
  bool in_ras = false;
  std::optional<LengthUnit> unit;
  std::size_t size = 0;  ///< [byte]
};

[[noreturn]] void refuse_ply(const std::string& name, const std::string& why) {
  throw InputError(name + " cannot be read as PLY (" + why + "). Export the surface again");
}

void parse_header_line(Header& header, std::string_view line, const std::string& name) {
  Tokens tokens(line);
  const std::string_view kind = tokens.next();
  if (kind == "format") {
    const std::string_view encoding = tokens.next();
    if (encoding == "ascii")
      header.encoding = Encoding::ascii;
    else if (encoding == "binary_little_endian")
      header.encoding = Encoding::little_endian;
    else if (encoding == "binary_big_endian")
      header.encoding = Encoding::big_endian;
    else
      refuse_ply(name, "unknown format");
  } else if (kind == "comment" || kind == "obj_info") {
    if (says_ras(line)) header.in_ras = true;
    if (const auto unit = stated_unit(line)) header.unit = unit;
  } else if (kind == "element") {
    Element element;
    element.name = tokens.next();
    const auto count = parse_number<std::uint32_t>(tokens.next());
    if (!count) refuse_ply(name, "an element has no count");
    element.count = *count;
    header.elements.push_back(element);
  } else if (kind == "property") {
    if (header.elements.empty()) refuse_ply(name, "a property comes before its element");
    Property property;
    property.type = tokens.next();
    if (property.type == "list") {
      property.count_type = tokens.next();
      property.type = tokens.next();
    }
    property.name = tokens.next();
    header.elements.back().properties.push_back(property);
  }
}

Header parse_header(std::string_view bytes, const std::string& name) {
  Header header;
  Lines lines(bytes);
  if (lines.next() != "ply") refuse_ply(name, "it does not begin with \"ply\"");
  while (const auto line = lines.next()) {
    if (*line == "end_header") {
      header.size = lines.position();
      return header;
    }
    parse_header_line(header, *line, name);
  }
  refuse_ply(name, "its header has no end");
}

/// Gives the numbers of a PLY body one by one.
class Body {
 public:
  Body(std::string_view bytes, Encoding encoding, const std::string& name)
      : bytes_(bytes), tokens_(bytes), encoding_(encoding), name_(name) {}

  double next(const std::string& type) {
    if (encoding_ == Encoding::ascii) {
      const auto number = parse_number<double>(tokens_.next());
      if (!number) refuse_ply(name_, "it ends too early or holds a word where a number should be");
      return *number;
    }
    if (type == "char" || type == "int8") return raw<std::int8_t>();
    if (type == "uchar" || type == "uint8") return raw<std::uint8_t>();
    if (type == "short" || type == "int16") return raw<std::int16_t>();
    if (type == "ushort" || type == "uint16") return raw<std::uint16_t>();
    if (type == "int" || type == "int32") return raw<std::int32_t>();
    if (type == "uint" || type == "uint32") return raw<std::uint32_t>();
    if (type == "float" || type == "float32") return double(raw<float>());
    if (type == "double" || type == "float64") return raw<double>();
    refuse_ply(name_, "unknown number type \"" + type + "\"");
  }

 private:
  template <class Number>
  Number raw() {
    if (position_ + sizeof(Number) > bytes_.size()) refuse_ply(name_, "it was cut short");
    std::array<char, sizeof(Number)> buffer;
    std::memcpy(buffer.data(), bytes_.data() + position_, sizeof(Number));
    position_ += sizeof(Number);
    if (encoding_ == Encoding::big_endian) std::reverse(buffer.begin(), buffer.end());
    return std::bit_cast<Number>(buffer);
  }

  std::string_view bytes_;
  Tokens tokens_;
  Encoding encoding_;
  const std::string& name_;
  std::size_t position_ = 0;
};

void read_vertex(Body& body, const Element& element, TriangleMesh& mesh) {
  Vec3 point;
  for (const Property& property : element.properties) {
    const double value = body.next(property.type);
    if (property.name == "x") point.x = value;
    if (property.name == "y") point.y = value;
    if (property.name == "z") point.z = value;
  }
  mesh.vertices.push_back(point);
}

void read_face(Body& body, const Element& element, TriangleMesh& mesh, const std::string& name) {
  for (const Property& property : element.properties) {
    const bool is_corners = property.name == "vertex_indices" || property.name == "vertex_index";
    const double count = property.count_type.empty() ? 1.0 : body.next(property.count_type);
    if (is_corners && (count < 3.0 || count > 1e6))
      refuse_ply(name, "a face has fewer than 3 corners");
    std::vector<int> corners;
    for (double c = 0.0; c < count; ++c) {
      const double value = body.next(property.type);
      if (!is_corners) continue;
      if (value < 0.0 || value > double(std::numeric_limits<int>::max()))
        refuse_ply(name, "a face names a point that is not there");
      corners.push_back(int(value));
    }
    for (std::size_t c = 2; c < corners.size(); ++c)
      mesh.triangles.push_back({corners[0], corners[c - 1], corners[c]});
  }
}

/// Any other element is read past.
void skip(Body& body, const Element& element) {
  for (const Property& property : element.properties) {
    const double count = property.count_type.empty() ? 1.0 : body.next(property.count_type);
    for (double c = 0.0; c < count; ++c) body.next(property.type);
  }
}

}  // namespace

ParsedSurface parse_ply(std::string_view bytes, const std::string& name) {
  const Header header = parse_header(bytes, name);
  ParsedSurface result;
  result.in_ras = header.in_ras;
  result.data.unit = header.unit;
  TriangleMesh& mesh = result.data.mesh;
  Body body(bytes.substr(header.size), header.encoding, name);
  std::size_t last_face = 0;  // in triangles; 0 while something else comes last
  for (const Element& element : header.elements) {
    // Every element takes at least a byte: a larger count is damage, not a large mesh.
    if (element.count > bytes.size()) refuse_ply(name, "it was cut short");
    for (std::size_t i = 0; i < element.count; ++i) {
      const std::size_t before = mesh.triangles.size();
      if (element.name == "vertex")
        read_vertex(body, element, mesh);
      else if (element.name == "face")
        read_face(body, element, mesh, name);
      else
        skip(body, element);
      last_face = mesh.triangles.size() - before;
    }
  }
  if (header.encoding == Encoding::ascii) {
    require_usable(result.data, name);
    require_whole_last_face(bytes, mesh, last_face, name);
  }
  return result;
}

std::string ply_bytes(const TriangleMesh& mesh) {
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\ncomment SPACE=LPS unit=mm\nelement vertex " +
      std::to_string(mesh.vertices.size()) +
      "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
      std::to_string(mesh.triangles.size()) +
      "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Vec3& point : mesh.vertices)
    for (int axis = 0; axis < 3; ++axis) append_number(bytes, point[axis]);
  for (const Triangle& triangle : mesh.triangles) {
    append_number(bytes, std::uint8_t(3));
    for (const int corner : triangle) append_number(bytes, std::int32_t(corner));
  }
  return bytes;
}

}  // namespace angio::formats::detail
