#include "pipeline/stages/meshing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "centerline/centerline.hpp"
#include "centerline/treated.hpp"
#include "core/atomic_file.hpp"
#include "core/beside.hpp"
#include "core/centerline_trees.hpp"
#include "core/error.hpp"
#include "formats/case_file.hpp"
#include "formats/files.hpp"
#include "meshing/calcium.hpp"
#include "meshing/lumen_volume.hpp"
#include "meshing/meshing.hpp"
#include "pipeline/case/case_files.hpp"
#include "pipeline/case/doubts.hpp"
#include "pipeline/case/metrics.hpp"
#include "pipeline/case/resolution.hpp"
#include "pipeline/config/shared_quantities.hpp"
#include "pipeline/stages/layered_wall.hpp"
#include "segmentation/read_volume.hpp"
#include "segmentation/segmentation.hpp"

// From the lumen and its lesions to the meshes.
namespace angio::pipeline {
namespace file = formats::case_file;
using nlohmann::json;
namespace {

json to_json(const Vec3& v) { return json::array({v.x, v.y, v.z}); }

struct Placement {
  centerline::Lesion lesion;
  std::optional<meshing::BalloonSetup> setup;  ///< none: nothing is treated
  std::string status = "done", reason;         ///< CaseStatus's, if the simulation ends right
};

/// What the simulation and the metrics must know of the placement beyond the meshes.
json placement_json(const centerline::Resolution& resolution, const CenterlinePath& path,
                    const meshing::LumenMesh& lumen,
                    const std::optional<meshing::LumenVolume>& volume, const Placement& placement) {
  const centerline::Lesion& lesion = placement.lesion;
  json result = {{"lesion", lesion_metrics(lesion, path, resolution)},
                 {"mesh", mesh_metrics(lumen, volume)},
                 {"status", placement.status},
                 {"status_reason", placement.reason}};
  if (!placement.setup) return result;
  const meshing::Balloon& balloon = placement.setup->balloon;
  const CenterlineSample at = sample(path, lesion.abscissa_mm);
  result["site"] = {{"point", to_json(at.point)},
                    {"tangent", to_json(at.tangent)},
                    {"balloon_first_abscissa_mm", project(path, balloon.guidewire.front())},
                    {"balloon_last_abscissa_mm", project(path, balloon.guidewire.back())}};
  result["balloon"] = {{"nominal_diameter_mm", balloon.nominal_diameter_mm},
                       {"length_mm", balloon.length_mm}};
  result["balloon_start_diameter_mm"] = balloon.start_diameter_mm;
  return result;
}

/// The tetrahedral lumen mesh, which is for other programs: without it, the run goes on.
struct FilledLumen {
  std::optional<meshing::LumenVolume> volume;
  std::vector<std::string> warnings;
};

FilledLumen fill_lumen(const meshing::LumenVolumeOptions& options,
                       const meshing::LumenMesh& lumen) {
  try {
    meshing::LumenVolume volume = meshing::mesh_lumen_volume(lumen, options);
    std::vector<std::string> warnings = volume.warnings;
    return {std::move(volume), std::move(warnings)};
  } catch (const InputError& error) {
    return {std::nullopt, {fmt::format("there is no lumen.vtu: {}", error.what())}};
  }
}

/// Why a vessel is not treated unless somebody asks for it; empty: it is.
std::string reason_to_leave(const centerline::Lesion& lesion) {
  constexpr double kLargestBalloon = 30.0;  // [mm] that is sold
  const double diameter = lesion.reference_diameter_mm;
  if (!lesion.is_stenosis && lesion.mld_mm > centerline::kWidestTried * diameter)
    return fmt::format(
        "the lumen there, of {:.1f} mm, is wider than the healthy vessel, of {:.1f} mm",
        lesion.mld_mm, diameter);
  if (diameter < centerline::kLeastTreated)
    return fmt::format("the vessel there, of {:.2f} mm, is narrower than {} mm", diameter,
                       centerline::kLeastTreated);
  if (diameter > kLargestBalloon)
    return fmt::format("there is no balloon for a vessel of {:.1f} mm", diameter);
  return {};
}

/// Why a balloon that fits at a healthy place is not tried there; empty: it is.
std::string reason_not_to_try(const meshing::Balloon& balloon) {
  const double shortest = meshing::shortest_balloon_length_mm(balloon.nominal_diameter_mm);
  if (balloon.length_mm >= shortest) return {};
  return fmt::format(
      "there is room for {:.1f} mm of balloon, and one of {:.2f} mm width is made no shorter than "
      "{:.1f} mm",
      balloon.length_mm, balloon.nominal_diameter_mm, shortest);
}

std::string place_of(const centerline::Lesion& lesion) {
  return fmt::format("line {}, {:.1f} mm from the inlet", lesion.path_id, lesion.abscissa_mm);
}

std::string none_was_found(const std::vector<centerline::Lesion>& lesions, double least) {
  const auto doubtful = std::count_if(lesions.begin(), lesions.end(), [](const auto& lesion) {
    return lesion.is_doubtful() && !lesion.is_too_small;
  });
  const auto thin = std::count_if(lesions.begin(), lesions.end(), [](const auto& lesion) {
    return lesion.is_too_thin && !lesion.is_too_small;
  });
  if (doubtful > 0)
    return fmt::format("no stenosis of {:.0f} % or more is certain ({} narrowing{} in doubt)",
                       least, doubtful, doubtful == 1 ? " is" : "s are");
  if (thin > 0)
    return fmt::format(
        "no stenosis of {:.0f} % or more can be measured ({} narrowing{} in vessels that the data "
        "are too coarse for)",
        least, thin, thin == 1 ? " is" : "s are");
  if (const double there = lesions.front().diameter_stenosis_percent; there >= least)
    return fmt::format(
        "no stenosis of {:.0f} % or more is certain (a vessel that is {:.0f} % narrower than its "
        "reference may be as thin by itself)",
        least, there);
  const auto small = std::count_if(lesions.begin(), lesions.end(),
                                   [](const auto& lesion) { return lesion.is_too_small; });
  return fmt::format("no stenosis of {:.0f} % or more was found{}", least,
                     small > 0 ? " in a vessel that balloons are made for" : "");
}

/// Nothing is treated: of the worst lesion it is told why.
Placement no_placement(const std::vector<centerline::Lesion>& lesions, const std::string& reason,
                       double least) {
  const centerline::Lesion& worst = lesions.front();
  if (worst.is_stenosis)
    return {worst, std::nullopt, "not_determined",
            fmt::format("the stenosis of {:.0f} % on {} is not treated: {}",
                        worst.diameter_stenosis_percent, place_of(worst), reason)};
  return {worst, std::nullopt, "no_lesion",
          fmt::format("{}, and no balloon is tried ({}): {}", none_was_found(lesions, least),
                      place_of(worst), reason)};
}

/// The vessel that a balloon is chosen for. At a healthy place the tree's reference opens nothing:
/// there it is the vessel right beside, where that is thinner.
double vessel_to_open_mm(const centerline::Lesion& lesion) {
  const double beside = lesion.beside_throat_mm;
  return !lesion.is_stenosis && beside > 0.0 ? std::min(beside, lesion.reference_diameter_mm)
                                             : lesion.reference_diameter_mm;
}

/// The lesions' stretches with the diameter of the balloon that would be brought there.
std::vector<meshing::WidenedStretch> stretches_to_widen(
    const std::vector<centerline::Lesion>& lesions, double nominal_diameter_mm) {
  std::vector<meshing::WidenedStretch> stretches;
  for (const centerline::Lesion& lesion : lesions)
    if (!lesion.is_left_out())
      stretches.push_back({lesion.path_id, lesion.proximal_mm, lesion.distal_mm,
                           nominal_diameter_mm > 0.0
                               ? nominal_diameter_mm
                               : meshing::usual_balloon_diameter_mm(vessel_to_open_mm(lesion))});
  return stretches;
}

/// The balloon across the place that the user named, otherwise across the most severe lesion that
/// one can be brought to.
Placement place_on_a_lesion(StageWork& work, const MeshingSettings& settings,
                            const CenterlineTree& tree, const meshing::LumenMesh& lumen,
                            const std::vector<centerline::Lesion>& lesions) {
  const centerline::LesionOptions& asked = settings.get<&Config::lesion>();
  const meshing::BalloonOptions& balloon = settings.get<&Config::balloon>();
  const bool is_place_given = asked.abscissa_mm >= 0.0,
             is_balloon_given = balloon.nominal_diameter_mm > 0.0;
  const bool is_usual = is_usual_balloon(settings.get<membrane>(), balloon.rest_diameter_mm);
  std::string first_reason;
  for (const centerline::Lesion& lesion : lesions) {
    if (lesion.is_left_out()) continue;
    std::string reason = is_place_given || is_balloon_given ? "" : reason_to_leave(lesion);
    try {
      if (reason.empty()) {
        const CenterlineTree treated = tree_with_path(tree, lesion.path_id);
        meshing::BalloonSetup setup = meshing::place_balloon(
            lumen, treated, path_of(treated, lesion.path_id), lesion.abscissa_mm, lesion.length_mm,
            lesion.reference_diameter_mm,
            balloon_options(balloon, is_usual, vessel_to_open_mm(lesion)),
            part(work.progress, 0.5, 0.9));
        const bool is_asked_for = is_place_given || is_balloon_given || balloon.length_mm > 0.0;
        if (!lesion.is_stenosis && !is_asked_for) reason = reason_not_to_try(setup.balloon);
        if (reason.empty()) return {lesion, std::move(setup), "done", ""};
      }
    } catch (const InputError& error) {
      if (is_place_given) throw;
      reason = error.what();
    }
    if (lesion.is_stenosis)  // of the trial place of a healthy tree no_placement tells
      work.warnings.push_back(fmt::format("the stenosis of {:.0f} % on {} is passed over: {}",
                                          lesion.diameter_stenosis_percent, place_of(lesion),
                                          reason));
    if (first_reason.empty()) first_reason = reason;
  }
  return no_placement(lesions, first_reason, asked.min_stenosis_percent);
}

/// What is to be told of a balloon that was placed.
void tell_of_balloon(StageWork& work, const centerline::LesionOptions& asked,
                     const std::vector<centerline::Lesion>& lesions, const CenterlinePath& path,
                     const centerline::Resolution& resolution, Placement& placement) {
  const centerline::Lesion& lesion = placement.lesion;
  keep(work.warnings, placement.setup->warnings);
  constexpr double kMuchTooLarge = 1.5;
  const double nominal = placement.setup->balloon.nominal_diameter_mm,
               to_artery = nominal / lesion.reference_diameter_mm;
  if (to_artery > kMuchTooLarge)
    work.warnings.push_back(fmt::format(
        "the balloon's nominal diameter, {:.2f} mm, is {:.1f} times the vessel's at the lesion",
        nominal, to_artery));
  if (centerline::is_unmeasured(lesion, path, resolution))
    work.warnings.push_back(fmt::format(
        "{} {} ({:.2f} mm): its diameter is not measured, and the stenosis is at least {:.0f} %",
        kUnmeasuredThroat,
        has_surface_input(work.files) ? "the voxels that the surface was made from" : "a voxel",
        resolution.longest_mm,
        least_stenosis(lesion.mld_mm, resolution.longest_mm, lesion.reference_diameter_mm)));
  if (lesion.is_stenosis || asked.abscissa_mm >= 0.0) return;
  placement.status = "no_lesion";
  placement.reason = fmt::format(
      "{}; a balloon is tried in the longest vessel, where it is narrow and has room ({}). You can "
      "name another place (--set lesion.centerline=N lesion.abscissa_mm=S)",
      none_was_found(lesions, asked.min_stenosis_percent), place_of(lesion));
  work.warnings.push_back(placement.reason);
}

/// Docs tell what a finer mesh changes of the default's numbers, not of a coarser one's.
void tell_of_coarseness(StageWork& work, const meshing::LumenMeshOptions& options) {
  const double usual = meshing::LumenMeshOptions{}.edges_per_circumference;
  if (options.edge_length_mm == 0.0 && options.edges_per_circumference < usual)
    work.warnings.push_back(fmt::format(
        "the mesh is coarse, {:g} edges around the vessel where the default is {:g} (the preset "
        "draft, or mesh.edges_per_circumference): take its numbers for a first look",
        options.edges_per_circumference, usual));
}

/// Plaque that is brighter than the blood is calcified; a surface or a label map shows none.
void show_calcium(StageWork& work, meshing::WallLayers& wall) {
  constexpr double kWorthSaying = 0.1;  // mm^3: less is a voxel or two
  if (has_surface_input(work.files) || !work.files.exists(file::kScan)) return;
  const Volume<float> scan = segmentation::read_volume_file(work.files.path(file::kScan));
  if (segmentation::is_label_map(scan)) return;
  const auto level = meshing::measure_calcium_level(scan, read_level_set(work.files), wall);
  if (!level) return;
  const double volume = meshing::mark_calcium(scan, *level, wall);
  if (volume >= kWorthSaying)
    work.warnings.push_back(fmt::format(
        "{:.1f} mm^3 of the wall are brighter than the blood ({:.0f}, threshold "
        "{:.0f}) and taken for calcified; this can be left out (wall.calcium_from_scan = false)",
        volume, level->lumen, level->threshold()));
}

}  // namespace

void do_meshing(StageWork& work, const MeshingSettings& settings) {
  const CenterlineTree tree = read_centerlines(work.files.path(file::kCenterlines));
  const meshing::LumenMeshOptions& options = settings.get<&Config::lumen_mesh>();
  const centerline::LesionOptions& lesion = settings.get<&Config::lesion>();
  const centerline::Resolution resolution = case_resolution(work.files);
  const std::vector<centerline::Lesion> lesions =
      centerline::find_lesions(tree, centerline::lesion_options(lesion, resolution));
  const std::vector<meshing::WidenedStretch> widened =
      stretches_to_widen(lesions, settings.get<&Config::balloon>().nominal_diameter_mm);
  const Progress lumen_progress = part(work.progress, 0.0, 0.5);
  const meshing::LumenMesh lumen =
      work.files.exists(file::kNarrowedLumen)
          ? meshing::mesh_lumen(formats::read_surface(work.files.path(file::kNarrowedLumen)).mesh,
                                tree, options, lumen_progress, widened)
      : has_surface_input(work.files)
          ? meshing::mesh_lumen(read_given_surface(work.files), tree, options, lumen_progress,
                                widened)
          : meshing::mesh_lumen(read_level_set(work.files), tree, options, lumen_progress, widened);
  keep(work.warnings, lumen.warnings);
  tell_of_coarseness(work, options);
  FilledLumen filled;
  Beside filling;
  if (settings.get<&Config::fill_lumen>())
    filling.run([&] { filled = fill_lumen(settings.get<&Config::lumen_volume>(), lumen); });

  Placement placement = place_on_a_lesion(work, settings, tree, lumen, lesions);
  const CenterlinePath& path = path_of(tree, placement.lesion.path_id);
  if (placement.setup) tell_of_balloon(work, lesion, lesions, path, resolution, placement);
  if (placement.setup && settings.get<&Config::wall_model>() == simulation::WallModel::layered) {
    const meshing::WallLayerOptions layers = wall_layer_options(
        settings.get<&Config::wall_layers>(), settings.get<wall_thickness_ratio>());
    meshing::WallLayers wall =
        layer_wall(placement.setup->region, tree_with_path(tree, placement.lesion.path_id),
                   placement.lesion, centerline::lesion_options(lesion, resolution), layers);
    keep(work.warnings, wall.warnings);
    if (settings.get<&Config::calcium_from_scan>()) show_calcium(work, wall);
    write_layered_wall(work.out, wall);
  }
  write_lumen(work.out, lumen);
  filling.wait();
  keep(work.warnings, filled.warnings);
  if (filled.volume) write_lumen_volume(work.out, *filled.volume);
  if (placement.setup) write_balloon_setup(work.out, *placement.setup);
  write_text_atomically(
      work.out / "placement.json",
      placement_json(resolution, path, lumen, filled.volume, placement).dump(2) + "\n");
}

}  // namespace angio::pipeline
