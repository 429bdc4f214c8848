#include "testing/viewer/report_content.hpp"

#include <cmath>
#include <string>

#include "testing/viewer/shapes.hpp"

namespace angio::viewer::test {
namespace {

constexpr double kBalloonFirst = 9.0;  // [mm] along z
constexpr double kBalloonLast = 21.0;  // [mm]

/// The part of a tube's mesh between two heights.
TriangleMesh piece(const TriangleMesh& mesh, double z0, double z1) {
  TriangleMesh result;
  std::vector<int> new_index(mesh.vertices.size(), -1);
  for (const Triangle& triangle : mesh.triangles) {
    Triangle kept{};
    bool inside = true;
    for (const int corner : triangle) {
      const double z = mesh.vertices[std::size_t(corner)].z;
      inside = inside && z > z0 && z < z1;
    }
    if (!inside) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      int& index = new_index[std::size_t(triangle[c])];
      if (index < 0) {
        index = int(result.vertices.size());
        result.vertices.push_back(mesh.vertices[std::size_t(triangle[c])]);
      }
      kept[c] = index;
    }
    result.triangles.push_back(kept);
  }
  return result;
}

DiameterProfile profile_of(const TubeShape& shape) {
  const CenterlinePath path = make_path(shape);
  DiameterProfile profile;
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    if (path.points[i].z < kBalloonFirst - 3.0 || path.points[i].z > kBalloonLast + 3.0) continue;
    profile.abscissa_mm.push_back(path.abscissa[i]);
    profile.inscribed_diameter_mm.push_back(2.0 * path.inscribed_radius[i]);
    profile.equivalent_diameter_mm.push_back(2.05 * path.equivalent_radius[i]);
  }
  return profile;
}

Moment moment_of(const TubeShape& shape, const std::string& title, double balloon_radius_mm,
                 double pressure_kpa) {
  Moment moment;
  moment.title = title;
  moment.wall = piece(make_tube(shape), kBalloonFirst - 4.0, kBalloonLast + 4.0);
  moment.balloon = make_balloon(shape, kBalloonFirst, kBalloonLast, balloon_radius_mm);
  for (const Vec3& vertex : moment.wall.vertices)
    moment.contact_pressure_kpa.push_back(
        pressure_kpa * std::exp(-std::pow((vertex.z - 0.5 * shape.length_mm) / 2.5, 2)));
  return moment;
}

TimeSeries make_series() {
  TimeSeries series;
  series.columns = {"frame",
                    "time_s",
                    "phase",
                    "pressure_atm",
                    "balloon_volume_mm3",
                    "balloon_diameter_mm",
                    "lumen_mld_mm",
                    "friction_delta_mm",
                    "viscous_delta_mm",
                    "contact_count",
                    "min_air_volume_mm3",
                    "max_penetration_mm",
                    "air_tet_count",
                    "flip_count"};
  for (int frame = 0; frame <= 300; ++frame) {
    const double time = 0.025 * frame;
    const char* phase = time < 4.0   ? "inflate"
                        : time < 5.0 ? "hold"
                        : time < 7.0 ? "deflate"
                                     : "rest";
    const double load = time < 4.0   ? time / 4.0
                        : time < 5.0 ? 1.0
                        : time < 7.0 ? 1.0 - (time - 5.0) / 2.0
                                     : 0.0;
    const double gain = time < 5.0 ? load : 0.6 + 0.4 * load;
    const auto number = [](double value) { return std::to_string(value); };
    series.rows.push_back({std::to_string(frame), number(time), phase, number(8.0 * load * load),
                           number(20.0 + 60.0 * load), number(0.9 + 2.1 * load),
                           number(1.2 + 1.5 * gain), number(0.2 * load * (1.0 - load)),
                           number(0.05 * load), std::to_string(int(220 * load)), number(1e-5), "0",
                           "5300", std::to_string(frame % 17)});
  }
  return series;
}

}  // namespace

