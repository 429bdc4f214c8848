#include "core/error.hpp"
#include "formats/detail/header_text.hpp"
#include "formats/detail/surface_formats.hpp"
#include "formats/tokens.hpp"

// Geomview's .off as text, its vertices with or without normals, colours and texture coordinates:
// Phillips, Levy, Munzner, "Geomview manual", section "OFF files" (geomview.org/docs).
namespace angio::formats::detail {
namespace {

class OffReader {
 public:
  OffReader(std::string_view text, const std::string& name) : lines_(text), name_(name) {}

  /// Number of triangles that the last face is cut into.
  [[nodiscard]] std::size_t last_face() const { return last_face_; }

  ParsedSurface read() {
    std::string_view line = next();
    line.remove_prefix(line.find_first_not_of(" \t"));
    const auto end = line.find("OFF");
    if (end == std::string_view::npos ||
        line.substr(0, end).find_first_not_of("STCN") != std::string_view::npos)
      fail("it does not begin with OFF");
    line.remove_prefix(end + 3);
    Tokens counts(line);
    std::string_view word = counts.next();
    if (word == "BINARY") fail("it is binary");
    if (word.empty()) {
      counts = Tokens(next());
      word = counts.next();
    }
    const auto points = parse_number<long>(word), faces = parse_number<long>(counts.next());
    if (!points || !faces) fail("it does not count its points and faces");
    for (long i = 0; i < *points; ++i) read_point();
    for (long i = 0; i < *faces; ++i) read_face();
    return std::move(result_);
  }

 private:
  [[noreturn]] void fail(const std::string& why) const {
    throw InputError(name_ + " cannot be read as OFF (" + why + "). Export the surface again");
  }
  /// The next line that holds more than a comment.
  std::string_view next() {
    while (const auto line = lines_.next()) {
      const auto comment = line->find('#');
      if (comment != std::string_view::npos) {
        result_.in_ras |= says_ras(*line);
        if (const auto unit = stated_unit(*line)) result_.data.unit = unit;
      }
      const std::string_view text = line->substr(0, comment);
      if (text.find_first_not_of(" \t\r") != std::string_view::npos) return text;
    }
    fail("it was cut short");
  }
  void read_point() {
    Tokens tokens(next());
    Vec3 point;
    for (int axis = 0; axis < 3; ++axis) {
      const auto number = parse_number<double>(tokens.next());
      if (!number) fail("a point is not three numbers");
      point[axis] = *number;
    }
    mesh().vertices.push_back(point);
  }
  void read_face() {
    Tokens tokens(next());
    const auto count = parse_number<int>(tokens.next());
    if (!count || *count < 1) fail("a face does not count its corners");
    last_face_ = std::size_t(std::max(0, *count - 2));
    int first = 0, before = 0;
    for (int c = 0; c < *count; ++c) {
      const auto corner = parse_number<int>(tokens.next());
      if (!corner || *corner < 0 || std::size_t(*corner) >= mesh().vertices.size())
        fail("a face names a point that is not there");
      if (c == 0) first = *corner;
      if (c >= 2) mesh().triangles.push_back({first, before, *corner});
      before = *corner;
    }
  }
  TriangleMesh& mesh() { return result_.data.mesh; }

  Lines lines_;
  const std::string& name_;
  ParsedSurface result_;
  std::size_t last_face_ = 0;
};

}  // namespace

ParsedSurface parse_off(std::string_view text, const std::string& name) {
  OffReader reader(text, name);
  ParsedSurface result = reader.read();
  require_whole_last_face(text, result.data.mesh, reader.last_face(), name);
  return result;
}

}  // namespace angio::formats::detail
