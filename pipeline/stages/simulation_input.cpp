#include "pipeline/stages/simulation_input.hpp"

#include "core/centerline.hpp"
#include "formats/case_file.hpp"
#include "pipeline/case/case_files.hpp"
#include "pipeline/config/shared_quantities.hpp"
#include "pipeline/stages/layered_wall.hpp"
#include "pipeline/stages/treated_lumen.hpp"

namespace angio::pipeline {
using nlohmann::json;
namespace {

Vec3 vec3_of(const json& node) {
  return {node.at(0).get<double>(), node.at(1).get<double>(), node.at(2).get<double>()};
}

/// Where the balloon's ends are watched: an eighth of its cylindrical part inside of them, clear of
/// the cones.
std::vector<simulation::WatchedPlace> balloon_ends(const StageFiles& files, const json& placement) {
  constexpr double kInside = 0.125;
  const TreatedSpans spans = treated_spans(placement);
  const double inside = kInside * (spans.cylinder_last - spans.cylinder_first);
  const CenterlineTree tree = read_centerlines(files.path(formats::case_file::kCenterlines));
  const CenterlinePath& path = path_of(tree, placement.at("lesion").at("centerline_id").get<int>());
  std::vector<simulation::WatchedPlace> ends;
  for (const double abscissa : {spans.cylinder_first + inside, spans.cylinder_last - inside}) {
    const CenterlineSample at = sample(path, abscissa);
    ends.push_back({at.point, at.tangent});
  }
  return ends;
}

}  // namespace

simulation::SimulationModel load_simulation_model(const StageFiles& files, const json& placement) {
  const json& lesion = placement.at("lesion");
  simulation::SimulationModel model = read_simulation_model(files);
  model.reference_radius_mm = 0.5 * lesion.at("reference_diameter_mm").get<double>();
  model.measure_point = vec3_of(placement.at("site").at("point"));
  model.measure_tangent = vec3_of(placement.at("site").at("tangent"));
  model.balloon_ends = balloon_ends(files, placement);
  model.layered_wall = read_layered_wall(files, model.wall);
  return model;
}

simulation::SimulationOptions load_simulation_options(const SimulationSettings& settings,
                                                      const json& placement) {
  const simulation::SimulationOptions& asked = settings.get<&Config::simulation>();
  return solver_options(asked, settings.get<&Config::plaque>(), settings.get<shaft_diameter>(),
                        placement.at("balloon").at("nominal_diameter_mm").get<double>(),
                        is_usual_balloon(asked.balloon, settings.get<rest_diameter>()));
}

}  // namespace angio::pipeline
