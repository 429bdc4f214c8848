#include "pipeline/case/flow.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/atomic_file.hpp"
#include "core/centerline_trees.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "formats/case_file.hpp"
#include "formats/csv.hpp"
#include "formats/tokens.hpp"
#include "pipeline/case/case_files.hpp"
#include "pipeline/case/case_status.hpp"
#include "pipeline/case/metrics.hpp"
#include "pipeline/case/resolution.hpp"
#include "segmentation/read_volume.hpp"

namespace angio::pipeline {
namespace file = formats::case_file;
using centerline::Estimate;
using centerline::FlowResult;
using centerline::FlowSolution;
using centerline::FlowTree;
using centerline::LumenProfile;
using nlohmann::json;
namespace {

constexpr double kWidestCoronary = 6.0;  // [mm]
constexpr double kBehindInDiameters = 2.0;

/// What the numbers of metrics.json are of.
struct Site {
  std::size_t path = 0;
  double before_mm = 0.0, behind_mm = 0.0;  ///< abscissas: the lesion's proximal edge, behind it
};

/// lumen_profile.csv at one moment, without the places whose cells are empty.
LumenProfile read_lumen(const StageFiles& files, const std::string& when) {
  const formats::CsvTable table = formats::read_csv_table(files.path(file::kProfile));
  const std::vector<double> abscissa = table.numbers("abscissa_mm"),
                            inscribed = table.numbers("inscribed_diameter_" + when + "_mm"),
                            equivalent = table.numbers("equivalent_diameter_" + when + "_mm");
  LumenProfile profile;
  for (std::size_t i = 0; i < abscissa.size(); ++i) {
    const double radius = 0.5 * equivalent[i];
    if (std::isnan(radius)) continue;
    profile.abscissa.push_back(abscissa[i]);
    profile.inscribed_radius.push_back(0.5 * inscribed[i]);
    profile.section_area.push_back(units::kPi * radius * radius);
  }
  return profile;
}

/// The case's vessels as the image has them, and by how much their diameters may be wrong [mm].
struct Vessels {
  CenterlineTree lines;
  FlowTree tree;
  Site site;
  double error = 0.0;

