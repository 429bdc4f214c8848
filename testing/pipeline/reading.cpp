#include "testing/pipeline/reading.hpp"

#include <vtkFieldData.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkXMLPolyDataReader.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/frames.hpp"
#include "formats/csv.hpp"
#include "formats/files.hpp"

namespace angio {
namespace fs = std::filesystem;
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Rows of a CSV file by the names of its columns.
std::vector<std::map<std::string, std::string>> read_table(const fs::path& file) {
  const std::vector<formats::CsvRow> rows = formats::parse_csv(read_text(file));
  std::vector<std::map<std::string, std::string>> table;
  for (std::size_t r = 1; r < rows.size(); ++r) {
    if (rows[r].size() != rows[0].size())
      throw InputError(file.string() + ", row " + std::to_string(r + 1) +
                       ", has not as many cells as the header (a comma in a remark?). Mend it");
    auto& row = table.emplace_back();
    for (std::size_t c = 0; c < rows[0].size(); ++c) row[rows[0][c]] = rows[r][c];
  }
  return table;
}

/// The three numbers that a text begins with, if it does.
std::optional<Vec3> leading_place(const std::string& text) {
  std::istringstream words(text);
  Vec3 place;
  if (words >> place.x >> place.y >> place.z) return place;
  return std::nullopt;
}

/// "x y z ...; x y z ...": parts that begin with no place are words.
std::vector<Vec3> places_of(const std::string& text, const std::string& separator) {
  std::vector<Vec3> places;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    if (const auto place = leading_place(text.substr(begin, end - begin))) places.push_back(*place);
    begin = end + separator.size();
  }
  return places;
}

std::optional<int> count_of(const std::string& text) {
  if (text.empty()) return std::nullopt;
  return std::stoi(text);
}

Vec3 box_of(const TriangleMesh& mesh) {
  Vec3 low{kInfinity, kInfinity, kInfinity}, high = -low;
  for (const Vec3& vertex : mesh.vertices)
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], vertex[axis]);
      high[axis] = std::max(high[axis], vertex[axis]);
    }
  return high - low;
}

bool says_ras(const fs::path& file) {
  if (file.extension() != ".vtp") {
    constexpr std::size_t kHeader = 2000;
    return read_text(file).substr(0, kHeader).find("SPACE=RAS") != std::string::npos;
  }
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName(file.c_str());
  reader->Update();
  auto* space =
      vtkStringArray::SafeDownCast(reader->GetOutput()->GetFieldData()->GetAbstractArray("SPACE"));
  return space && space->GetNumberOfValues() > 0 && space->GetValue(0) == "RAS";
}

double distance_to(const std::vector<Vec3>& places, const Vec3& point) {
  double least = kInfinity;
  for (const Vec3& place : places) least = std::min(least, distance(place, point));
  return least;
}

bool is_at(const ListedStenosis& stenosis, const Vec3& place) {
  constexpr double kUnknownMm = 3.0;  // where no healthy diameter is told
  const double reach = std::isfinite(stenosis.reference_mm) ? stenosis.reference_mm : kUnknownMm;
  return distance_to(stenosis.places, place) <= reach;
}

}  // namespace

std::vector<Reading> read_readings(const fs::path& readings_csv, const fs::path& ends_csv) {
  std::vector<Reading> readings;
  for (auto& row : read_table(readings_csv)) {
    Reading reading;
    reading.case_name = row["case"];
    reading.file = row["file"];
    reading.split = row["split"];
    reading.certainty = row["certainty"];
    reading.ends = count_of(row["ends"]);
    std::string inlet = row["inlet"];
    constexpr std::string_view kVoxel = "voxel ";
    reading.inlets_are_voxels = inlet.starts_with(kVoxel);
    if (reading.inlets_are_voxels) inlet = inlet.substr(kVoxel.size());
    reading.inlets = places_of(inlet, " or ");
    reading.stenoses = count_of(row["stenoses_over_50"]);
    reading.stenosis_places = places_of(row["where_x_y_z_percent"], ";");
    reading.doubtful_places = places_of(row["doubtful"], ";");
    readings.push_back(std::move(reading));
  }
  for (auto& row : read_table(ends_csv))
    for (Reading& reading : readings) {
      if (reading.case_name != row["case"] || reading.file != row["file"]) continue;
      const std::string& diameter = row["diameter"];
      reading.placed_ends.push_back(
          {{std::stod(row["x"]), std::stod(row["y"]), std::stod(row["z"])},
           diameter.empty() ? 0.0 : std::stod(diameter),
           row["how"] == "by eye"});
    }
  return readings;
}

Vec3 ReadingFrame::operator()(const Vec3& in_file) const {
  return scale * (is_ras ? lps_from_ras(in_file) : in_file);
}

ReadingFrame frame_of_case(const fs::path& input, const fs::path& case_folder) {
  const fs::path surface = case_folder / "segmentation/lumen_surface.vtp";
  if (!fs::exists(surface) || fs::is_directory(input)) return {};
  const Vec3 in_file = box_of(formats::read_surface(input).mesh);
  const Vec3 in_case = box_of(formats::read_surface(surface).mesh);
  const double ratio = norm(in_case) / norm(in_file);
  ReadingFrame frame;
  double least = kInfinity;
  for (const double unit : {1.0, 10.0, 25.4, 1000.0})
    if (const double misfit = std::abs(std::log(ratio / unit)); misfit < least) {
      least = misfit;
      frame.scale = unit;
    }
  frame.is_ras = says_ras(input);
  return frame;
}