ReportContent make_report_content() {
  const TubeShape before;
  TubeShape peak = before, after = before;
  peak.depth = 0.02;
  after.depth = 0.2;
  ReportContent content;
  content.title = "Synthetic case";
  content.version = "0.0.0-test";
  const TubeVolumes volumes = make_volumes(before);
  content.volume = volumes.volume;
  content.level_set = volumes.level_set;
  content.lumen = make_tube(before);
  content.tree.paths = {make_path(before)};
  content.lesion_abscissa_mm = content.tree.paths[0].abscissa[60];
  content.moments = {moment_of(before, "Before", 0.45, 0.0),
                     moment_of(peak, "At peak, 8.0 atm", 1.45, 240.0),
                     moment_of(after, "After", 0.5, 0.0)};
  content.before = profile_of(before);
  content.peak = profile_of(peak);
  content.after = profile_of(after);
  content.flow_abscissa_mm = {0.0, 12.0, 18.0, 30.0};
  content.flow_before = {{1.0, 0.99, 0.72, 0.71}, {1.0, 0.98, 0.64, 0.62}, {1.0, 1.0, 0.79, 0.78}};
  content.flow_after = {{1.0, 0.99, 0.95, 0.94}, {1.0, 0.98, 0.93, 0.92}, {1.0, 1.0, 0.97, 0.96}};
  content.views.working = angiogram::find_working_view(content.tree, {0, 12.0, 19.0}, {});
  content.views.angiograms = {{"Before, AP", 0.5, 40, std::vector<double>(1600, 1.0)},
                              {"After, AP", 0.5, 40, std::vector<double>(1600, 0.5)}};
  content.balloon_chart = {{4.0, 8.0, 14.0}, {2.85, 3.0, 3.15}};
  content.time_series = make_series();
  content.metrics_json = R"({"lesion":{"centerline_id":0,"abscissa_mm":15.3,"mld_mm":1.2,
    "mla_mm2":1.13,"reference_diameter_mm":3.0,"reference_rule":"interpolated",
    "diameter_stenosis_percent":60.0,"length_mm":8.2},
    "balloon":{"nominal_diameter_mm":3.0,"length_mm":12.0,"material":"pa12",
    "peak_pressure_atm":8.0,"rated_burst_atm":14.0,"below_chart_mm":0.06,"peak_diameter_mm":2.94,"balloon_to_artery_ratio":0.98},
    "result":{"mld_mm":2.4,"mla_mm2":4.52,"diameter_stenosis_percent":20.0,
    "acute_gain_mm":1.2,"recoil_mm":0.54,"recoil_percent":18.4,"mld_range_mm":[2.395,2.405],
    "acute_gain_range_mm":[1.195,1.205],"recoil_range_percent":[18.2,18.5]},
    "peak":{"mld_mm":2.9,"mla_mm2":6.7,"contact_gap_mm":0.02},
    "flow":{"reason":null,"vessel":"coronary","model":"young-tsai","inlet_flow_ml_min":148.4,"behind_mm":18.0,
    "ffr_before":0.72,"ffr_before_range":[0.64,0.79],"ffr_after":0.95,
    "ffr_after_range":[0.93,0.97],"pressure_drop_before_mmhg":25.1},
    "simulation":{"backend":"cpu","device":"test","frame_count":301,"simulated_s":7.5,
    "max_penetration_mm":0.0,"inverted_air_tets":0},
    "mesh":{"lumen_triangles":2880,"lumen_vertices":1464,"watertight":true,
    "self_intersections":0,"min_angle_degrees":31.2}})";
  content.run_json = R"({"version":"0.0.0-test","backend":"cpu","device":"test","stages":
    {"segmentation":{"status":"done","seconds":12.34,"peak_memory_mib":512.0},
     "centerline":{"status":"done","seconds":3.2,"peak_memory_mib":128.0}}})";
  return content;
}

}  // namespace angio::viewer::test
