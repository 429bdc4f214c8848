#include <array>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>

#include "core/error.hpp"
#include "formats/detail/mesh_cells.hpp"
#include "formats/detail/surface_formats.hpp"
#include "formats/tokens.hpp"

// Gmsh's .msh of the versions 2.x and 4.1, as text or binary: Geuzaine, Remacle et al., "Gmsh
// reference manual", section "MSH file format" (gmsh.info/doc).
namespace angio::formats::detail {
namespace {

[[noreturn]] void refuse_gmsh(const std::string& name, const std::string& why) {
  throw InputError(name + " cannot be read as a Gmsh mesh (" + why +
                   "). Export it again, as MSH 2.2 or 4.1, or as STL");
}

/// The numbers of a file one by one, as text or in binary.
class Numbers {
 public:
  Numbers(std::string_view bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  bool is_binary = false;

  /// The next line without white space around it; nothing at the end.
  std::optional<std::string_view> line() {
    while (position_ < bytes_.size()) {
      const auto end = std::min(bytes_.find('\n', position_), bytes_.size());
      const std::string_view found = bytes_.substr(position_, end - position_);
      position_ = std::min(end + 1, bytes_.size());
      const auto first = found.find_first_not_of(" \t\r");
      if (first != std::string_view::npos)
        return found.substr(first, found.find_last_not_of(" \t\r") + 1 - first);
    }
    return std::nullopt;
  }
  /// Behind the line's end, where numbers in binary begin.
  void end_line() { position_ = std::min(bytes_.find('\n', position_), bytes_.size() - 1) + 1; }
  /// Behind a section's end. The counts have told whether all is there: some files lack the last.
  void skip_behind(const std::string& word) {
    const auto found = bytes_.find(word, position_);
    const std::string_view rest = bytes_.substr(position_);
    if (found == std::string_view::npos && rest.find('\n') != std::string_view::npos &&
        rest.find_first_not_of(" \t\r\n") == std::string_view::npos) {
      position_ = bytes_.size();
      return;
    }
    if (found == std::string_view::npos)
      refuse_gmsh(name_, "it was cut short: there is no " + word);
    position_ = found + word.size();
  }

  std::int64_t integer() { return is_binary ? raw<std::int32_t>() : text<std::int64_t>(); }
  /// A count or a name of a node or an element, in version 4.
  std::int64_t size() { return is_binary ? raw<std::int64_t>() : integer(); }
  /// The same, of a count. @throws InputError if it is negative
  std::int64_t count() { return counted(size()); }
  [[nodiscard]] std::int64_t counted(std::int64_t number) const {
    if (number < 0) refuse_gmsh(name_, "it counts fewer than none");
    return number;
  }
  double real() { return is_binary ? raw<double>() : text<double>(); }
  template <class Number>
  Number text() {
    constexpr std::string_view kSpace = " \t\r\n";
    const auto first = std::min(bytes_.find_first_not_of(kSpace, position_), bytes_.size());
    position_ = std::min(bytes_.find_first_of(kSpace, first), bytes_.size());
    const auto number = parse_number<Number>(bytes_.substr(first, position_ - first));
    if (!number) refuse_gmsh(name_, "it ends too early or holds a word where a number should be");
    return *number;
  }

 private:
  template <class Number>
  Number raw() {
    if (bytes_.size() - position_ < sizeof(Number)) refuse_gmsh(name_, "it was cut short");
    Number number;
    std::memcpy(&number, bytes_.data() + position_, sizeof(Number));
    position_ += sizeof(Number);
    return number;
  }

  std::string_view bytes_;
  const std::string& name_;
  std::size_t position_ = 0;
};

struct ElementType {
  int nodes = 0;                                  ///< 0: no such type
  std::optional<CellShape> shape = std::nullopt;  ///< none of points and lines
};

ElementType element_type(std::int64_t type) {
  constexpr auto kTriangle = CellShape::triangle, kQuad = CellShape::quadrilateral,
                 kTet = CellShape::tetrahedron, kPyramid = CellShape::pyramid,
                 kPrism = CellShape::prism, kHex = CellShape::hexahedron;
  static const std::array<ElementType, 32> kTypes{{{},
                                                   {2},
                                                   {3, kTriangle},
                                                   {4, kQuad},
                                                   {4, kTet},
                                                   {8, kHex},
                                                   {6, kPrism},
                                                   {5, kPyramid},
                                                   {3},
                                                   {6, kTriangle},
                                                   {9, kQuad},
                                                   {10, kTet},
                                                   {27, kHex},
                                                   {18, kPrism},
                                                   {14, kPyramid},
                                                   {1},
                                                   {8, kQuad},
                                                   {20, kHex},
                                                   {15, kPrism},
                                                   {13, kPyramid},
                                                   {9, kTriangle},
                                                   {10, kTriangle},
                                                   {12, kTriangle},
                                                   {15, kTriangle},
                                                   {15, kTriangle},
                                                   {21, kTriangle},
                                                   {4},
                                                   {5},
                                                   {6},
                                                   {20, kTet},
                                                   {35, kTet},
                                                   {56, kTet}}};
  return type > 0 && type < std::int64_t(kTypes.size()) ? kTypes[std::size_t(type)] : ElementType{};
}

class Mesh {
 public:
  explicit Mesh(const std::string& name) : name_(name) {}