  [[nodiscard]] const CenterlinePath& line() const { return lines.paths[site.path]; }
};

Vessels read_vessels(const StageFiles& files, const json& lesion) {
  Vessels vessels;
  const CenterlineTree all = read_centerlines(files.path(file::kCenterlines));
  const int id = path_of(all, lesion.at("centerline_id").get<int>()).id;
  vessels.lines = tree_with_path(all, id);
  const centerline::Resolution resolution = case_resolution(files);
  const double voxel = centerline::lesion_options({}, resolution).voxel_mm;
  vessels.error = voxel > 0.0 ? voxel / std::sqrt(12.0) : centerline::FlowOptions::kSurfaceError;
  vessels.tree = centerline::make_flow_tree(vessels.lines, voxel);
  const CenterlinePath& line = path_of(vessels.lines, id);
  vessels.site.path = std::size_t(&line - vessels.lines.paths.data());
  vessels.site.before_mm = lesion.at("proximal_mm").get<double>();
  const double reference = lesion.at("reference_diameter_mm").get<double>();
  vessels.site.behind_mm = std::min(
      lesion.at("distal_mm").get<double>() + kBehindInDiameters * reference, line.abscissa.back());
  return vessels;
}

/// Linear between the points of a line.
double pressure_at(const FlowSolution& solution, const FlowTree& tree, const CenterlinePath& line,
                   std::size_t path, double abscissa) {
  const auto pressure = [&](std::size_t i) {
    const centerline::FlowPlace place = tree.paths[path][i];
    return solution.pressure_mmhg[place.branch][place.point];
  };
  const auto above = std::lower_bound(line.abscissa.begin(), line.abscissa.end(), abscissa);
  if (above == line.abscissa.begin()) return pressure(0);
  if (above == line.abscissa.end()) return pressure(line.abscissa.size() - 1);
  const auto i = std::size_t(above - line.abscissa.begin());
  const double t = (abscissa - line.abscissa[i - 1]) / (line.abscissa[i] - line.abscissa[i - 1]);
  return (1.0 - t) * pressure(i - 1) + t * pressure(i);
}

double least_pressure(const FlowSolution& solution) {
  double least = solution.pressure_mmhg.front().front();
  for (const auto& branch : solution.pressure_mmhg) least = std::min(least, branch.back());
  return least;
}

void put(json& metrics, const std::string& name, const std::string& unit, const Estimate& number) {
  metrics[name + unit] = number.value;
  metrics[name + "_range" + unit] = {number.low, number.high};
}

/// @param when  "before" or "after"
void add_numbers(json& metrics, const std::string& when, const FlowResult& result,
                 const FlowTree& tree, const Vessels& vessels, double aortic) {
  const CenterlinePath& line = vessels.line();
  const Site& site = vessels.site;
  const auto at = [&](const FlowSolution& s, double abscissa) {
    return pressure_at(s, tree, line, site.path, abscissa);
  };
  const auto behind =
      std::upper_bound(line.abscissa.begin(), line.abscissa.end(), site.behind_mm) - 1;
  const std::size_t branch =
      tree.paths[site.path][std::size_t(behind - line.abscissa.begin())].branch;
  put(metrics, "ffr_" + when, "",
      estimate(result, [&](const FlowSolution& s) { return at(s, site.behind_mm) / aortic; }));
  put(metrics, "least_ffr_" + when, "",
      estimate(result, [&](const FlowSolution& s) { return least_pressure(s) / aortic; }));
  put(metrics, "pressure_drop_" + when, "_mmhg", estimate(result, [&](const FlowSolution& s) {
        return at(s, site.before_mm) - at(s, site.behind_mm);
      }));
  put(metrics, "flow_" + when, "_ml_min",
      estimate(result, [&](const FlowSolution& s) { return s.flow_ml_min[branch]; }));
}

PullBack pull_back(const FlowResult& result, const FlowTree& tree, std::size_t path,
                   double aortic) {
  PullBack pull;
  for (const centerline::FlowPlace& place : tree.paths[path]) {
    const double radius = tree.branches[place.branch].radius[place.point];
    pull.diameter_mm.push_back(radius > 0.0 ? 2.0 * radius : std::nan(""));
    pull.pressure_mmhg.push_back(result.best.pressure_mmhg[place.branch][place.point]);
    pull.ffr.push_back(estimate(result, [&](const FlowSolution& s) {
      return s.pressure_mmhg[place.branch][place.point] / aortic;
    }));
  }
  return pull;
}

bool is_coronary(FlowVessel vessel, const RunRecord& record) {
  if (vessel != FlowVessel::automatic) return vessel == FlowVessel::coronary;
  return record.input_kind == "phantom" ||
         record.input_description.find(segmentation::kOfTheHeart) != std::string::npos;
}

CaseFlow untold(const std::string& reason) { return {no_flow(reason), {}, {}, std::nullopt}; }

std::string csv_cells(const PullBack& pull, std::size_t i) {
  const std::string diameter =
      std::isfinite(pull.diameter_mm[i]) ? fmt::format("{:.4f}", pull.diameter_mm[i]) : "";
  return fmt::format(",{},{:.3f},{:.4f},{:.4f},{:.4f}", diameter, pull.pressure_mmhg[i],
                     pull.ffr[i].value, pull.ffr[i].low, pull.ffr[i].high);
}

}  // namespace

std::vector<std::string> flow_files() {
  std::vector<std::string> files = resolution_files();
  files.insert(files.end(), {file::kCenterlines, file::kPlacement, file::kProfile});
  return files;
}

json no_flow(const std::string& reason) {
  json metrics = json::object();
  metrics["reason"] = reason.empty() ? json(nullptr) : json(reason);
  for (const char* key : {"vessel", "model", "aortic_pressure_mmhg", "inlet_flow_ml_min",
                          "inlet_diameter_mm", "behind_mm"})
    metrics[key] = nullptr;
  for (const std::string when : {"before", "after"})
    for (const auto& [name, unit] :
         {std::pair{"ffr_", ""}, std::pair{"least_ffr_", ""}, std::pair{"pressure_drop_", "_mmhg"},
          std::pair{"flow_", "_ml_min"}}) {
      metrics[name + when + unit] = nullptr;
      metrics[name + when + "_range" + unit] = nullptr;
    }
  return metrics;
}

CaseFlow case_flow(const StageFiles& files, const centerline::FlowOptions& options,
                   FlowVessel vessel, const RunRecord& record) {
  if (!record.is(Stage::centerline, "done") || !record.is(Stage::meshing, "done"))
    return untold("");
  const json placement = read_json(files.path(file::kPlacement));
  if (placement.value("status", "done") == "no_lesion") return untold("no stenosis is certain");
  const Vessels vessels = read_vessels(files, placement.at("lesion"));
  const bool is_simulated = record.is(Stage::simulation, "done") && placement.contains("balloon");
  CaseFlow flow = untold(is_simulated ? "" : "nothing was simulated: there is only before");
  const double aortic = options.aortic_pressure_mmhg;
  const auto pull = [&](const char* when) {
    FlowTree tree = vessels.tree;
    if (is_simulated)
      tree =
          with_lumen(std::move(tree), vessels.line(), vessels.site.path, read_lumen(files, when));
    const FlowResult result = solve_flow(tree, options, vessels.error);
    add_numbers(flow.metrics, when, result, tree, vessels, aortic);
    flow.metrics["inlet_flow_ml_min"] = result.inlet_flow_ml_min;
    return pull_back(result, tree, vessels.site.path, aortic);
  };
  const double inlet = 2.0 * vessels.tree.branches.front().healthy.front();
  if (inlet > kWidestCoronary)
    return untold(
        fmt::format("the inlet is {:.1f} mm wide where it is healthy; fractional flow "
                    "reserve is of coronary arteries, here up to {:.0f} mm",
                    inlet, kWidestCoronary));
  flow.metrics["vessel"] = is_coronary(vessel, record) ? "coronary" : "other";
  flow.metrics["model"] = "young-tsai";
  flow.metrics["aortic_pressure_mmhg"] = aortic;
  flow.metrics["inlet_diameter_mm"] = inlet;
  flow.metrics["behind_mm"] = vessels.site.behind_mm;
  flow.abscissa_mm = vessels.line().abscissa;
  flow.before = pull("before");
  if (is_simulated) flow.after = pull("after");
  return flow;
}

std::string flow_csv(const CaseFlow& flow) {
  std::string text = "abscissa_mm";
  const auto add_columns = [&](const char* when) {
    text +=
        fmt::format(",diameter_{0}_mm,pressure_{0}_mmhg,ffr_{0},ffr_{0}_low,ffr_{0}_high", when);
  };
  add_columns("before");
  if (flow.after) add_columns("after");
  text += "\n";
  for (std::size_t i = 0; i < flow.abscissa_mm.size(); ++i)
    text += fmt::format("{:.4f}{}{}\n", flow.abscissa_mm[i], csv_cells(flow.before, i),
                        flow.after ? csv_cells(*flow.after, i) : "");
  return text;
}

}  // namespace angio::pipeline
