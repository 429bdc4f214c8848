// How near the vessels found from real angiograms of a C-arm that stood still come to the lines
// that others have made of the same: a physical phantom of coronary arteries, seen from four sides
// (ArsoVukicevic/X-Ray-Angio-data), with its authors' centreline.
//
//     view_phantom FOLDER [--views 1,2,...]... [--pictures DIR] [--markdown FILE]
//
// FOLDER holds the views, as DICOM, and centerlines.vtk. A row for all views and one for each
// --views, as `angio run` takes them. The authors' lines lie in a frame of their own: they are laid
// on those that were found by a rigid motion. DIR/view_phantom_N.png: view N of the first row, with
// both.
#include <fmt/format.h>
#include <vtkCell.h>
#include <vtkNew.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridReader.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/line_registration.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/statistics.hpp"
#include "pipeline/case/case_files.hpp"
#include "pipeline/experiments/workflow.hpp"
#include "pipeline/stages/report_views.hpp"
#include "pipeline/stages/run_case.hpp"
#include "testing/result_table.hpp"
#include "testing/temporary_folder.hpp"
#include "viewer/detail/canvas.hpp"
#include "viewer/detail/grey_window.hpp"

namespace {

namespace fs = std::filesystem;
using namespace angio;
using benchmarks::formatted;
using Lines = std::vector<std::vector<Vec3>>;

struct Arguments {
  fs::path folder, pictures;
  std::vector<std::string> views = {""};  ///< as `angio run` takes them; empty: all
};

/// @return false if they make no sense
bool parse(int argc, char** argv, Arguments& arguments) {
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--views" && i + 1 < argc)
      arguments.views.emplace_back(argv[++i]);
    else if (word == "--pictures" && i + 1 < argc)
      arguments.pictures = argv[++i];
    else if (word.starts_with("-") || !arguments.folder.empty())
      return false;
    else
      arguments.folder = word;
  }
  return !arguments.folder.empty();
}

Lines read_authors_lines(const fs::path& file) {
  vtkNew<vtkUnstructuredGridReader> reader;
  reader->SetFileName(file.c_str());
  reader->Update();
  vtkUnstructuredGrid* grid = reader->GetOutput();
  Lines lines;
  for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c) {
    std::vector<Vec3>& line = lines.emplace_back();
    vtkCell* cell = grid->GetCell(c);
    for (int n = 0; n < int(cell->GetNumberOfPoints()); ++n) {
      const double* at = grid->GetPoint(cell->GetPointId(n));
      line.push_back({at[0], at[1], at[2]});
    }
  }
  if (lines.empty()) throw InputError(file.filename().string() + " holds no lines");
  return lines;
}

/// Stretches that paths share once.
Lines lines_of(const CenterlineTree& tree) {
  Lines lines;
  for (std::size_t p = 0; p < tree.paths.size(); ++p) {
    const auto& points = tree.paths[p].points;
    std::size_t shared = 0;
    for (std::size_t q = 0; q < p; ++q) {
      const auto& other = tree.paths[q].points;
      std::size_t n = 0;
      while (n < std::min(points.size(), other.size()) && points[n] == other[n]) ++n;
      shared = std::max(shared, n);
    }
    const std::size_t first = shared > 0 ? shared - 1 : 0;
    if (first + 1 < points.size())
      lines.emplace_back(points.begin() + std::ptrdiff_t(first), points.end());
  }
  return lines;
}

/// Points along lines, evenly.
std::vector<Vec3> points_along(const Lines& lines) {
  constexpr double kStep = 0.5;  // [mm]
  std::vector<Vec3> points;
  for (const std::vector<Vec3>& line : lines) {
    double next = 0.0, before = 0.0;
    for (std::size_t n = 1; n < line.size(); ++n) {
      const double length = distance(line[n - 1], line[n]);
      for (; next < before + length; next += kStep)
        points.push_back(line[n - 1] + (next - before) / length * (line[n] - line[n - 1]));
      before += length;
    }
  }
  return points;
}

/// What `angio run` gave.
struct Found {
  Lines lines;
  std::vector<viewer::XrayPicture> pictures;
  nlohmann::json quality;
  double seconds = 0.0;
};

