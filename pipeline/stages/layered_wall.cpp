#include "pipeline/stages/layered_wall.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "core/statistics.hpp"
#include "core/tet_mesh.hpp"
#include "formats/case_file.hpp"
#include "formats/checked_arrays.hpp"
#include "formats/files.hpp"
#include "simulation/pressed_wall.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
namespace {

template <class Value>
DataArray array_of(std::string array_name, const std::vector<Value>& values, ArrayType type) {
  DataArray array{std::move(array_name), {}, 1, type};
  array.values.reserve(values.size());
  for (const Value& value : values) array.values.push_back(double(value));
  return array;
}

DataArray array_of(std::string array_name, const std::vector<Vec3>& values, ArrayType type) {
  DataArray array{std::move(array_name), {}, 3, type};
  array.values.reserve(3 * values.size());
  for (const Vec3& v : values) array.values.insert(array.values.end(), {v.x, v.y, v.z});
  return array;
}

// A wedge's triangle furthest from the lumen; its normal leaves the wall.
std::vector<Triangle> outer_triangles(const std::vector<std::array<int, 6>>& wedges,
                                      const std::vector<int>& layer) {
  const int outermost = layer.empty() ? 0 : *std::max_element(layer.begin(), layer.end());
  std::vector<Triangle> triangles;
  for (std::size_t w = 0; w < wedges.size(); ++w)
    if (layer[w] == outermost) triangles.push_back({wedges[w][3], wedges[w][4], wedges[w][5]});
  return triangles;
}

// Whether the balloon presses a wedge's column at the peak.
bool is_touched(const simulation::Wedge& wedge, const simulation::SimulationFrame& peak) {
  const std::vector<double>& pressure = peak.contact_pressure_kpa;  // at the lumen's vertices
  return std::any_of(wedge.begin(), wedge.end(),
                     [&](int v) { return pressure[std::size_t(v) % pressure.size()] > 0.0; });
}

// Of the tissue that the wedge stands for.
double tissue_volume(const simulation::LayeredWall& wall, std::size_t wedge) {
  std::array<Vec3, 6> corners;
  for (std::size_t c = 0; c < 6; ++c)
    corners[c] = wall.vertices[std::size_t(wall.wedges[wedge][c])];
  const double ratio = wall.tissue_ratio.empty() ? 1.0 : wall.tissue_ratio[wedge];
  return ratio * cut_wedge_volume(corners);
}

struct Strength {
  double touched_mm3 = 0.0, over_mm3 = 0.0;

  [[nodiscard]] double over_percent() const {
    return touched_mm3 > 0.0 ? 100.0 * over_mm3 / touched_mm3 : 0.0;
  }
};

// Of the vessel's own layers where the balloon touches them at the peak, what has reached its
// strength: it has flowed by more than 0.2 %, the usual proof strain.
Strength strength_of(const simulation::LayeredWall& wall, const simulation::SimulationFrame& peak,
                     const std::vector<simulation::WallStress>& last) {
  constexpr double kProofStrain = 0.002;
  Strength strength;
  for (std::size_t w = 0; w < wall.wedges.size(); ++w) {
    const bool is_vessel = int(wall.region[w]) <= int(simulation::WallRegion::adventitia);
    if (!is_vessel || !is_touched(wall.wedges[w], peak)) continue;
    const double volume = tissue_volume(wall, w);
    strength.touched_mm3 += volume;
    if (last[w].plastic_strain > kProofStrain) strength.over_mm3 += volume;
  }
  return strength;
}

/// How much of each wedge counts: the share of its columns that the balloon touches, or presses.
using Shares = std::vector<double>;

Shares touched_shares(const simulation::LayeredWall& wall,
                      const simulation::SimulationFrame& peak) {
  Shares shares;
  for (const simulation::Wedge& wedge : wall.wedges)
    shares.push_back(is_touched(wedge, peak) ? 1.0 : 0.0);
  return shares;
}

Shares pressed_shares(const simulation::LayeredWall& wall,
                      const simulation::SimulationFrame& peak) {
  const std::vector<char> is_pressed =
      simulation::pressed_wall(wall.lumen_triangles, peak).is_pressed;
  Shares shares;
  for (const simulation::Wedge& wedge : wall.wedges) {
    int pressed = 0;
    for (int c = 0; c < 3; ++c)
      pressed += is_pressed[std::size_t(wedge[std::size_t(c)]) % is_pressed.size()] != 0 ? 1 : 0;
    shares.push_back(pressed / 3.0);
  }
  return shares;
}

// Quantiles by volume of what a region's wedges have at the peak, as NAME_principal_stress_Q_kpa
// and NAME_log_strain_Q.
nlohmann::json quantiles_of(const char* name, const Shares& shares,
                            const simulation::LayeredWall& wall, int region,
                            const std::vector<simulation::WallStress>& stresses) {
  std::vector<std::pair<double, double>> stress, strain;
  for (std::size_t w = 0; w < wall.wedges.size(); ++w) {
    if (int(wall.region[w]) != region || !(shares[w] > 0.0)) continue;
    const double volume = shares[w] * tissue_volume(wall, w);
    if (!(volume > 0.0)) continue;
    stress.emplace_back(stresses[w].principal_kpa, volume);
    strain.emplace_back(stresses[w].log_strain, volume);
  }
  const auto quantile_or_null = [](const auto& values, double share) {
    return values.empty() ? nlohmann::json() : nlohmann::json(weighted_quantile(values, share));
  };
  nlohmann::json told = nlohmann::json::object();
  for (const auto& [which, share] : {std::pair{"median", 0.5}, {"p95", 0.95}, {"p99", 0.99}}) {
    told[fmt::format("{}_principal_stress_{}_kpa", name, which)] = quantile_or_null(stress, share);
    told[fmt::format("{}_log_strain_{}", name, which)] = quantile_or_null(strain, share);
  }
  return told;
}

/// A wedge that no corner moves of keeps the stress that it was given.
bool is_held(const simulation::LayeredWall& wall, std::size_t wedge) {
  const simulation::Wedge& corners = wall.wedges[wedge];
  return std::all_of(corners.begin(), corners.end(),
                     [&](int v) { return wall.fixed[std::size_t(v)] != 0; });
}

}  // namespace

