// Whether a vessel's wall stays even while a balloon opens it: before, at the peak and after, of
// the wall within the balloon's span of any case folder.
//
//     wall_shape CASE... [--markdown FILE]
//
// Exit codes: 0 done, 1 a folder is no case.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/atomic_file.hpp"
#include "core/centerline.hpp"
#include "core/error.hpp"
#include "core/statistics.hpp"
#include "formats/case_file.hpp"
#include "formats/files.hpp"
#include "pipeline/case/case_files.hpp"
#include "testing/meshing/wall_measure.hpp"
#include "testing/result_table.hpp"

namespace angio::benchmarks {
namespace {
namespace fs = std::filesystem;
namespace file = formats::case_file;
using nlohmann::json;

/// The wall at one moment, with the line through the balloon's middle.
struct Moment {
  pipeline::FrameShape shape;
  CenterlinePath wire;
  std::vector<Vec3> along;  ///< at each vertex of the wall
};

Moment at_frame(const fs::path& frames, int frame) {
  Moment moment{pipeline::read_frame(frames, frame), {}, {}};
  moment.wire.points =
      formats::read_polylines(frames / fmt::format("guidewire_{:06}.vtp", frame)).points;
  moment.wire.abscissa = arc_length(moment.wire.points);
  moment.wire.inscribed_radius.assign(moment.wire.points.size(), 0.0);
  moment.wire.equivalent_radius = moment.wire.inscribed_radius;
  for (const Vec3& p : moment.shape.wall.vertices)
    moment.along.push_back(sample(moment.wire, project(moment.wire, p)).tangent);
  return moment;
}

/// The vessel's own wall alongside the balloon: not past its ends, nor where a branch turns away.
std::vector<char> wall_beside(const Moment& before) {
  constexpr double kLeastCosine = 0.5;  // of the angle between the wall and the way out
  const TriangleMesh& wall = before.shape.wall;
  const std::vector<Vec3> normals = vertex_normals(wall);
  std::vector<char> chosen(wall.vertices.size(), 0);
  for (std::size_t v = 0; v < chosen.size(); ++v) {
    const double s = project(before.wire, wall.vertices[v]);
    const Vec3 out = normalized(wall.vertices[v] - sample(before.wire, s).point);
    chosen[v] = s > 0.0 && s < before.wire.abscissa.back() && dot(out, normals[v]) > kLeastCosine;
  }
  return chosen;
}

std::vector<double> aspects_of(const TriangleMesh& wall, const std::vector<char>& chosen) {
  const std::vector<double> all = triangle_aspects(wall);
  std::vector<double> result;
  for (std::size_t t = 0; t < all.size(); ++t)
    if (std::all_of(wall.triangles[t].begin(), wall.triangles[t].end(),
                    [&](int v) { return chosen[std::size_t(v)] != 0; }))
      result.push_back(all[t]);
  if (result.empty()) throw InputError("there is no wall along the balloon");
  return result;
}

/// Shares of the edges in percent.
struct Bent {
  double turned = 0.0;      ///< by more than 30 degrees since before
  double newly_bent = 0.0;  ///< by more than 30 degrees, and by less than 15 before
  double most = 0.0;        ///< turned [degrees]
};

Bent bent_since(const TriangleMesh& before, const TriangleMesh& now,
                const std::vector<char>& chosen) {
  constexpr double kBent = 30.0, kFlat = 15.0;
  const auto edges = unique_edges(before);
  const std::vector<double> first = edge_bends(before), then = edge_bends(now);
  int count = 0, turned = 0, newly_bent = 0;
  Bent bent;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    if (!chosen[std::size_t(edges[e][0])] || !chosen[std::size_t(edges[e][1])]) continue;
    const double turn = std::abs(then[e] - first[e]);
    ++count;
    turned += turn > kBent;
    newly_bent += std::abs(then[e]) > kBent && std::abs(first[e]) < kFlat;
    bent.most = std::max(bent.most, turn);
  }
  bent.turned = 100.0 * turned / std::max(1, count);
  bent.newly_bent = 100.0 * newly_bent / std::max(1, count);
  return bent;
}

/// A tube's section across the wire where it passes a place of the vessel.
TubeSection section_at(const Moment& moment, const TriangleMesh& tube, const Vec3& place) {
  const CenterlineSample at = sample(moment.wire, project(moment.wire, place));
  return section_of(tube, at.point, at.tangent);
}

std::string oval(const TubeSection& section) {
  return fmt::format("{:.2f} x {:.2f}", section.narrowest_mm, section.widest_mm);
}

std::vector<TubePoint> vertices_of(const Moment& moment, const std::vector<char>& chosen) {
  std::vector<TubePoint> points;
  for (std::size_t v = 0; v < chosen.size(); ++v)
    if (chosen[v]) points.push_back({moment.shape.wall.vertices[v], moment.along[v]});
  return points;
}

/// The vertices and the middles of edges: points of the facets, too.
std::vector<TubePoint> surface_of(const Moment& moment, const std::vector<char>& chosen) {
  std::vector<TubePoint> points = vertices_of(moment, chosen);
  const std::vector<Vec3>& x = moment.shape.wall.vertices;
  for (const auto& [i, j] : unique_edges(moment.shape.wall)) {
    const auto a = std::size_t(i), b = std::size_t(j);
    if (chosen[a] && chosen[b])
      points.push_back({0.5 * (x[a] + x[b]), normalized(moment.along[a] + moment.along[b])});
  }
  return points;
}

struct Tables {
  std::vector<std::vector<std::string>> edges, sections, results;
};

void measure(const fs::path& folder, Tables& tables) {
  const fs::path named = fs::absolute(folder / ".").parent_path();
  const json summary = json::parse(read_text(folder / file::kSummary)),
             placement = json::parse(read_text(folder / file::kPlacement));
  const auto frame = [&](const char* key) {
    return at_frame(folder / file::kFrames, summary.at(key).get<int>());
  };
  const Moment before = at_frame(folder / file::kFrames, 0), peak = frame("peak_frame"),
               after = frame("last_frame");
  const std::vector<char> chosen = wall_beside(before);
  std::vector<double> vertices, surface;
  for (const Moment* moment : {&before, &peak, &after}) {
    vertices.push_back(unevenness(vertices_of(*moment, chosen)).mm);
    surface.push_back(unevenness(surface_of(*moment, chosen)).percent);
  }
  const Bent at_peak = bent_since(before.shape.wall, peak.shape.wall, chosen),
             at_end = bent_since(before.shape.wall, after.shape.wall, chosen);
  const std::vector<double> first = aspects_of(before.shape.wall, chosen),
                            then = aspects_of(peak.shape.wall, chosen);
  const std::string name = named.filename().string();
  tables.edges.push_back(
      {name, fmt::format("{}", std::count(chosen.begin(), chosen.end(), 1)),
       fmt::format("{:.1f}", at_peak.turned), fmt::format("{:.1f}", at_end.turned),
       fmt::format("{:.1f}", at_peak.newly_bent), fmt::format("{:.0f}", at_peak.most),
       fmt::format("{:.1f}, {:.1f}", quantile(first, 0.5), quantile(first, 0.95)),
       fmt::format("{:.1f}, {:.1f}", quantile(then, 0.5), quantile(then, 0.95)),
       fmt::format("{:.4f}, {:.4f}, {:.4f}", vertices[0], vertices[1], vertices[2]),
       fmt::format("{:.2f}, {:.2f}, {:.2f}", surface[0], surface[1], surface[2]),
       fmt::format("{:.2f}, {:.2f}", surface[1] / surface[0], surface[2] / surface[0])});
  const json& point = placement.at("site").at("point");
  const Vec3 throat{point[0].get<double>(), point[1].get<double>(), point[2].get<double>()};
  const TubeSection wall = section_at(before, before.shape.wall, throat),
                    wide = section_at(peak, peak.shape.wall, throat),
                    balloon = section_at(peak, peak.shape.balloon, throat),
                    end = section_at(after, after.shape.wall, throat);
  tables.sections.push_back(
      {name, oval(wall), oval(balloon), oval(wide), oval(end),
       fmt::format("{:.3f}", wall.roundness), fmt::format("{:.3f}", balloon.roundness),
       fmt::format("{:.3f}", wide.roundness), fmt::format("{:.3f}", end.roundness),
       fmt::format("{:.3f}", wide.area_mm2 / balloon.area_mm2)});
  const json metrics = json::parse(read_text(folder / file::kMetrics));
  const auto number = [&](const char* part, const char* key, int digits) {
    return fmt::format("{:.{}f}", metrics.at(part).at(key).get<double>(), digits);
  };
  tables.results.push_back(
      {name, number("mesh", "lumen_triangles", 0), number("mesh", "min_angle_degrees", 1),
       number("mesh", "volume_change_percent", 3), number("lesion", "mld_mm", 4),
       number("peak", "mld_mm", 4), number("result", "mld_mm", 4),
       number("result", "recoil_percent", 2), number("simulation", "frames_without_air", 0)});
}

void print(const Tables& tables, ResultTable& results) {
  results.section("Edges, triangles and unevenness along the balloon");
  results.paragraph(
      "Edges: share that has turned by more than 30 degrees since before; newly bent: over 30 "
      "degrees, below 15 before. Aspect: longest side over least height, 1 if equilateral; median, "
      "95th percentile. Uneven: rms distance of vertices, or of vertices and the middles of edges "
      "(the facets), from the smooth tube around them (quadratic within 45 degrees and 0.5 mm).");
  results.columns({"case", "vertices", "turned at peak %", "after %", "newly bent at peak %",
                   "most degrees", "aspect before", "at peak",
                   "vertices uneven before, at peak, after mm", "surface uneven, % of the radius",
                   "peak, after / before"});
  for (const auto& row : tables.edges) results.row(row);
  results.section("The section at the throat");
  results.paragraph(
      "Least and greatest width [mm]; roundness 4 pi area / length^2 (20 sides: 0.992, 16: "
      "0.987).");
  results.columns({"case", "lumen before", "balloon at peak", "lumen at peak", "lumen after",
                   "roundness before", "of the balloon", "at peak", "after",
                   "area at peak / balloon's"});
  for (const auto& row : tables.sections) results.row(row);
  results.section("Mesh and results");
  results.columns({"case", "lumen triangles", "least angle", "volume change %", "MLD before mm",
                   "at peak", "after", "recoil %", "frames without air"});
  for (const auto& row : tables.results) results.row(row);
}

}  // namespace
}  // namespace angio::benchmarks

int main(int argc, char** argv) try {
  using namespace angio::benchmarks;
  ResultTable results("The wall's shape under the balloon", argc, argv);
  Tables tables;
  int failed = 0;
  for (int i = 1; i < argc; ++i) try {
      measure(argv[i], tables);
    } catch (const angio::Error& error) {
      fmt::print(stderr, "{}: {}\n", argv[i], error.what());
      ++failed;
    }
  print(tables, results);
  results.write();
  return failed == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
} catch (const std::exception& error) {
  fmt::print(stderr, "wall_shape: {}\n", error.what());
  return EXIT_FAILURE;
}