Found find_vessels(const fs::path& input, const std::string& views) {
  const test::TemporaryFolder folder;
  pipeline::RunRequest request;
  request.input = input.string();
  request.case_folder = folder.path() / "case";
  request.config.input.views = views;
  request.until = pipeline::Stage::reconstruction;
  pipeline::Reporter reporter(pipeline::ReportStyle::quiet);
  const auto start = std::chrono::steady_clock::now();
  run_case(pipeline::workflow_of(request.config), request, reporter);
  Found found;
  found.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const fs::path stage = request.case_folder / "reconstruction";
  found.lines = lines_of(pipeline::read_centerlines(stage / "centerlines.vtp"));
  found.quality = nlohmann::json::parse(read_text(stage / "quality.json"));
  found.pictures =
      pipeline::xray_frames({pipeline::CaseFolder(request.case_folder), {"reconstruction/"}});
  return found;
}

double part_within(const std::vector<double>& distances, double most) {
  return double(std::count_if(distances.begin(), distances.end(),
                              [most](double one) { return one < most; })) /
         double(distances.size());
}

std::string three_of(const std::vector<double>& distances) {
  const double mean =
      std::accumulate(distances.begin(), distances.end(), 0.0) / double(distances.size());
  return formatted("%.2f, %.2f, %.2f", mean, median(distances), quantile(distances, 0.95));
}

double length_of(const Lines& lines) {
  double length = 0.0;
  for (const auto& line : lines)
    for (std::size_t n = 1; n < line.size(); ++n) length += distance(line[n - 1], line[n]);
  return length;
}

void draw(viewer::detail::Canvas& canvas, const Lines& lines, const angiogram::ConeBeamFrame& place,
          double zoom, const viewer::detail::Rgb& color) {
  const angiogram::ConeBeamView view(place);
  for (const std::vector<Vec3>& line : lines) {
    std::vector<viewer::detail::Spot> spots;
    for (const Vec3& point : line) {
      const angiogram::SeenPoint seen = view.see(point);
      spots.push_back({zoom * (seen.column + 0.5), zoom * (seen.row + 0.5)});
    }
    canvas.draw_line(spots, color, 1);
  }
}

/// In words what the first row misses: what is to be seen, and what was measured.
void write_missed(const nlohmann::json& quality, double scale, benchmarks::ResultTable& table) {
  double farthest = 0.0, turned = 0.0, least = 100.0, most = 0.0;
  for (const auto& view : quality.at("views")) {
    const auto length = [&](const char* key) {
      const auto vector = view.at(key).get<std::array<double, 3>>();
      return std::hypot(vector[0], vector[1], vector[2]);
    };
    farthest = std::max(farthest, length("shift_mm"));
    turned = std::max(turned, length("turn_degrees"));
    const double part = view.at("lines_explained_percent").get<double>();
    least = std::min(least, part);
    most = std::max(most, part);
  }
  table.paragraph(
      "What is missed, by eye: the last centimetres of the branches, where the medium thins out or "
      "has not come yet, and the tube's way back to the stem; the authors' lines go on there. "
      "Where "
      "two vessels leave the stem side by side one is joined to the other, not to the stem.");
  table.paragraph(fmt::format(
      "What was measured of it: the found tree explains {:.0f} to {:.0f} % of the views' own "
      "lines; the views' C-arms were moved by up "
      "to {:.1f} mm and turned by up to {:.1f} degrees against the headers; the views' rays to the "
      "same places of the tree then pass {:.1f} mm beside each other (median); the authors' lines "
      "fit the found ones best at a scale of {:.3f}.",
      least, most, farthest, turned, quality.at("skew_mm").get<double>(), scale));
}

/// The frame, grey as on the angiogram, with both trees' lines.
void draw_view(const viewer::XrayPicture& picture, const Lines& found, const Lines& authors,
               const fs::path& file) {
  constexpr int kZoom = 1;
  constexpr viewer::detail::Rgb kFound{255, 120, 0}, kAuthors{0, 170, 255};
  const auto window = viewer::detail::window_of(picture.attenuation);
  viewer::detail::Picture large =
      viewer::detail::blank_picture(kZoom * picture.place.columns, kZoom * picture.place.rows);
  for (int y = 0; y < large.height; ++y)
    for (int x = 0; x < large.width; ++x) {
      const auto at =
          std::size_t(y / kZoom) * std::size_t(picture.place.columns) + std::size_t(x / kZoom);
      std::fill_n(large.rgb.begin() + 3 * (std::ptrdiff_t(y) * large.width + x), 3,
                  std::uint8_t(255 - window.shade(picture.attenuation[at])));
    }
  viewer::detail::Canvas canvas(std::move(large));
  draw(canvas, authors, picture.place, kZoom, kAuthors);
  draw(canvas, found, picture.place, kZoom, kFound);
  constexpr double kLetter = 8.0;
  canvas.write("found", {8.0, 18.0}, kLetter, kFound);
  canvas.write("authors'", {8.0, 32.0}, kLetter, kAuthors);
  write_text_atomically(file, png_bytes(canvas.picture()));
}

