#include <array>
#include <optional>

#include "core/error.hpp"
#include "formats/detail/mesh_cells.hpp"
#include "formats/detail/surface_formats.hpp"
#include "formats/tokens.hpp"

// INRIA's .mesh as text: Frey, "MEDIT: an interactive mesh visualization software", INRIA RT-0253,
// 2001, appendix.
namespace angio::formats::detail {
namespace {

[[noreturn]] void fail(const std::string& name, const std::string& why) {
  throw InputError(name + " cannot be read as a Medit mesh (" + why +
                   "). Export it again, or as STL");
}

struct CellKeyword {
  const char* word;
  CellShape shape;
};
constexpr std::array<CellKeyword, 6> kCells{{{"Triangles", CellShape::triangle},
                                             {"Quadrilaterals", CellShape::quadrilateral},
                                             {"Tetrahedra", CellShape::tetrahedron},
                                             {"Pyramids", CellShape::pyramid},
                                             {"Prisms", CellShape::prism},
                                             {"Hexahedra", CellShape::hexahedron}}};

std::optional<CellShape> shape_named(std::string_view word) {
  for (const CellKeyword& cell : kCells)
    if (word == cell.word) return cell.shape;
  return std::nullopt;
}

class Reader {
 public:
  Reader(std::string_view text, const std::string& name) : tokens_(text), name_(name) {}

  TriangleMesh read() {
    std::string_view word = next();
    if (word != "MeshVersionFormatted") fail(name_, "it does not begin with MeshVersionFormatted");
    next();  // its number
    for (word = next(); !word.empty() && word != "End";) {
      if (word == "Dimension") {
        if (number<int>() != 3) fail(name_, "it is not in three dimensions");
      } else if (word == "Vertices") {
        read_points();
      } else if (const auto shape = shape_named(word)) {
        read_cells(*shape);
      }
      do {  // what is of no interest here is passed by, number by number
        word = next();
      } while (parse_number<double>(word));
    }
    return surface_.over(points_);
  }

 private:
  /// The next word that is no comment.
  std::string_view next() {
    std::string_view word = tokens_.next();
    while (word.starts_with('#')) {
      tokens_.skip_line();
      word = tokens_.next();
    }
    return word;
  }
  template <class Number>
  Number number() {
    const auto value = parse_number<Number>(next());
    if (!value) fail(name_, "it ends too early or holds a word where a number should be");
    return *value;
  }
  void read_points() {
    const auto count = number<long>();
    for (long i = 0; i < count; ++i) {
      Vec3 point;
      for (int axis = 0; axis < 3; ++axis) point[axis] = number<double>();
      number<double>();  // its label
      points_.push_back(point);
    }
  }
  void read_cells(CellShape shape) {
    const auto count = number<long>();
    std::vector<int> nodes(corner_count(shape));
    for (long i = 0; i < count; ++i) {
      for (int& node : nodes) {
        node = number<int>() - 1;
        if (node < 0 || std::size_t(node) >= points_.size())
          fail(name_, "a cell names a vertex that is not there");
      }
      number<double>();
      surface_.add(shape, nodes);
    }
  }

  Tokens tokens_;
  const std::string& name_;
  std::vector<Vec3> points_;
  CellSurface surface_;
};

}  // namespace

ParsedSurface parse_medit(std::string_view text, const std::string& name) {
  ParsedSurface result;
  result.data.mesh = Reader(text, name).read();
  return result;
}

}  // namespace angio::formats::detail