Reading in_case(Reading reading, const ReadingFrame& frame,
                const std::optional<VolumeGeometry>& volume) {
  if (reading.inlets_are_voxels && !volume) reading.inlets.clear();
  for (Vec3& inlet : reading.inlets)
    inlet = reading.inlets_are_voxels ? volume->lps_from_index(inlet) : frame(inlet);
  for (ReadEnd& end : reading.placed_ends) {
    end.place = frame(end.place);
    end.diameter *= frame.scale;
  }
  for (Vec3& place : reading.stenosis_places) place = frame(place);
  for (Vec3& place : reading.doubtful_places) place = frame(place);
  return reading;
}

std::vector<LineEnd> ends_of(const CenterlineTree& tree) {
  std::vector<LineEnd> ends;
  if (tree.paths.empty()) return ends;
  const CenterlinePath& first = tree.paths.front();
  ends.push_back({first.points.front(), radius_at_end(first, PathEnd::inlet)});
  for (const CenterlinePath& path : tree.paths)
    ends.push_back({path.points.back(), radius_at_end(path, PathEnd::outlet)});
  return ends;
}

int count_found_ends(const std::vector<ReadEnd>& read, const std::vector<LineEnd>& ends) {
  constexpr double kRadii = 1.5;
  struct Pair {
    double gap;
    std::size_t read, line;
  };
  std::vector<Pair> pairs;
  for (std::size_t r = 0; r < read.size(); ++r)
    for (std::size_t e = 0; e < ends.size(); ++e) {
      const double radius = std::max(0.5 * read[r].diameter, ends[e].radius);
      const double reach = std::max(kRadii * radius, read[r].is_by_eye ? kEyeMm : 0.0);
      const double gap = distance(read[r].place, ends[e].place);
      if (gap <= reach) pairs.push_back({gap, r, e});
    }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.gap < b.gap; });
  std::vector<char> read_taken(read.size(), 0), line_taken(ends.size(), 0);
  int found = 0;
  for (const Pair& pair : pairs) {
    if (read_taken[pair.read] != 0 || line_taken[pair.line] != 0) continue;
    read_taken[pair.read] = line_taken[pair.line] = 1;
    ++found;
  }
  return found;
}

bool is_inlet_right(const std::vector<Vec3>& inlets, const LineEnd& begin,
                    const std::vector<ReadEnd>& placed_ends) {
  constexpr double kRadii = 2.0;
  for (const Vec3& inlet : inlets) {
    double radius = begin.radius;
    for (const ReadEnd& end : placed_ends)  // an inlet that is listed has a width of its own
      if (distance(end.place, inlet) < 0.5 * end.diameter)
        radius = std::max(radius, 0.5 * end.diameter);
    if (distance(inlet, begin.place) <= kRadii * radius) return true;
  }
  return false;
}

std::vector<ListedStenosis> read_stenoses(const fs::path& lesions_json,
                                          const CenterlineTree& tree) {
  std::vector<ListedStenosis> listed;
  if (!fs::exists(lesions_json)) return listed;
  const auto number = [](const nlohmann::json& row, const char* key, double otherwise) {
    return row.contains(key) && row.at(key).is_number() ? row.at(key).get<double>() : otherwise;
  };
  for (const auto& row : nlohmann::json::parse(read_text(lesions_json))) {
    const double nothing = std::numeric_limits<double>::quiet_NaN();
    ListedStenosis stenosis{{},
                            number(row, "reference_diameter_mm", nothing),
                            number(row, "diameter_stenosis_percent", nothing)};
    const double at = number(row, "abscissa_mm", 0.0);
    for (const CenterlinePath& path : tree.paths) {
      if (path.id != int(number(row, "centerline_id", -1.0))) continue;
      stenosis.places.push_back(sample(path, at).point);
      for (std::size_t i = 0; i < path.points.size(); ++i)
        if (path.abscissa[i] >= number(row, "proximal_mm", at) &&
            path.abscissa[i] <= number(row, "distal_mm", at))
          stenosis.places.push_back(path.points[i]);
    }
    if (!stenosis.places.empty()) listed.push_back(std::move(stenosis));
  }
  return listed;
}

StenosisCount count_stenoses(const Reading& reading, const std::vector<ListedStenosis>& listed) {
  constexpr double kSevere = 50.0;
  StenosisCount count;
  const auto is_severe = [&](const ListedStenosis& stenosis) {
    return !(stenosis.percent < kSevere);
  };
  for (const Vec3& place : reading.stenosis_places)
    count.found += std::any_of(listed.begin(), listed.end(),
                               [&](const ListedStenosis& stenosis) {
                                 return is_severe(stenosis) && is_at(stenosis, place);
                               })
                       ? 1
                       : 0;
  for (const ListedStenosis& stenosis : listed) {
    const auto is_here = [&](const Vec3& place) { return is_at(stenosis, place); };
    const auto& read = reading.stenosis_places;
    const auto& doubtful = reading.doubtful_places;
    if (is_severe(stenosis) && std::none_of(read.begin(), read.end(), is_here) &&
        std::none_of(doubtful.begin(), doubtful.end(), is_here))
      ++count.wrong;
  }
  return count;
}

}  // namespace angio
