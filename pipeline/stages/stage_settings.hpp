#pragma once

#include "pipeline/config/config_view.hpp"

/// What each stage sees of the configuration. To let a stage see more, name the part here.
namespace angio::pipeline {

inline const double& wall_thickness_ratio(const Config& config) {
  return config.simulation.wall.thickness_ratio;
}
inline const double& shaft_diameter(const Config& config) {
  return config.balloon.shaft_diameter_mm;
}
inline const double& rest_diameter(const Config& config) { return config.balloon.rest_diameter_mm; }
inline const simulation::BalloonMaterial& membrane(const Config& config) {
  return config.simulation.balloon;
}
inline const int& fold_count(const Config& config) { return config.balloon.folds; }
inline const bool& keeps_triangles(const Config& config) { return config.lumen_mesh.keep; }

/// How INPUT is read.
using InputSettings = ConfigView<&Config::experiment, &Config::input, &Config::surface_unit>;

using ReconstructionSettings =
    ConfigView<&Config::experiment, &Config::input, &Config::reconstruction, &Config::views,
               &Config::view_frames, &Config::view_ends>;

using SegmentationSettings =
    ConfigView<&Config::experiment, &Config::input, &Config::surface_unit, &Config::segmentation>;

using CenterlineSettings =
    ConfigView<&Config::centerline, &Config::inlet_end, &Config::lesion, &Config::narrowing>;

using MeshingSettings =
    ConfigView<&Config::lesion, &Config::lumen_mesh, &Config::fill_lumen, &Config::lumen_volume,
               &Config::balloon, membrane, &Config::wall_model, &Config::wall_layers,
               &Config::calcium_from_scan, wall_thickness_ratio>;

using SimulationSettings =
    ConfigView<&Config::simulation, &Config::plaque, &Config::guard, &Config::write_every,
               shaft_diameter, rest_diameter, fold_count, keeps_triangles>;

using ReportSettings =
    ConfigView<&Config::lesion, &Config::flow_vessel, &Config::flow, &Config::view>;

}  // namespace angio::pipeline
