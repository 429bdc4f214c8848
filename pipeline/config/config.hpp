#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "angiogram/working_view.hpp"
#include "centerline/centerline.hpp"
#include "centerline/flow/flow.hpp"
#include "core/units.hpp"
#include "meshing/lumen_volume.hpp"
#include "meshing/meshing.hpp"
#include "meshing/narrow_lumen.hpp"
#include "meshing/wall_layers.hpp"
#include "reconstruction/reconstruction.hpp"
#include "reconstruction/views.hpp"
#include "segmentation/read_volume.hpp"
#include "segmentation/segmentation.hpp"
#include "simulation/balloon_size.hpp"
#include "simulation/cloth.hpp"
#include "simulation/simulation.hpp"

namespace angio::pipeline {

/// Of --backend: "cpu", "cuda", else automatic.
Backend backend_of(std::string_view name);

/// Every option of every stage; each default is the one of the stage's own struct, or by the
/// balloon's size.
/// What the treated vessel is: the ratio of pressures is called fractional flow reserve in a
/// coronary artery only.
enum class FlowVessel {
  automatic,  ///< coronary where the input says that it is of the heart
  coronary,
  other,
};

struct Config {
  /// The seed paper's: "cloth", "unilateral", "bilateral", "ytype", "coronary"; "": none.
  std::string experiment;
  segmentation::ReadOptions input;
  std::optional<LengthUnit> surface_unit;  ///< of a surface or volume file; unset: as it says
  reconstruction::ReconstructionOptions reconstruction;
  reconstruction::ViewsOptions views;
  std::vector<double> view_ends;    ///< of the wanted vessel: four numbers a view
  std::vector<double> view_frames;  ///< which frame of each view, from 1; empty: the best filled
  segmentation::SegmentationOptions segmentation;
  centerline::CenterlineOptions centerline;
  int inlet_end = 0;  ///< number of the open end of a given surface that is the inlet; 0: none
  centerline::LesionOptions lesion;
  meshing::NarrowingOptions narrowing;
  meshing::LumenMeshOptions lumen_mesh;
  bool fill_lumen = true;  ///< also make the tetrahedral lumen mesh
  meshing::LumenVolumeOptions lumen_volume;
  meshing::BalloonOptions balloon;
  simulation::WallModel wall_model = simulation::WallModel::layered;
  meshing::WallLayerOptions wall_layers;  ///< of the layered wall
  simulation::Plaque plaque = simulation::Plaque::fibrous;
  bool calcium_from_scan = true;
  simulation::SimulationOptions simulation = simulation::options_by_size();
  FlowVessel flow_vessel = FlowVessel::automatic;
  centerline::FlowOptions flow;
  angiogram::WorkingViewOptions view;
  simulation::ClothOptions cloth;
  /// Simulate a second time from a start that is moved a little, to see whether the result is
  /// determined (simulation/guard.hpp).
  bool guard = true;
  int write_every = 4;  ///< solver frames per frame written, [1, 10000]

  void validate() const;  ///< @throws OptionError naming section.key
};

/// One key of the configuration and the field behind it.
struct Setting {
  std::string key;                                         ///< "section.key"
  const void* field;                                       ///< where it lies in the Config
  std::string help;                                        ///< meaning, unit, range
  std::function<std::string()> get;                        ///< as a TOML value
  std::function<void(const std::string& toml_value)> set;  ///< @throws OptionError
};

/// The table of all settings of `config`, which must outlive it.
std::vector<Setting> settings(Config& config);

/// Applies a TOML file. @throws OptionError (78) for an unknown key, naming the nearest one
void load_config(Config& config, const std::filesystem::path& file);

/// Applies "section.key=value".
void apply_setting(Config& config, std::string_view assignment);

/// Names of the presets; what each is for, a line each; and the settings of one.
std::vector<std::string> preset_names();
std::string preset_help();
/// @throws OptionError (78) naming the presets that there are
void apply_preset(Config& config, std::string_view name);

/// The configuration as TOML, each key with its meaning and unit as a comment.
std::string to_toml(const Config& config);

}  // namespace angio::pipeline
