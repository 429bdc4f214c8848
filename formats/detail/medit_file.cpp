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

[[noreturn]] void refuse_medit(const std::string& name, const std::string& why) {
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

bool is_read(std::string_view section) {
  return section == "Dimension" || section == "Vertices" || shape_named(section);
}

class MeditReader {
 public:
  MeditReader(std::string_view text, const std::string& name) : tokens_(text), name_(name) {}

  TriangleMesh read() {
    std::string_view word = next();
    if (word != "MeshVersionFormatted")
      refuse_medit(name_, "it does not begin with MeshVersionFormatted");
    next();  // its number
    for (word = next(); !word.empty() && word != "End";) {
      if (word == "Dimension") {
        if (number<int>() != 3) refuse_medit(name_, "it is not in three dimensions");
      } else if (word == "Vertices") {
        read_points();
      } else if (const auto shape = shape_named(word)) {
        read_cells(*shape);
      }
      const std::string_view section = word;
      bool has_numbers = false;
      // What is of no interest here is passed by, number by number.
      for (word = next(); parse_number<double>(word); word = next()) has_numbers = true;
      if (word.empty() && !has_numbers && !is_read(section))
        refuse_medit(name_, "it was cut short");
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
    if (!value) refuse_medit(name_, "it ends too early or holds a word where a number should be");
    return *value;
  }
  long next_count() {
    const auto count = number<long>();
    if (count < 0) refuse_medit(name_, "it counts fewer than none");
    return count;
  }
  void read_points() {
    const long count = next_count();
    for (long i = 0; i < count; ++i) {
      Vec3 point;
      for (int axis = 0; axis < 3; ++axis) point[axis] = number<double>();
      number<double>();  // its label
      points_.push_back(point);
    }
  }
  void read_cells(CellShape shape) {
    const long count = next_count();
    std::vector<int> nodes(corner_count(shape));
    for (long i = 0; i < count; ++i) {
      for (int& node : nodes) {
        const auto named = number<long>();
        if (named < 1 || std::size_t(named) > points_.size())
          refuse_medit(name_, "a cell names a vertex that is not there");
        node = int(named - 1);
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
  result.data.mesh = MeditReader(text, name).read();
  return result;
}

}  // namespace angio::formats::detail
