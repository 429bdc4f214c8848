#include "pipeline/experiments/cloth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/atomic_file.hpp"
#include "formats/case_file.hpp"
#include "formats/files.hpp"
#include "pipeline/case/input_kind.hpp"
#include "pipeline/case/metrics.hpp"
#include "pipeline/version.hpp"
#include "simulation/cloth.hpp"
#include "viewer/cloth_report.hpp"

namespace angio::pipeline {
namespace file = formats::case_file;
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}

std::string cloth_file(std::size_t state) { return fmt::format("frames/cloth_{:06d}.vtp", state); }

/// The thickness at each vertex: the mean of the triangles around it, which is what a smooth map
/// shows.
std::vector<double> at_vertices(const TriangleMesh& mesh, const std::vector<double>& of_triangles) {
  std::vector<double> sum(mesh.vertices.size(), 0.0);
  std::vector<int> count(mesh.vertices.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const int v : mesh.triangles[t]) {
      sum[std::size_t(v)] += of_triangles[t];
      ++count[std::size_t(v)];
    }
  for (std::size_t v = 0; v < sum.size(); ++v) sum[v] /= std::max(1, count[v]);
  return sum;
}

/// A row per state: how far the corners are apart, and how thick the cloth is.
struct ClothTable {
  std::string csv =
      "step,stretch_percent,corner_distance_mm,thickness_min_mm,thickness_mean_mm,"
      "thickness_max_mm,thickness_center_mm,residual\n";

  void add(std::size_t step, const simulation::ClothState& state, const TriangleMesh& shape) {
    const auto& h = state.thickness_mm;
    const auto row = std::size_t(std::lround(std::sqrt(double(shape.vertices.size()))));
    const std::size_t center = shape.vertices.size() / 2;
    csv += fmt::format("{},{:.6g},{:.8g},{:.8g},{:.8g},{:.8g},{:.8g},{:.3g}\n", step,
                       100.0 * state.stretch, distance(shape.vertices[0], shape.vertices[row - 1]),
                       *std::min_element(h.begin(), h.end()), mean(h),
                       *std::max_element(h.begin(), h.end()), at_vertices(shape, h)[center],
                       state.residual);
  }
};

constexpr const char* kMesh = "meshing/cloth.vtp";
constexpr const char* kTable = "simulation/cloth.csv";

/// metrics.json: that of a vessel, until there is a cloth that has been pulled.
json cloth_metrics(const StageFiles& files, const Config& config, const RunRecord& record) {
  if (!record.is(Stage::simulation, "done") || !files.exists(kTable))
    return collect_metrics(files, config.lesion, json::object(), record);
  json metrics = empty_metrics();
  metrics["cloth"] = read_json(files.path(file::kSummary));
  return metrics;
}

void do_cloth_meshing(StageWork& work, const ClothSettings& settings) {
  work.input_description = "the seed paper's cloth";
  formats::write_surface(work.out / fs::path(kMesh).filename(),
                         {simulation::cloth_mesh(settings.get<&Config::cloth>()), {}, {}});
}

void do_cloth_simulation(StageWork& work, const ClothSettings& settings) {
  work.progress.report(0.0, "pulling the cloth");
  const simulation::Cloth cloth = simulation::pull_cloth(settings.get<&Config::cloth>());
  std::vector<formats::TimeStep> steps;
  ClothTable table;
  double thinnest = settings.get<&Config::cloth>().thickness_mm;
  long iterations = 0;
  for (std::size_t s = 0; s < cloth.states.size(); ++s) {
    const simulation::ClothState& state = cloth.states[s];
    const TriangleMesh shape{state.positions, cloth.rest.triangles};
    const DataArray thickness{"thickness", at_vertices(shape, state.thickness_mm), 1,
                              ArrayType::float32};
    formats::write_surface(work.out / cloth_file(s), {shape, {thickness}, {}});
    steps.push_back({double(s), 0, cloth_file(s)});
    table.add(s, state, shape);
    iterations += state.iterations;
    thinnest =
        std::min(thinnest, *std::min_element(state.thickness_mm.begin(), state.thickness_mm.end()));
    if (!state.converged)
      work.warnings.push_back(fmt::format("the cloth is not at rest at {:.3g} % (residual {:.1e})",
                                          100.0 * state.stretch, state.residual));
  }
  formats::write_collection(work.out / fs::path(file::kFrameList).filename(), steps);
  write_text_atomically(work.out / fs::path(kTable).filename(), table.csv);
  work.backend = "cpu";
  const json summary = {
      {"states", cloth.states.size()},
      {"stretch_percent", 100.0 * cloth.states.back().stretch},
      {"thickness_mm", settings.get<&Config::cloth>().thickness_mm},
      {"iterations", iterations},
      {"thinnest_mm", thinnest},
      {"thinnest_percent", 100.0 * thinnest / settings.get<&Config::cloth>().thickness_mm},
      {"triangles", cloth.rest.triangles.size()},
      {"vertices", cloth.rest.vertices.size()}};
  write_text_atomically(work.out / fs::path(file::kSummary).filename(), summary.dump(2) + "\n");
}

void do_cloth_report(StageWork& work, const ClothSettings&) {
  const StageFiles& files = work.files;
  const json summary = read_json(files.path(file::kSummary));
  viewer::ClothReport content;
  content.title = work.run.case_name;
  content.version = kVersion;
  const auto states = summary.at("states").get<std::size_t>();
  constexpr std::size_t kPictures = 4;  // as in the paper's Figure 5
  for (std::size_t p = 0; p < kPictures; ++p) {
    const std::size_t state = p * (states - 1) / (kPictures - 1);
    formats::SurfaceData shape =
        formats::read_surface(files.path("simulation/" + cloth_file(state)));
    const double stretch = summary.at("stretch_percent").get<double>() * double(state) /
                           std::max(1.0, double(states - 1));
    content.moments.push_back({state == 0 ? "at rest" : fmt::format("+{:.0f} %", stretch),
                               std::move(shape.mesh),
                               formats::find_array(shape.point_arrays, "thickness").values});
  }
  content.metrics_json = cloth_metrics(files, {}, work.run).dump();
  content.run_json = repeatable_run(work.run).dump();
  content.doubts = {{"the cloth", {}}};
  for (const auto& [stage, record] : work.run.stages)
    if (stage != Stage::report) keep(content.doubts.front().texts, record.warnings);
  viewer::write_cloth_report(work.out, content, work.progress);
}

std::vector<std::string> cloth_metrics_files() { return together(metrics_files(), {kTable}); }

}  // namespace

const Workflow& cloth_workflow() {
  static const Workflow kCloth{
      {without_work(Stage::reconstruction, name(InputKind::run)), without_work(Stage::segmentation),
       without_work(Stage::centerline),
       define_stage(Stage::meshing, {}, see_input, do_cloth_meshing),
       define_stage(Stage::simulation, {kMesh}, see_nothing, do_cloth_simulation),
       define_stage(Stage::report, together({file::kFrames}, cloth_metrics_files()), see_run,
                    do_cloth_report)},
      cloth_metrics_files(),
      cloth_metrics};
  return kCloth;
}

}  // namespace angio::pipeline
