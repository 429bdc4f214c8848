
#include "core/require.hpp"
#include "meshing/lumen_volume.hpp"
#include "meshing/meshing.hpp"
#include "meshing/wall_layers.hpp"

namespace angio::meshing {

void LumenMeshOptions::validate() const {
  require_within("mesh.edge_length_mm", edge_length_mm, 0.0, 5.0);
  require_within("mesh.edges_per_circumference", edges_per_circumference, 8.0, 64.0);
  require_within("mesh.triangle_budget", triangle_budget, 1000, 5000000);
  require(triangle_count == 0 ||
              (triangle_count >= 1000 && triangle_count <= 1000000 && triangle_count % 2 == 0),
          "mesh.triangle_count", "0, or even from 1000 to 1000000");
  require_within("mesh.smoothing_iterations", smoothing_iterations, 0.0, 100.0);
  require_within("mesh.extension_diameters", extension_diameters, 0.0, 20.0);
}

void LumenVolumeOptions::validate() const {
  require_within("volume.edge_ratio", edge_ratio, 0.5, 5.0);
  require_within("volume.tet_budget", tet_budget, 1000, 50000000);
  require_within("volume.least_dihedral_degrees", least_dihedral_degrees, 5.0, 25.0);
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
  require_within("balloon.ring_count", ring_count, 6, 400);
  require_within("balloon.ring_vertex_count", ring_vertex_count, 6, 200);
  require_within("balloon.guidewire_node_count", guidewire_node_count, 2, 1000);
  require(folds == 0 || folds == 2 || folds == 3 || folds == 5, "balloon.folds", "0, 2, 3 or 5");
  require_within("balloon.shaft_diameter_mm", shaft_diameter_mm, 0.2, 10.0);
  require_within("balloon.fold_gap_mm", fold_gap_mm, 0.005, 0.5);
}

void WallLayerOptions::validate() const {
  require_within("wall.thickness_ratio", thickness_ratio, 0.02, 0.4);
  for (const double fraction : layer_fractions)
    require(fraction > 0.0 && fraction <= 1e3, "wall.layer_fractions", "above 0, up to 1000");
  require_within("wall.elements_per_layer", elements_per_layer, 1, 8);
  require_within("wall.plaque_elements", plaque_elements, 2, 16);
}

}  // namespace angio::meshing