fs::path picture_file(const fs::path& folder, int view) {
  return folder / fmt::format("view_phantom_{}.png", view);
}

/// @return what `angio run` says of its result, and the authors' best scale
std::pair<nlohmann::json, double> measure(const Arguments& arguments, const std::string& views,
                                          const Lines& authors, const fs::path& pictures,
                                          benchmarks::ResultTable& table) {
  const Found found = find_vessels(arguments.folder, views);
  const std::vector<Vec3> to = points_along(found.lines), from = points_along(authors);
  const benchmarks::Similarity rigid = benchmarks::register_rigidly(from, to);
  const benchmarks::Similarity similar = benchmarks::with_scale(rigid, from, to);
  Lines laid = authors;
  for (auto& line : laid)
    for (Vec3& point : line) point = rigid.apply(point);
  const std::vector<Vec3> moved = points_along(laid);
  const std::vector<double> to_found = benchmarks::distances_to(moved, to),
                            to_authors = benchmarks::distances_to(to, moved);
  std::string numbers;
  for (const auto& view : found.quality.at("views"))
    numbers += (numbers.empty() ? "" : ", ") +
               fmt::format("{} ({:.0f}/{:.0f})", view.at("view").get<int>(),
                           view.at("primary_degrees").get<double>(),
                           view.at("secondary_degrees").get<double>());
  table.row({numbers, formatted("%.0f of %.0f", length_of(found.lines), length_of(authors)),
             formatted("%.0f, %.0f", 100.0 * part_within(to_found, 1.0),
                       100.0 * part_within(to_found, 2.0)),
             three_of(to_found), three_of(to_authors), formatted("%.3f", similar.scale),
             rigid.turn.determinant() < 0.0 ? "yes" : "no",
             formatted("%.2f", found.quality.at("agreement").get<double>()),
             formatted("%.0f", found.seconds)});
  for (std::size_t n = 0; n < found.pictures.size() && !pictures.empty(); ++n)
    draw_view(found.pictures[n], found.lines, laid,
              picture_file(pictures, found.quality.at("views")[n].at("view").get<int>()));
  return {found.quality, similar.scale};
}

}  // namespace

int main(int argc, char** argv) try {
  constexpr int kUsage = 64;
  benchmarks::ResultTable table("Vessels found from real views of a phantom", argc, argv);
  Arguments arguments;
  if (!parse(argc, argv, arguments)) {
    std::fprintf(stderr,
                 "usage: view_phantom FOLDER [--views 1,2,...]... [--pictures DIR] "
                 "[--markdown FILE]\n");
    return kUsage;
  }
  const Lines authors = read_authors_lines(arguments.folder / "centerlines.vtk");
  table.paragraph(
      "A physical phantom of coronary arteries (ArsoVukicevic/X-Ray-Angio-data), default options, "
      "nothing given but the files. The authors' centreline, in a frame of its own, is laid on the "
      "found lines by a rigid motion: iterative closest points of the nearest three quarters both "
      "ways, the best of eighty starts, forty of them mirrored. Covered: part of the authors' "
      "lines with a found one that near. Scale: of the authors' lines for the best similarity, "
      "which nothing else here uses. It is nobody's truth: their own error is not stated.");
  table.columns({"views (degrees)", "length found [mm]", "covered within 1 mm, 2 mm [%]",
                 "authors' to found: mean, median, 95 % [mm]",
                 "found to authors': mean, median, 95 % [mm]", "scale", "mirrored", "agreement",
                 "time [s]"});
  const auto [quality, scale] =
      measure(arguments, arguments.views.front(), authors, arguments.pictures, table);
  for (std::size_t n = 1; n < arguments.views.size(); ++n)
    measure(arguments, arguments.views[n], authors, {}, table);
  if (!arguments.pictures.empty()) {
    table.paragraph(
        "The first row's views, as they were used: orange what was found, blue the authors' line "
        "as it was laid on.");
    for (int view = 1; fs::exists(picture_file(arguments.pictures, view)); ++view)
      table.paragraph(
          fmt::format("![view {}](../images/{})", view, picture_file({}, view).string()));
  }
  write_missed(quality, scale, table);
  table.write();
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "view_phantom: %s\n", error.what());
  return 1;
}
