#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/text.hpp"
#include "pipeline/config/config.hpp"

// The presets as data: a name, what it is for, and settings as on the command line.
namespace angio::pipeline {
namespace {

struct Preset {
  std::string name;
  std::string help;
  std::vector<std::string> bases;  ///< presets that come before its own settings
  std::vector<std::string> settings;
};

/// The seed paper's experiments share the balloon, the blood pressure, the gas, and the unfolded
/// start; each is deflated when it did so.
std::vector<std::string> paper_settings() {
  return {"balloon.material=polyurethane",
          "balloon.start_diameter_mm=0.9",
          "balloon.rest_diameter_mm=0.9",
          "balloon.ends=hemispheres",
          "balloon.folds=0",
          "balloon.membrane=plain",
          "balloon.wall_mm=0.03",
          "balloon.ring_count=26",
          "balloon.ring_vertex_count=20",
          "balloon.guidewire_node_count=24",
          "inflation.control=gas",
          "inflation.outside_pressure_kpa=10.0",
          "inflation.peak_pressure_atm=6.6",
          "wall.model=shape_matching",
          "wall.shape=quadratic",
          "wall.creep_per_s=2.0",
          "inflation.hold_s=0.0",
          "inflation.deflate_s=2.0",
          "inflation.rest_s=0.5",
          "volume.fill=false",
          "simulation.guard=false"};
}

const std::vector<Preset>& presets() {
  static const std::vector<Preset> kTable = {
      {"draft",
       "coarse and quick",
       {},
       {"mesh.edges_per_circumference=12", "simulation.frame_s=0.05", "simulation.write_every=8",
        "simulation.guard=false"}},
      {"fine",
       "finer vessel and balloon",
       {},
       {"mesh.edges_per_circumference=24", "balloon.ring_count=52",
        "balloon.ring_vertex_count=40"}},
      {"hydrophilic",
       "a balloon with a slippery coating",
       {},
       {"simulation.friction_static=0.05", "simulation.friction_kinetic=0.03"}},
      {"paper",
       "what the seed paper's vessel experiments share; for a vessel of your own",
       {},
       paper_settings()},
      {"paper-cloth", "section 6.1, Figure 5", {}, {"input.experiment=cloth"}},
      {"paper-unilateral",
       "experiment 1, Figures 6 and 7",
       {"paper"},
       {"input.experiment=unilateral", "mesh.keep=true", "inflation.inflate_s=4.5"}},
      {"paper-bilateral",
       "experiment 2, Figures 8 and 9",
       {"paper"},
       {"input.experiment=bilateral", "mesh.keep=true", "inflation.inflate_s=3.9"}},
      {"paper-ytype",
       "experiment 3, Figures 10 and 11",
       {"paper"},
       {"input.experiment=ytype", "mesh.keep=true", "inflation.inflate_s=3.95"}},
      {"paper-coronary",
       "experiment 4, Figures 1 and 12; INPUT: your lumen surface or scan",
       {"paper"},
       {"input.experiment=coronary", "mesh.triangle_count=30420", "lesion.narrow_percent=60.0",
        "flow.vessel=coronary", "inflation.inflate_s=2.65"}},
      {"paper-coronary-3dra",
       "experiment 4 from a 3D rotational angiography",
       {"paper"},
       {"mesh.triangle_count=30420", "lesion.narrow_percent=60.0", "inflation.inflate_s=2.65"}},
  };
  return kTable;
}

}  // namespace

std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  for (const Preset& preset : presets()) names.push_back(preset.name);
  return names;
}

std::string preset_help() {
  std::string text = "a set of options:";
  for (const Preset& preset : presets()) text += fmt::format("\n{}: {}", preset.name, preset.help);
  return text;
}

void apply_preset(Config& config, std::string_view name) {
  for (const Preset& preset : presets()) {
    if (preset.name != name) continue;
    for (const std::string& base : preset.bases) apply_preset(config, base);
    for (const std::string& setting : preset.settings) apply_setting(config, setting);
    return;
  }
  const std::string guess = guess_name(name, preset_names());
  throw OptionError(fmt::format("no preset is called {}{} (there are: {})", name,
                                guess.empty() ? "" : fmt::format(", did you mean {}?", guess),
                                fmt::join(preset_names(), ", ")));
}

}  // namespace angio::pipeline
