#include "viewer/detail/report_scene.hpp"

#include <vtkIdList.h>
#include <vtkQuadricDecimation.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/statistics.hpp"
#include "formats/vtk_arrays.hpp"
#include "viewer/detail/figure.hpp"
#include "viewer/detail/pictures_3d.hpp"
#include "viewer/detail/plane.hpp"
#include "viewer/detail/projection.hpp"
#include "viewer/detail/scene_payload.hpp"
#include "viewer/page_scripts.hpp"

namespace angio::viewer::detail {
using nlohmann::json;
namespace {

constexpr int kMostTriangles = 40000;         // of the tree
constexpr std::size_t kMostVoxels = 1500000;  // of the scan
constexpr double kScanMargin = 10.0;          // around the treated wall [mm]
constexpr double kWireRadius = 0.178;         // of a wire of 0.014 inch [mm]
constexpr double kLineRadius = 0.06;          // of the lines, of a usual lumen's radius
constexpr double kCursorRadius = 0.4;         // of the mark on the line, likewise
constexpr double kLevels = 1000.0;            // of a field

TriangleMesh with_fewer_triangles(const TriangleMesh& mesh) {
  const auto count = double(mesh.triangles.size());
  if (count <= kMostTriangles) return mesh;
  const auto decimate = vtkSmartPointer<vtkQuadricDecimation>::New();
  decimate->SetInputData(formats::to_vtk(mesh));
  decimate->SetTargetReduction(1.0 - kMostTriangles / count);
  decimate->Update();
  TriangleMesh fewer;
  fewer.vertices = formats::from_vtk(decimate->GetOutput()->GetPoints());
  vtkCellArray* cells = decimate->GetOutput()->GetPolys();
  const auto corners = vtkSmartPointer<vtkIdList>::New();
  for (cells->InitTraversal(); cells->GetNextCell(corners) != 0;)
    fewer.triangles.push_back(
        {int(corners->GetId(0)), int(corners->GetId(1)), int(corners->GetId(2))});
  return fewer;
}

json add_triangles(const std::vector<Triangle>& triangles, ScenePayload& payload) {
  std::vector<std::int32_t> corners;
  for (const Triangle& t : triangles) corners.insert(corners.end(), t.begin(), t.end());
  return payload.add_integers(corners, 3);
}

/// The lumen without the wall that moves.
TriangleMesh still_tree(const ReportContent& content) {
  if (content.course.empty()) return content.lumen;
  const Bounds whole = bounds(content.lumen);
  return surroundings(content.lumen, content.course.front().shape.wall, whole.center,
                      2.0 * whole.radius_mm);
}

json add_tree(const ReportContent& content, ScenePayload& payload) {
  const TriangleMesh mesh = with_fewer_triangles(still_tree(content));
  return {{"triangles", add_triangles(mesh.triangles, payload)},
          {"points", payload.add_points({mesh.vertices})}};
}

json add_lines(const CenterlineTree& tree, ScenePayload& payload) {
  json lines = json::array();
  for (const CenterlinePath& path : tree.paths)
    if (path.points.size() >= 2)
      lines.push_back(
          {{"vertex_count", path.points.size()}, {"points", payload.add_points({path.points})}});
  return lines;
}

/// One thing that moves. @param of  a moment's mesh
template <class Of>
json add_course(const std::vector<CourseFrame>& course, Of of, ScenePayload& payload) {
  std::vector<std::vector<Vec3>> places;
  for (const CourseFrame& frame : course) places.push_back(of(frame.shape).vertices);
  const TriangleMesh& first = of(course.front().shape);
  return {{"vertex_count", first.vertices.size()},
          {"triangles", add_triangles(first.triangles, payload)},
          {"points", payload.add_points(places)}};
}

double greatest_move(const std::vector<CourseFrame>& course) {
  const std::vector<Vec3>& start = course.front().shape.wall.vertices;
  double greatest = 0.0;
  for (const CourseFrame& frame : course)
    for (std::size_t v = 0; v < start.size(); ++v)
      greatest = std::max(greatest, distance(start[v], frame.shape.wall.vertices[v]));
  return greatest;
}

json add_pressure(const ReportContent& content, ScenePayload& payload) {
  const double greatest = usual_peak(content.moments), quantum = greatest / kLevels;
  const std::size_t count = content.course.front().shape.wall.vertices.size();
  std::vector<std::int32_t> levels;
  for (const CourseFrame& frame : content.course) {
    for (const double p : frame.shape.contact_pressure_kpa)
      levels.push_back(std::int32_t(std::lround(std::clamp(p / quantum, 0.0, kLevels))));
    levels.resize((std::size_t(&frame - content.course.data()) + 1) * count, 0);
  }
  return {
      {"greatest", greatest}, {"quantum", quantum}, {"array", payload.add_integers(levels, count)}};
}

json add_wire(const std::vector<CourseFrame>& course, ScenePayload& payload) {
  std::vector<std::vector<Vec3>> places;
  for (const CourseFrame& frame : course) places.push_back(frame.shape.guidewire);
  const std::size_t count = places.front().size();
  if (count < 2 || std::any_of(places.begin(), places.end(),
                               [&](const auto& place) { return place.size() != count; }))
    return nullptr;
  return {{"vertex_count", count}, {"radius", kWireRadius}, {"points", payload.add_points(places)}};
}

json frames_of(const std::vector<CourseFrame>& course) {
  json frames = json::array();
  for (const CourseFrame& frame : course)
    frames.push_back({{"time_s", frame.time_s},
                      {"phase", frame.phase},
                      {"pressure_atm", frame.pressure_atm},
                      {"is_peak", frame.is_peak}});
  return frames;
}

json rounded(const std::vector<double>& values, std::size_t count) {
  json out = json::array();
  for (std::size_t i = 0; i < count; ++i)
    out.push_back(i < values.size() && std::isfinite(values[i])
                      ? json(std::round(1e3 * values[i]) / 1e3)
                      : json());
  return out;
}

json diameters_of(const ReportContent& content, const CenterlinePath& path) {
  const std::vector<double>& abscissa = content.before.abscissa_mm;
  const std::vector<double>& before = content.before.inscribed_diameter_mm;
  json points = json::array();
  std::size_t narrowest = 0;
  for (std::size_t i = 0; i < abscissa.size(); ++i) {
    const Vec3 p = sample(path, abscissa[i]).point;
    points.push_back({p.x, p.y, p.z});
    if (before[i] < before[narrowest]) narrowest = i;
  }
  const std::size_t count = abscissa.size();
  return {{"abscissa", rounded(abscissa, count)},
          {"before", rounded(before, count)},
          {"peak", rounded(content.peak.inscribed_diameter_mm, count)},
          {"after", rounded(content.after.inscribed_diameter_mm, count)},
          {"points", points},
          {"narrowest", narrowest}};
}

/// The voxels around some places, each n-th where there are too many, in 256 grey levels.
json add_scan(const Volume<float>& scan, const std::vector<Vec3>& places, ScenePayload& payload) {
  const VolumeGeometry& grid = scan.geometry;
  const VoxelBox box = box_around(grid, places, kScanMargin);
  const auto sizes = [&](int step) {
    std::array<int, 3> size{};
    for (std::size_t k = 0; k < 3; ++k) size[k] = (box.last[k] - box.first[k]) / step + 1;
    return size;
  };
  int step = 1;
  std::array<int, 3> size = sizes(step);
  while (std::size_t(size[0]) * std::size_t(size[1]) * std::size_t(size[2]) > kMostVoxels)
    size = sizes(++step);
  std::vector<float> values;
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i)
        values.push_back(
            scan.at(box.first[0] + step * i, box.first[1] + step * j, box.first[2] + step * k));
  const double dark = percentile(values, 0.01), bright = percentile(values, 0.997);
  std::vector<std::int32_t> grey;
  for (const float v : values)
    grey.push_back(std::isfinite(v)
                       ? std::int32_t(std::lround(std::clamp(
                             255.0 * (v - dark) / std::max(1e-12, bright - dark), 0.0, 255.0)))
                       : 0);
  const Vec3 origin =
      grid.lps_from_index({double(box.first[0]), double(box.first[1]), double(box.first[2])});
  json direction = json::array();
  for (int axis = 0; axis < 3; ++axis)
    for (int row = 0; row < 3; ++row) direction.push_back(grid.direction(row, axis));
  return {{"origin", {origin.x, origin.y, origin.z}},
          {"spacing", {step * grid.spacing.x, step * grid.spacing.y, step * grid.spacing.z}},
          {"direction", direction},
          {"size", size},
          {"array", payload.add_integers(grey, 1)}};
}

json view_of(const ViewFrame& frame, const Bounds& around) {
  const Vec3 from = -4.0 * around.radius_mm * frame.direction;
  return {{"center", {around.center.x, around.center.y, around.center.z}},
          {"reach", 0.62 * around.radius_mm},
          {"from", {from.x, from.y, from.z}},
          {"up", {frame.up.x, frame.up.y, frame.up.z}}};
}

std::string scene_bytes(const ReportContent& content) {
  ScenePayload payload;
  const bool is_treated = !content.course.empty();
  const CenterlinePath* path = lesion_path(content);
  const double radius = path ? quantile(measured_radius(*path), 0.5, 1.0) : 1.0;
  const TriangleMesh& shown = is_treated ? content.course.front().shape.wall : content.lumen;
  json header = {
      {"tree", add_tree(content, payload)},
      {"lines", add_lines(content.tree, payload)},
      {"line_radius", kLineRadius * radius},
      {"cursor_radius", kCursorRadius * radius},
      {"frames", frames_of(content.course)},
      {"lesion", view_of(is_treated ? close_up_frame(content) : frame_tree(shown), bounds(shown))}};
  if (is_treated) {
    header["wall"] = add_course(
        content.course, [](const Moment& m) -> const TriangleMesh& { return m.wall; }, payload);
    header["wall"]["greatest_move"] = greatest_move(content.course);
    header["wall"]["pressure"] = add_pressure(content, payload);
    header["balloon"] = add_course(
        content.course, [](const Moment& m) -> const TriangleMesh& { return m.balloon; }, payload);
    header["wire"] = add_wire(content.course, payload);
  }
  if (path && !content.before.abscissa_mm.empty())
    header["diameters"] = diameters_of(content, *path);
  if (content.volume) header["scan"] = add_scan(*content.volume, shown.vertices, payload);
  return payload.bytes(header);
}

}  // namespace

std::string scene_section(const ReportContent& content) {
  if (content.lumen.triangles.empty()) return {};
  return std::string(
             "<section id=\"scene-part\"><h2>In three dimensions</h2>\n<div id=\"scene\"><p "
             "class=\"sub\">"
             "<button type=\"button\" id=\"scene-open\" hidden>Open the scene</button> Tree, wall, "
             "balloon") +
         (content.volume ? ", wire and scan" : " and wire") +
         ": turn them, cut them, play the inflation.</p></div>\n"
         "<noscript><p class=\"sub\">The scene needs scripts; all else on this page does "
         "not.</p></noscript>\n"
         "<script type=\"text/plain\" id=\"scene-program\">" +
         packed(kSceneProgram) + "</script>\n<script type=\"text/plain\" id=\"scene-data\">" +
         packed(scene_bytes(content)) + "</script>\n<script>" + kSceneStarter +
         "</script>\n</section>\n";
}

}  // namespace angio::viewer::detail
