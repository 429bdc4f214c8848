#include <cmath>
#include <string>

#include "core/error.hpp"
#include "meshing/lumen_volume.hpp"
#include "meshing/meshing.hpp"
#include "meshing/wall_layers.hpp"

namespace angio::meshing {
namespace {

void require(bool good, const std::string& key, const std::string& range) {
  if (!good) throw OptionError(key + " is out of range (allowed: " + range + ")");
}

}  // namespace

void LumenMeshOptions::validate() const {
  require(edge_length_mm >= 0.0 && edge_length_mm <= 5.0, "mesh.edge_length_mm", "0 to 5");
  require(edges_per_circumference >= 8.0 && edges_per_circumference <= 64.0,
          "mesh.edges_per_circumference", "8 to 64");
  require(triangle_budget >= 1000 && triangle_budget <= 5000000, "mesh.triangle_budget",
          "1000 to 5000000");
  require(triangle_count == 0 ||
              (triangle_count >= 1000 && triangle_count <= 1000000 && triangle_count % 2 == 0),
          "mesh.triangle_count", "0, or even from 1000 to 1000000");
  require(smoothing_iterations >= 0.0 && smoothing_iterations <= 100.0, "mesh.smoothing_iterations",
          "0 to 100");
  require(extension_diameters >= 0.0 && extension_diameters <= 20.0, "mesh.extension_diameters",
          "0 to 20");
}

void LumenVolumeOptions::validate() const {
  require(edge_ratio >= 0.5 && edge_ratio <= 5.0, "volume.edge_ratio", "0.5 to 5");
  require(tet_budget >= 1000 && tet_budget <= 50000000, "volume.tet_budget", "1000 to 50000000");
  require(least_dihedral_degrees >= 5.0 && least_dihedral_degrees <= 25.0,
          "volume.least_dihedral_degrees", "5 to 25");
}

void BalloonOptions::validate() const {
  const auto zero_or_within = [](double value, double low, double high) {
    return value == 0.0 || (value >= low && value <= high);
  };
  require(zero_or_within(nominal_diameter_mm, 0.5, 30.0), "balloon.nominal_diameter_mm",
          "0.5 to 30, or 0 for the reference diameter");
  require(zero_or_within(rest_diameter_mm, 0.5, 30.0), "balloon.rest_diameter_mm",
          "0 or 0.5 to 30");
  require(zero_or_within(length_mm, 2.0, 80.0), "balloon.length_mm",
          "2 to 80, or 0 for the lesion's");
  require(zero_or_within(start_diameter_mm, 0.3, 30.0), "balloon.start_diameter_mm",
          "0.3 to 30, or 0 for the usual crossing profile");
  require(ring_count >= 6 && ring_count <= 400, "balloon.ring_count", "6 to 400");
  require(ring_vertex_count >= 6 && ring_vertex_count <= 200, "balloon.ring_vertex_count",
          "6 to 200");
  require(guidewire_node_count >= 2 && guidewire_node_count <= 1000, "balloon.guidewire_node_count",
          "2 to 1000");
  require(folds == 0 || folds == 2 || folds == 3 || folds == 5, "balloon.folds", "0, 2, 3 or 5");
  require(shaft_diameter_mm >= 0.2 && shaft_diameter_mm <= 10.0, "balloon.shaft_diameter_mm",
          "0.2 to 10");
  require(fold_gap_mm >= 0.005 && fold_gap_mm <= 0.5, "balloon.fold_gap_mm", "0.005 to 0.5");
}

void WallLayerOptions::validate() const {
  require(thickness_ratio >= 0.02 && thickness_ratio <= 0.4, "wall.thickness_ratio", "0.02 to 0.4");
  for (const double fraction : layer_fractions)
    require(fraction > 0.0 && fraction <= 1e3, "wall.layer_fractions", "above 0, up to 1000");
  require(elements_per_layer >= 1 && elements_per_layer <= 8, "wall.elements_per_layer", "1 to 8");
  require(plaque_elements >= 2 && plaque_elements <= 16, "wall.plaque_elements", "2 to 16");
}

}  // namespace angio::meshing