meshing::WallLayers layer_wall(const meshing::ContactRegion& region, const CenterlineTree& tree,
                               const centerline::Lesion& treated,
                               const centerline::LesionOptions& lesions,
                               const meshing::WallLayerOptions& options) {
  std::vector<meshing::NarrowStretch> stretches;
  const auto add = [&](const centerline::Lesion& lesion) {
    stretches.push_back(
        {lesion.path_id, lesion.proximal_mm, lesion.distal_mm, lesion.reference_diameter_mm});
  };
  add(treated);
  for (const centerline::Lesion& lesion : centerline::stenoses_beside(tree, treated, lesions))
    add(lesion);
  return meshing::build_wall_layers(region, tree, stretches, options);
}

void write_layered_wall(const fs::path& meshing_folder, const meshing::WallLayers& wall) {
  std::vector<int> region;
  for (const meshing::WallTissue tissue : wall.tissue) region.push_back(int(tissue));
  formats::write_wedges(meshing_folder / fs::path(formats::case_file::kLayeredWall).filename(),
                        {wall.vertices,
                         wall.wedges,
                         {array_of("Fixed", wall.fixed, ArrayType::uint8)},
                         {array_of("Layer", wall.layer, ArrayType::int32),
                          array_of("Region", region, ArrayType::int32),
                          array_of("Axial", wall.axial, ArrayType::float64),
                          {"TissueRatio", wall.tissue_ratio, 1, ArrayType::float64}}});
}

simulation::LayeredWall read_layered_wall(const StageFiles& files, const TriangleMesh& lumen) {
  const char* file = formats::case_file::kLayeredWall;
  simulation::LayeredWall wall;
  if (!files.exists(file)) return wall;
  const formats::WedgeData data = formats::read_wedges(files.path(file));
  wall.vertices = data.points;
  wall.wedges = data.wedges;
  const std::string name = fs::path(file).filename();
  const formats::CheckedArrays of_wedges(data.cell_arrays, data.wedges.size(), name);
  wall.layer = of_wedges.integers<int>("Layer", 0.0);
  for (const int region :
       of_wedges.integers<int>("Region", 0.0, double(simulation::kWallRegionCount) - 1.0))
    wall.region.push_back(simulation::WallRegion(region));
  wall.axial = of_wedges.vectors("Axial");
  static_assert(meshing::kMostTissueRatio == simulation::kMostTissueRatio);
  wall.tissue_ratio =
      of_wedges.numbers("TissueRatio", simulation::kLeastTissueRatio, simulation::kMostTissueRatio);
  wall.lumen_triangles = lumen.triangles;
  wall.outer_triangles = outer_triangles(wall.wedges, wall.layer);
  wall.fixed = formats::CheckedArrays(data.point_arrays, data.points.size(), name)
                   .integers<char>("Fixed", 0.0, 1.0);
  return wall;
}

