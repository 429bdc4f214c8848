// Compares a case with VMTK's surface and centreline of the same scan. docs/accuracy.md explains
// it.
//
//     against_vmtk SURFACE.vtp CENTERLINE.vtp CASE [--markdown FILE]     (VMTK's files are in RAS)

#include <fmt/format.h>
#include <vtkDataArray.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkXMLPolyDataReader.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "centerline/centerline.hpp"
#include "core/centerline.hpp"
#include "core/error.hpp"
#include "core/frames.hpp"
#include "core/triangle_mesh.hpp"
#include "core/volume.hpp"
#include "segmentation/read_volume.hpp"
#include "testing/result_table.hpp"

namespace angio {
namespace {

/// Lines whose ends differ by this much count as of different branches [mm].
constexpr double kSameBranchMm = 4.0;

enum class Frame { ras, lps };

void read(const std::filesystem::path& path, vtkPolyData& data) {
  if (!std::filesystem::exists(path)) throw InputError("there is no " + path.string());
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  data.ShallowCopy(reader->GetOutput());
}

Vec3 point_of(vtkPolyData& data, vtkIdType p, Frame frame) {
  double x[3];
  data.GetPoint(p, x);
  return frame == Frame::ras ? lps_from_ras({x[0], x[1], x[2]}) : Vec3{x[0], x[1], x[2]};
}

TriangleMesh read_mesh(const std::filesystem::path& path, Frame frame) {
  vtkNew<vtkPolyData> data;
  read(path, *data);
  TriangleMesh mesh;
  for (vtkIdType p = 0; p < data->GetNumberOfPoints(); ++p)
    mesh.vertices.push_back(point_of(*data, p, frame));
  vtkNew<vtkIdList> corners;
  for (vtkIdType c = 0; c < data->GetNumberOfCells(); ++c) {
    data->GetCellPoints(c, corners);
    for (vtkIdType i = 2; i < corners->GetNumberOfIds(); ++i)
      mesh.triangles.push_back(
          {int(corners->GetId(0)), int(corners->GetId(i - 1)), int(corners->GetId(i))});
  }
  return mesh;
}

CenterlineTree read_lines(const std::filesystem::path& path, Frame frame) {
  vtkNew<vtkPolyData> data;
  read(path, *data);
  vtkDataArray* radius = data->GetPointData()->GetArray("MaximumInscribedSphereRadius");
  if (!radius) throw InputError(path.string() + " has no MaximumInscribedSphereRadius");
  CenterlineTree tree;
  vtkNew<vtkIdList> points;
  for (vtkIdType c = 0; c < data->GetNumberOfCells(); ++c) {
    data->GetCellPoints(c, points);
    CenterlinePath line;
    line.id = int(c);
    for (vtkIdType i = 0; i < points->GetNumberOfIds(); ++i) {
      line.points.push_back(point_of(*data, points->GetId(i), frame));
      line.inscribed_radius.push_back(radius->GetTuple1(points->GetId(i)));
    }
    line.equivalent_radius = line.inscribed_radius;
    line.abscissa = arc_length(line.points);
    if (line.points.size() > 1) tree.paths.push_back(std::move(line));
  }
  return tree;
}

using Cells = std::vector<std::string>;

Cells summary(const std::string& what, std::vector<double> distances, double signed_sum) {
  if (distances.empty()) return {what, "nothing to compare", "", "", "0"};
  double sum = 0.0;
  for (double d : distances) sum += d;
  const double count = double(distances.size());
  const auto at = distances.begin() + std::ptrdiff_t(0.95 * (count - 1.0));
  std::nth_element(distances.begin(), at, distances.end());
  return {what, fmt::format("{:.3f}", sum / count), fmt::format("{:.3f}", *at),
          fmt::format("{:+.3f}", signed_sum / count), std::to_string(distances.size())};
}

/// Points of a surface in a signed distance; those far away are of branches that one side lacks.
Cells compare_surface(const std::string& what, const TriangleMesh& mesh,
                      const Volume<float>& level_set) {
  std::vector<double> distances;
  double signed_sum = 0.0;
  for (const Vec3& point : mesh.vertices) {
    const double d = interpolate(level_set, point);
    if (std::abs(d) > kSameBranchMm) continue;
    distances.push_back(std::abs(d));
    signed_sum += d;
  }
  return summary(what, std::move(distances), signed_sum);
}

/// Points of `reference` from the nearest point of `tree`; signed: its radius minus theirs.
Cells compare_lines(const std::string& what, const CenterlineTree& tree,
                    const CenterlineTree& reference) {
  std::vector<double> distances;
  double radius_sum = 0.0;
  for (const CenterlinePath& line : reference.paths)
    for (std::size_t p = 0; p < line.points.size(); ++p) {
      double best = kSameBranchMm, radius = 0.0;
      for (const CenterlinePath& path : tree.paths) {
        const CenterlineSample at = sample(path, project(path, line.points[p]));
        if (distance(at.point, line.points[p]) >= best) continue;
        best = distance(at.point, line.points[p]);
        radius = at.inscribed_radius;
      }
      if (best == kSameBranchMm) continue;
      distances.push_back(best);
      radius_sum += radius - line.inscribed_radius[p];
    }
  return summary(what, std::move(distances), radius_sum);
}

void compare(const std::filesystem::path& surface, const std::filesystem::path& line,
             const std::filesystem::path& folder, benchmarks::ResultTable& results) {
  const TriangleMesh their_surface = read_mesh(surface, Frame::ras);
  const CenterlineTree their_line = read_lines(line, Frame::ras);
  const Volume<float> our_level_set =
      segmentation::read_volume_file(folder / "segmentation/lumen_level_set.nrrd");
  const CenterlineTree our_line = read_lines(folder / "centerline/centerlines.vtp", Frame::lps);
  const auto start = std::chrono::steady_clock::now();
  const CenterlineTree line_of_theirs = centerline::extract_centerline(their_surface, {}).tree;
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  results.columns({"compared", "mean mm", "95 % mm", "signed mm", "points"});
  results.row(compare_surface("VMTK's surface from our level set's zero (signed: + outside ours)",
                              their_surface, our_level_set));
  results.row(compare_lines("VMTK's line from ours of the image (signed: our radius - VMTK's)",
                            our_line, their_line));
  results.row(
      compare_lines(fmt::format("VMTK's line from ours of VMTK's surface, {:.2f} s", seconds),
                    line_of_theirs, their_line));
}

}  // namespace
}  // namespace angio

int main(int argc, char** argv) try {
  angio::benchmarks::ResultTable results("A case against VMTK's surface and line", argc, argv);
  if (argc != 4) {
    fmt::print(stderr, "usage: against_vmtk SURFACE.vtp CENTERLINE.vtp CASE [--markdown FILE]\n");
    return EXIT_FAILURE;
  }
  angio::compare(argv[1], argv[2], argv[3], results);
  results.write();
  return EXIT_SUCCESS;
} catch (const std::exception& error) {
  fmt::print(stderr, "against_vmtk: {}\n", error.what());
  return EXIT_FAILURE;
}