  void add_point(std::int64_t tag, Numbers& numbers) {
    const double x = numbers.real(), y = numbers.real(), z = numbers.real();
    if (!places_.emplace(tag, int(points_.size())).second)
      refuse_gmsh(name_, "two nodes have the number " + std::to_string(tag));
    points_.push_back({x, y, z});
  }
  /// @param next  the number of its next node
  template <class Next>
  void add_element(const ElementType& type, Next next) {
    nodes_.clear();
    for (int k = 0; k < type.nodes; ++k) {
      const auto found = places_.find(next());
      if (found == places_.end()) refuse_gmsh(name_, "an element names a node that is not there");
      nodes_.push_back(found->second);
    }
    if (type.shape) surface_.add(*type.shape, nodes_);
  }
  [[nodiscard]] ElementType type(std::int64_t number) const {
    const ElementType type = element_type(number);
    if (type.nodes == 0)
      refuse_gmsh(name_, "elements of type " + std::to_string(number) + " are not known here");
    return type;
  }
  [[nodiscard]] TriangleMesh surface() const { return surface_.over(points_); }

 private:
  const std::string& name_;
  std::map<std::int64_t, int> places_;  ///< of the nodes in points_
  std::vector<Vec3> points_;
  std::vector<int> nodes_;  ///< of the element at hand
  CellSurface surface_;
};

void read_nodes_2(Numbers& numbers, Mesh& mesh) {
  const std::int64_t count = numbers.counted(numbers.text<std::int64_t>());
  if (numbers.is_binary) numbers.end_line();
  for (std::int64_t i = 0; i < count; ++i) {
    const std::int64_t tag = numbers.integer();
    mesh.add_point(tag, numbers);
  }
}

void read_elements_2(Numbers& numbers, Mesh& mesh, const std::string& name) {
  const std::int64_t count = numbers.counted(numbers.text<std::int64_t>());
  if (numbers.is_binary) numbers.end_line();
  for (std::int64_t done = 0; done < count;) {
    if (!numbers.is_binary) numbers.integer();  // its own number
    const ElementType type = mesh.type(numbers.integer());
    const std::int64_t together = numbers.is_binary ? numbers.integer() : 1;
    const std::int64_t tags = numbers.counted(numbers.integer());
    if (together < 1) refuse_gmsh(name, "a block of elements is empty");
    for (std::int64_t k = 0; k < together; ++k, ++done) {
      if (numbers.is_binary) numbers.integer();
      for (std::int64_t t = 0; t < tags; ++t) numbers.integer();
      mesh.add_element(type, [&] { return numbers.integer(); });
    }
  }
}

void read_nodes_4(Numbers& numbers, Mesh& mesh, const std::string& name) {
  const std::int64_t blocks = numbers.count(), promised = numbers.count();
  for (int k = 0; k < 2; ++k) numbers.size();  // least and greatest name
  std::vector<std::int64_t> tags;
  std::int64_t found = 0;
  for (std::int64_t b = 0; b < blocks; ++b) {
    const std::int64_t dimension = numbers.integer();
    numbers.integer();  // of the entity
    const bool has_parameters = numbers.integer() != 0;
    const std::int64_t count = numbers.count();
    found += count;
    tags.clear();
    for (std::int64_t i = 0; i < count; ++i) tags.push_back(numbers.size());
    for (const std::int64_t tag : tags) {
      mesh.add_point(tag, numbers);
      for (std::int64_t k = 0; has_parameters && k < dimension; ++k) numbers.real();
    }
  }
  if (found != promised) refuse_gmsh(name, "it has another number of nodes than it says");
}

void read_elements_4(Numbers& numbers, Mesh& mesh, const std::string& name) {
  const std::int64_t blocks = numbers.count(), promised = numbers.count();
  for (int k = 0; k < 2; ++k) numbers.size();
  std::int64_t found = 0;
  for (std::int64_t b = 0; b < blocks; ++b) {
    for (int k = 0; k < 2; ++k) numbers.integer();  // dimension and name of the entity
    const ElementType type = mesh.type(numbers.integer());
    const std::int64_t count = numbers.count();
    found += count;
    for (std::int64_t i = 0; i < count; ++i) {
      numbers.size();  // its own number
      mesh.add_element(type, [&] { return numbers.size(); });
    }
  }
  if (found != promised) refuse_gmsh(name, "it has another number of elements than it says");
}

/// 2 or 4, the version's first number; numbers are in binary from here on where the file says so.
int read_format(Numbers& numbers, const std::string& name) {
  const auto version = numbers.text<double>();
  numbers.is_binary = numbers.text<int>() == 1;
  const int real_bytes = numbers.text<int>();
  const bool is_2 = version >= 2.0 && version < 3.0;
  if (!is_2 && version != 4.1)
    refuse_gmsh(name, "it is of version " + std::to_string(version).substr(0, 3));
  if (real_bytes != 8) refuse_gmsh(name, "its numbers are not of 8 bytes");
  if (numbers.is_binary) {
    numbers.end_line();
    if (numbers.integer() != 1) refuse_gmsh(name, "its bytes are in the other order");
  }
  return is_2 ? 2 : 4;
}

}  // namespace

ParsedSurface parse_gmsh(std::string_view bytes, const std::string& name) {
  Numbers numbers(bytes, name);
  Mesh mesh(name);
  int version = 0;
  bool has_nodes = false, has_elements = false;
  while (const auto line = numbers.line()) {
    if (!line->starts_with('$')) refuse_gmsh(name, "a section does not begin with '$'");
    constexpr std::size_t kLongestName = 64;
    const std::string section(line->substr(1, kLongestName));
    if (version == 0 && section != "MeshFormat" && section != "Comments")
      refuse_gmsh(name, "it does not begin with $MeshFormat");
    if (section == "MeshFormat") {
      version = read_format(numbers, name);
    } else if (section == "Nodes") {
      version == 2 ? read_nodes_2(numbers, mesh) : read_nodes_4(numbers, mesh, name);
      has_nodes = true;
    } else if (section == "Elements") {
      version == 2 ? read_elements_2(numbers, mesh, name) : read_elements_4(numbers, mesh, name);
      has_elements = true;
    }
    numbers.skip_behind("$End" + section);
  }
  if (!has_nodes || !has_elements) refuse_gmsh(name, "it has no nodes or no elements");
  ParsedSurface result;
  result.data.mesh = mesh.surface();
  return result;
}

}  // namespace angio::formats::detail