void write_wall_frame(const fs::path& file, const simulation::LayeredWall& wall,
                      const simulation::SimulationFrame& frame) {
  using simulation::WallStress;
  formats::WedgeData data{frame.layered_wall, wall.wedges, {}, {}};
  const std::vector<WallStress> stresses = frame.wall_stress();
  std::vector<Vec3> displacement;
  for (std::size_t v = 0; v < frame.layered_wall.size(); ++v)
    displacement.push_back(frame.layered_wall[v] - wall.vertices[v]);
  data.point_arrays = {array_of("displacement", displacement, ArrayType::float32)};
  const auto add = [&](const char* array_name, double WallStress::*field) {
    DataArray array{array_name, {}, 1, ArrayType::float32};
    std::transform(stresses.begin(), stresses.end(), std::back_inserter(array.values),
                   [&](const WallStress& stress) { return stress.*field; });
    data.cell_arrays.push_back(std::move(array));
  };
  std::vector<int> region;
  for (const simulation::WallRegion r : wall.region) region.push_back(int(r));
  data.cell_arrays = {array_of("Region", region, ArrayType::int32)};
  add("principal_stress", &WallStress::principal_kpa);
  add("circumferential_stress", &WallStress::circumferential_kpa);
  add("axial_stress", &WallStress::axial_kpa);
  add("von_mises_stress", &WallStress::von_mises_kpa);
  add("log_strain", &WallStress::log_strain);
  add("plastic_strain", &WallStress::plastic_strain);
  add("volume_ratio", &WallStress::volume_ratio);
  formats::write_wedges(file, data);
}

nlohmann::json wall_summary(const simulation::LayeredWall& wall,
                            const simulation::SimulationFrame& peak,
                            const simulation::SimulationFrame& last) {
  const std::vector<simulation::WallStress> at_peak = peak.wall_stress(),
                                            at_last = last.wall_stress();
  const Shares touched = touched_shares(wall, peak), pressed = pressed_shares(wall, peak);
  nlohmann::json regions = nlohmann::json::object();
  for (int r = 0; r < simulation::kWallRegionCount; ++r) {
    std::vector<double> stress, plastic;
    for (std::size_t w = 0; w < wall.wedges.size(); ++w) {
      if (int(wall.region[w]) != r || is_held(wall, w)) continue;
      stress.push_back(at_peak[w].principal_kpa);
      plastic.push_back(at_last[w].plastic_strain);
    }
    if (stress.empty()) continue;
    nlohmann::json& region = regions[simulation::name(simulation::WallRegion(r))];
    region = {{"wedges", stress.size()},
              {"peak_principal_stress_median_kpa", quantile(stress, 0.5)},
              {"peak_principal_stress_p99_kpa", quantile(stress, 0.99)},
              {"plastic_strain_p99", quantile(plastic, 0.99)}};
    region.update(quantiles_of("touched", touched, wall, r, at_peak));
    region.update(quantiles_of("pressed", pressed, wall, r, at_peak));
  }
  const Strength strength = strength_of(wall, peak, at_last);
  return {{"model", "layered"},
          {"over_strength_percent", strength.over_percent()},
          {"over_strength_mm3", strength.over_mm3},
          {"regions", regions}};
}

double plaque_eccentricity(const simulation::SimulationModel& model, double abscissa_mm,
                           double reach_mm) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const simulation::LayeredWall& wall = model.layered_wall;
  int inner_layers = 0;  // of intima, plaque and media
  for (std::size_t w = 0; w < wall.wedges.size(); ++w)
    if (wall.region[w] != simulation::WallRegion::adventitia)
      inner_layers = std::max(inner_layers, wall.layer[w] + 1);
  const std::size_t count = model.wall.vertices.size();
  std::optional<std::size_t> nearest;
  const auto away = [&](std::size_t v) { return std::abs(model.wall_abscissa[v] - abscissa_mm); };
  for (std::size_t v = 0; v < count; ++v)
    if (!nearest || away(v) < away(*nearest)) nearest = v;
  if (!nearest || away(*nearest) > reach_mm || inner_layers == 0) return kNone;
  double thinnest = std::numeric_limits<double>::max(), thickest = 0.0;
  for (std::size_t v = 0; v < count; ++v) {
    if (away(v) > reach_mm || model.wall_group[v] != model.wall_group[*nearest]) continue;
    const double thickness =
        distance(wall.vertices[v], wall.vertices[v + count * std::size_t(inner_layers)]);
    thinnest = std::min(thinnest, thickness);
    thickest = std::max(thickest, thickness);
  }
  return thickest > 0.0 ? (thickest - thinnest) / thickest : kNone;
}

}  // namespace angio::pipeline
