#include "testing/viewer/case_folder.hpp"

#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

#include "core/atomic_file.hpp"
#include "formats/files.hpp"
#include "testing/viewer/report_content.hpp"

namespace angio::viewer::test {
namespace {

std::string frame_file(const char* kind, int frame) {
  char name[64];
  std::snprintf(name, sizeof(name), "frames/%s_%06d.vtp", kind, frame);
  return name;
}

void write_frames(const std::filesystem::path& folder, const std::vector<Moment>& moments) {
  constexpr int kEvery = 60;
  std::vector<formats::TimeStep> steps;
  for (int i = 0; i < 6; ++i) {
    const int frame = kEvery * i;
    const Moment& moment = moments[i < 2 ? 0 : i < 4 ? 1 : 2];
    const DataArray pressure{"contact_pressure", moment.contact_pressure_kpa, 1,
                             ArrayType::float32};
    formats::write_surface(folder / frame_file("balloon", frame), {moment.balloon, {}, {}});
    formats::write_surface(folder / frame_file("vessel", frame), {moment.wall, {pressure}, {}});
    steps.push_back({0.025 * frame, 0, frame_file("balloon", frame)});
    steps.push_back({0.025 * frame, 1, frame_file("vessel", frame)});
  }
  formats::write_collection(folder / "simulation.pvd", steps);
}

void write_table(const std::filesystem::path& path, const TimeSeries& series) {
  const auto line = [](const std::vector<std::string>& cells) {
    std::string text;
    for (const std::string& cell : cells) text += (text.empty() ? "" : ",") + cell;
    return text + "\n";
  };
  std::string text = line(series.columns);
  for (const auto& row : series.rows) text += line(row);
  write_text_atomically(path, text);
}

}  // namespace

void write_nrrd(const std::filesystem::path& path, const Volume<float>& volume) {
  const VolumeGeometry& grid = volume.geometry;
  std::ostringstream text;
  text.precision(17);
  text << "NRRD0004\n# a comment\ntype: float\ndimension: 3\nspace: left-posterior-superior\n"
       << "sizes: " << grid.size[0] << ' ' << grid.size[1] << ' ' << grid.size[2]
       << "\nspace directions:";
  for (int axis = 0; axis < 3; ++axis) {
    text << " (";
    for (int row = 0; row < 3; ++row)
      text << (row ? "," : "") << grid.direction(row, axis) * grid.spacing[axis];
    text << ")";
  }
  text << "\nkinds: domain domain domain\nendian: little\nencoding: raw\nspace origin: ("
       << grid.origin.x << ',' << grid.origin.y << ',' << grid.origin.z << ")\n\n";
  text.write(reinterpret_cast<const char*>(volume.values.data()),
             std::streamsize(volume.values.size() * sizeof(float)));
  write_text_atomically(path, text.str());
}

void write_case(const std::filesystem::path& folder) {
  const ReportContent content = make_report_content();
  write_nrrd(folder / "segmentation" / "volume.nrrd", *content.volume);
  formats::write_surface(folder / "meshing" / "lumen.vtp", {content.lumen, {}, {}});
  const CenterlinePath& path = content.tree.paths[0];
  formats::PolylineData lines;
  lines.points = path.points;
  lines.lines.emplace_back();
  for (int i = 0; i < int(path.points.size()); ++i) lines.lines[0].push_back(i);
  lines.point_arrays.push_back(
      {"MaximumInscribedSphereRadius", path.inscribed_radius, 1, ArrayType::float64});
  formats::write_polylines(folder / "centerline" / "centerlines.vtp", lines);
  write_frames(folder / "simulation", content.moments);
  write_table(folder / "simulation" / "timeseries.csv", content.time_series);
}

}  // namespace angio::viewer::test
