#include "formats/detail/legacy_file.hpp"

#include <vtkCellArray.h>
#include <vtkErrorCode.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPolyDataReader.h>
#include <vtkStructuredGrid.h>
#include <vtkStructuredGridReader.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridReader.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"
#include "core/legacy_vtk.hpp"
#include "formats/detail/outer_surface.hpp"
#include "formats/detail/surface_cleanup.hpp"
#include "formats/tokens.hpp"
#include "formats/vtk_messages.hpp"

namespace angio::formats::detail {
namespace {

constexpr std::uint64_t kMostCount = 1'000'000'000;  ///< more is a damaged header

/// A line that begins with a keyword, and where the data behind it are.
struct Section {
  std::vector<std::string_view> words;  ///< behind the keyword
  std::size_t data = 0;
  [[nodiscard]] std::uint64_t count(std::size_t word) const {
    const auto number = word < words.size() ? parse_number<std::uint64_t>(words[word]) : 0;
    return number.value_or(kMostCount + 1);
  }
};

std::optional<Section> find_section(std::string_view bytes, const std::string& keyword,
                                    std::size_t from) {
  const auto at = bytes.find("\n" + keyword + " ", from);
  if (at == std::string_view::npos) return std::nullopt;
  const auto begin = at + keyword.size() + 2;
  const auto end = std::min(bytes.find('\n', begin), bytes.size());
  Section section;
  Tokens tokens(bytes.substr(begin, end - begin));
  for (auto word = tokens.next(); !word.empty(); word = tokens.next())
    section.words.push_back(word);
  section.data = std::min(end + 1, bytes.size());
  return section;
}

/// Whether so many words follow, each with a blank or a line's end behind it.
bool has_words(std::string_view text, std::uint64_t count) {
  bool in_word = false;
  for (const char c : text) {
    const bool is_blank = c == ' ' || c == '\n' || c == '\t' || c == '\r';
    if (is_blank && in_word && --count == 0) return true;
    in_word = !is_blank;
  }
  return count == 0;
}

/// Of a number of a type that coordinates and indices have; 0 of others (VTK's reader writes past
/// its memory over a "string").
std::uint64_t bytes_of(std::string_view type) {
  if (type.starts_with("unsigned_")) type.remove_prefix(9);
  for (const std::string_view known : {"double", "long", "vtktypeint64"})
    if (type == known) return 8;
  for (const std::string_view known : {"float", "int", "vtktypeint32", "vtkIdType"})
    if (type == known) return 4;
  return type == "short" ? 2 : type == "char" ? 1 : 0;
}

/// Cells are a list of counts and points, or (from version 5 on) where each begins, then points.
bool has_cells(std::string_view bytes, const Section& cells, bool is_text) {
  const std::uint64_t first = cells.count(0), second = cells.count(1);
  if (first > kMostCount || second > kMostCount) return false;
  const bool has_offsets = bytes.substr(cells.data).starts_with("OFFSETS ");
  if (is_text)
    return has_words(bytes.substr(cells.data), has_offsets ? 2 + first + 2 + second : second);
  if (!has_offsets) return bytes.size() - cells.data >= 4 * second;
  const auto offsets = find_section(bytes, "OFFSETS", cells.data - 1);
  if (!offsets || offsets->words.empty()) return false;
  const std::uint64_t begin = offsets->data + bytes_of(offsets->words[0]) * first;
  if (begin == offsets->data || begin >= bytes.size()) return false;
  const auto points = find_section(bytes, "CONNECTIVITY", std::size_t(begin));
  return points && !points->words.empty() && bytes_of(points->words[0]) > 0 &&
         bytes.size() - points->data >= bytes_of(points->words[0]) * second;
}

/// Whether a grid has as many points, or types, as its cells ask for: VTK's readers do not look.
bool counts_agree(std::string_view bytes) {
  if (const auto size = find_section(bytes, "DIMENSIONS", 0)) {
    const std::uint64_t i = size->count(0), j = size->count(1), k = size->count(2);
    const auto points = find_section(bytes, "POINTS", 0);
    constexpr std::uint64_t kMostAlong = 100'000;
    if (!points || std::max({i, j, k}) > kMostAlong || i * j * k != points->count(0)) return false;
  }
  const auto cells = find_section(bytes, "CELLS", 0), types = find_section(bytes, "CELL_TYPES", 0);
  if (!cells) return true;
  const bool has_offsets = bytes.substr(cells->data).starts_with("OFFSETS ");
  return types && types->count(0) + (has_offsets ? 1 : 0) == cells->count(0);
}

bool is_whole(std::string_view bytes) {
  const bool is_text = bytes.find("\nASCII") < bytes.find("\nDATASET");
  const auto points = find_section(bytes, "POINTS", 0);
  if (!points || points->words.size() < 2 || points->count(0) > kMostCount) return false;
  const std::uint64_t values = 3 * points->count(0);
  if (bytes_of(points->words[1]) == 0) return false;
  const bool has_points = is_text
                              ? has_words(bytes.substr(points->data), values)
                              : bytes.size() - points->data >= bytes_of(points->words[1]) * values;
  if (!has_points) return false;
  for (const char* keyword : {"POLYGONS", "TRIANGLE_STRIPS", "CELLS"})
    if (const auto cells = find_section(bytes, keyword, points->data);
        cells && !has_cells(bytes, *cells, is_text))
      return false;
  return true;
}

bool has_points_of_cells(vtkUnstructuredGrid& grid) {
  vtkCellArray& cells = *grid.GetCells();
  vtkNew<vtkIdList> corners;
  for (vtkIdType c = 0; c < cells.GetNumberOfCells(); ++c) {
    cells.GetCellAtId(c, corners);
    for (vtkIdType i = 0; i < corners->GetNumberOfIds(); ++i)
      if (corners->GetId(i) < 0 || corners->GetId(i) >= grid.GetNumberOfPoints()) return false;
  }
  return true;
}

template <class Reader>
auto read_with(const std::filesystem::path& path, const std::string& damaged) {
  const VtkMessages messages;
  vtkNew<Reader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  vtkSmartPointer data(reader->GetOutput());
  if (messages.has_error() || reader->GetErrorCode() != vtkErrorCode::NoError || !data)
    throw InputError(damaged);
  return data;
}

}  // namespace

vtkSmartPointer<vtkPolyData> read_legacy_polygons(const std::filesystem::path& path) {
  const std::string name = path.string();
  const std::string kind = legacy_vtk_data_set(path);
  if (!is_legacy_surface(kind))
    throw InputError(name +
                     " holds neither polygons nor a grid of VTK's legacy format (DATASET POLYDATA, "
                     "UNSTRUCTURED_GRID, STRUCTURED_GRID). Convert it, for example to .vtp");
  const std::string damaged = name + " was cut short, or is damaged. Copy or write it again";
  const std::string bytes = read_input(path);
  if (!is_whole(bytes) || !counts_agree(bytes)) throw InputError(damaged);
  if (kind == "POLYDATA") return read_with<vtkPolyDataReader>(path, damaged);
  if (kind == "UNSTRUCTURED_GRID") {
    const auto grid = read_with<vtkUnstructuredGridReader>(path, damaged);
    if (!has_points_of_cells(*grid)) throw InputError(damaged);
    return outer_surface(grid, name);
  }
  return outer_surface(read_with<vtkStructuredGridReader>(path, damaged), name);
}

}  // namespace angio::formats::detail
