#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <string>

#include "centerline/centerline.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/surface_rims.hpp"
#include "datasets/phantom.hpp"
#include "meshing/lumen_volume.hpp"
#include "meshing/meshing.hpp"
#include "meshing/narrow_lumen.hpp"
#include "pipeline/case_files.hpp"
#include "pipeline/experiment.hpp"
#include "pipeline/layered_wall.hpp"
#include "pipeline/metrics.hpp"
#include "pipeline/resolution.hpp"
#include "pipeline/stage_parts.hpp"
#include "pipeline/surface_input.hpp"
#include "segmentation/read_volume.hpp"
#include "segmentation/segmentation.hpp"
#include "viewer/files.hpp"

// From the input to the meshes.
namespace angio::pipeline {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

Volume<float> load_volume(StageWork& work) {
  if (work.input.empty())
    return segmentation::read_volume_file(work.case_folder.path("segmentation/volume.nrrd"));
  if (work.input.starts_with(kPhantomPrefix)) {
    const auto options = datasets::parse_phantom(work.input);
    work.record.input_description = fmt::format("phantom {}", options.name);
    return datasets::make_phantom_scan(options, part(work.progress, 0.0, 0.2)).volume;
  }
  segmentation::LoadedVolume loaded =
      segmentation::read_volume(work.input, work.config.input, part(work.progress, 0.0, 0.2));
  keep(work.warnings, loaded.warnings);
  work.record.input_description = loaded.source_description;
  return std::move(loaded.volume);
}

/// A lumen in pieces has no way through for a balloon: refused where a surface in one piece is so
/// narrow that its lines cannot pass; told where a scan shows pieces, which may be other vessels.
void check_for_occlusion(StageWork& work, const centerline::CenterlineResult& result,
                         const TriangleMesh* surface) {
  constexpr double kSpeck = 0.02;  // of the lumen
  if (result.left_out < kSpeck) return;
  const std::string needed = fmt::format("a balloon crosses a lumen of at least {:.2f} mm",
                                         meshing::least_lumen_to_cross_mm());
  if (surface && surface_topology(*surface).component_count == 1)
    throw InputError(fmt::format(
        "the vessel is shut: {:.0f} % of the lumen cannot be reached from the rest ({}). Open it "
        "there, or give the part to be treated as a vessel of its own",
        100.0 * result.left_out, needed));
  work.warnings.push_back(
      fmt::format("if the lumen's pieces are one vessel, it is shut between them ({})", needed));
}

constexpr const char* kNarrowedLumen = "centerline/narrowed_lumen.vtp";

TriangleMesh read_given_surface(const StageWork& work) {
  return viewer::read_surface(work.case_folder.path("segmentation/lumen_surface.vtp")).mesh;
}

/// The options of the lines, with the inlet's place where it is named as an open end.
centerline::CenterlineOptions line_options(const Config& config, const TriangleMesh* surface) {
  centerline::CenterlineOptions options = config.centerline;
  if (config.inlet_end == 0) return options;
  const std::vector<SurfaceRim> rims = surface ? surface_rims(*surface) : std::vector<SurfaceRim>{};
  if (config.inlet_end < 0 || config.inlet_end > int(rims.size()))
    throw OptionError(fmt::format(
        "centerline.inlet_end is {}, but the lumen has {} open end(s). `angio inspect SURFACE` "
        "lists them; --inlet X,Y,Z names a point of a scan or a closed surface",
        config.inlet_end, rims.size()));
  options.inlet_lps_mm = rims[std::size_t(config.inlet_end) - 1].centre;
  return options;
}

/// The lumen with a narrowing at the place that the lesion's settings name, or in the middle of
/// its longest suitable branch. Nothing where there is a stenosis already and no place is named.
std::optional<TriangleMesh> narrowed_lumen(StageWork& work, const CenterlineTree& tree,
                                           const Progress& progress) {
  const Config& config = work.config;
  if (config.narrowing.percent <= 0.0) return std::nullopt;
  const auto lesions =
      centerline::find_lesions(tree, {.min_stenosis_percent = config.lesion.min_stenosis_percent});
  if (lesions.front().is_stenosis && config.lesion.abscissa_mm < 0.0) {
    work.warnings.push_back(
        fmt::format("nothing was narrowed: there is a stenosis of {:.0f} % already. --set "
                    "lesion.centerline=N lesion.abscissa_mm=S names a place to narrow all the same",
                    lesions.front().diameter_stenosis_percent));
    return std::nullopt;
  }
  const meshing::Narrowing narrowing = meshing::choose_narrowing(
      tree, config.narrowing, config.lesion.centerline, config.lesion.abscissa_mm);
  // Against the healthy diameter, as a stenosis is measured; some of it may be there already.
  const centerline::Lesion before =
      centerline::find_lesions(tree, {.centerline = narrowing.path_id,
                                      .abscissa_mm = narrowing.abscissa_mm,
                                      .min_stenosis_percent = config.lesion.min_stenosis_percent})
          .front();
  const double wanted = before.reference_diameter_mm * (1.0 - 0.01 * config.narrowing.percent);
  if (wanted < meshing::least_lumen_to_cross_mm())
    throw InputError(
        fmt::format("a stenosis of {:.0f} % of {:.2f} mm would leave {:.2f} mm (a balloon crosses "
                    "a lumen of at "
                    "least {:.2f} mm). Lower lesion.narrow_percent",
                    config.narrowing.percent, before.reference_diameter_mm, wanted,
                    meshing::least_lumen_to_cross_mm()));
  const double percent = std::max(0.0, 100.0 * (1.0 - wanted / narrowing.diameter_mm));
  const meshing::LumenMesh lumen =
      has_surface_input(work) ? meshing::mesh_lumen(read_given_surface(work), tree, {}, progress)
                              : meshing::mesh_lumen(read_level_set(work), tree, {}, progress);
  work.warnings.push_back(fmt::format(
      "the vessel was narrowed by {:.0f} % over {:.1f} mm on line {}, {:.1f} mm from the inlet "
      "(of {:.2f} mm): this lesion is made, not the patient's",
      config.narrowing.percent, narrowing.length_mm, narrowing.path_id, narrowing.abscissa_mm,
      before.reference_diameter_mm));
  return meshing::narrow_lumen(lumen.capped, path_of(tree, narrowing.path_id), narrowing, percent);
}

json to_json(const std::vector<centerline::Lesion>& lesions, double resolution_mm) {
  json list = json::array();
  for (const centerline::Lesion& lesion : lesions)
    if (lesion.is_stenosis) list.push_back(lesion_metrics(lesion, resolution_mm));
  return list;
}

/// Narrowings that nobody can measure are not listed, but told of.
void tell_of_thin_vessels(StageWork& work, const std::vector<centerline::Lesion>& lesions) {
  const auto thin = std::count_if(lesions.begin(), lesions.end(),
                                  [](const auto& lesion) { return lesion.is_too_thin; });
  if (thin == 0) return;
  const bool is_surface = has_surface_input(work);
  double widest = 0.0;
  for (const centerline::Lesion& lesion : lesions)
    if (lesion.is_too_thin) widest = std::max(widest, lesion.reference_diameter_mm);
  work.warnings.push_back(
      fmt::format("{} narrowing{} in vessels under {} wide ({:.2f} mm at most) {} not listed: the "
                  "{} is too coarse to measure a stenosis there",
                  thin, thin == 1 ? "" : "s", is_surface ? "two triangles' edges" : "three voxels",
                  widest, thin == 1 ? "is" : "are", is_surface ? "surface" : "scan"));
}

json to_json(const Vec3& v) { return json::array({v.x, v.y, v.z}); }

struct Placement {
  centerline::Lesion lesion;
  std::optional<meshing::BalloonSetup> setup;  ///< none: nothing is treated
  std::string status = "done", reason;         ///< CaseStatus's, if the simulation ends right
};

/// What the simulation and the metrics must know of the placement beyond the meshes.
json placement_json(double resolution_mm, const CenterlinePath& path,
                    const meshing::LumenMesh& lumen,
                    const std::optional<meshing::LumenVolume>& volume, const Placement& placement) {
  const centerline::Lesion& lesion = placement.lesion;
  json result = {{"lesion", lesion_metrics(lesion, resolution_mm)},
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

/// The tetrahedral lumen mesh is for other programs: without it, the run goes on.
std::optional<meshing::LumenVolume> fill_lumen(StageWork& work, const meshing::LumenMesh& lumen) {
  if (!work.config.fill_lumen) return std::nullopt;
  try {
    meshing::LumenVolume volume =
        meshing::mesh_lumen_volume(lumen, work.config.lumen_volume, part(work.progress, 0.5, 0.7));
    keep(work.warnings, volume.warnings);
    return volume;
  } catch (const InputError& error) {
    work.warnings.push_back(fmt::format("there is no lumen.vtu: {}", error.what()));
    return std::nullopt;
  }
}

/// Why a vessel is not treated unless somebody asks for it; empty: it is.
std::string reason_to_leave(const centerline::Lesion& lesion) {
  constexpr double kLeastTreated = 1.5;     // [mm] the smallest vessels that balloons are used in
  constexpr double kLargestBalloon = 30.0;  // [mm] that is sold
  const double diameter = lesion.reference_diameter_mm;
  if (diameter < kLeastTreated)
    return fmt::format("the vessel there, of {:.2f} mm, is narrower than {} mm", diameter,
                       kLeastTreated);
  if (diameter > kLargestBalloon)
    return fmt::format("there is no balloon for a vessel of {:.1f} mm", diameter);
  return {};
}

std::string place_of(const centerline::Lesion& lesion) {
  return fmt::format("line {}, {:.1f} mm from the inlet", lesion.path_id, lesion.abscissa_mm);
}

/// Nothing is treated: of the worst lesion it is told why.
Placement no_placement(const centerline::Lesion& worst, const std::string& reason, double least) {
  if (worst.is_stenosis)
    return {worst, std::nullopt, "not_determined",
            fmt::format("the stenosis of {:.0f} % on {} is not treated: {}",
                        worst.diameter_stenosis_percent, place_of(worst), reason)};
  return {worst, std::nullopt, "no_lesion",
          fmt::format("no stenosis of {:.0f} % or more was found, and no balloon is placed at the "
                      "tightest place ({}): {}",
                      least, place_of(worst), reason)};
}

/// The balloon across the place that the user named, otherwise across the most severe lesion that
/// one can be brought to.
Placement place_on_a_lesion(StageWork& work, const CenterlineTree& tree,
                            const meshing::LumenMesh& lumen, const Resolution& resolution) {
  const bool is_place_given = work.config.lesion.abscissa_mm >= 0.0,
             is_balloon_given = work.config.balloon.nominal_diameter_mm > 0.0;
  const std::vector<centerline::Lesion> lesions =
      centerline::find_lesions(tree, lesion_options(work.config, resolution));
  std::string first_reason;
  for (const centerline::Lesion& lesion : lesions) {
    if (lesion.is_too_thin) continue;
    std::string reason = is_place_given || is_balloon_given ? "" : reason_to_leave(lesion);
    try {
      if (reason.empty())
        return {
            lesion,
            meshing::place_balloon(lumen, tree, path_of(tree, lesion.path_id), lesion.abscissa_mm,
                                   lesion.length_mm, lesion.reference_diameter_mm,
                                   work.config.balloon, part(work.progress, 0.7, 0.95)),
            "done", ""};
    } catch (const InputError& error) {
      if (is_place_given) throw;
      reason = error.what();
    }
    work.warnings.push_back(fmt::format("the stenosis of {:.0f} % on {} is passed over: {}",
                                        lesion.diameter_stenosis_percent, place_of(lesion),
                                        reason));
    if (first_reason.empty()) first_reason = reason;
  }
  return no_placement(lesions.front(), first_reason, work.config.lesion.min_stenosis_percent);
}

/// What is to be told of a balloon that was placed.
void tell_of_balloon(StageWork& work, double resolution_mm, Placement& placement) {
  const centerline::Lesion& lesion = placement.lesion;
  keep(work.warnings, placement.setup->warnings);
  constexpr double kMuchTooLarge = 1.5;
  const double nominal = placement.setup->balloon.nominal_diameter_mm,
               to_artery = nominal / lesion.reference_diameter_mm;
  if (to_artery > kMuchTooLarge)
    work.warnings.push_back(fmt::format(
        "the balloon's nominal diameter, {:.2f} mm, is {:.1f} times the vessel's at the lesion",
        nominal, to_artery));
  if (lesion.mld_mm < resolution_mm)
    work.warnings.push_back(fmt::format(
        "the lesion's throat is narrower than a voxel ({:.2f} mm): its diameter, {:.2f} mm, is not "
        "measured, and the stenosis is at least {:.0f} %",
        resolution_mm, lesion.mld_mm,
        std::max(0.0, 100.0 * (1.0 - resolution_mm / lesion.reference_diameter_mm))));
  if (lesion.is_stenosis || work.config.lesion.abscissa_mm >= 0.0) return;
  placement.status = "no_lesion";
  placement.reason = fmt::format(
      "no stenosis of {:.0f} % or more was found; the balloon is placed at the tightest place "
      "of the longest vessel ({}). --set lesion.centerline=N lesion.abscissa_mm=S moves it",
      work.config.lesion.min_stenosis_percent, place_of(lesion));
  work.warnings.push_back(placement.reason);
}

}  // namespace

void do_segmentation(StageWork& work) {
  if (work.record.input_kind == name(InputKind::surface)) return take_surface(work);
  const Volume<float> volume = load_volume(work);
  const segmentation::Segmentation result = segmentation::segment_vessels(
      volume, work.config.segmentation, part(work.progress, 0.2, 0.9));
  keep(work.warnings, result.warnings);
  work.progress.report(0.9, "writing");
  segmentation::write_volume(work.out / "volume.nrrd", volume);
  segmentation::write_volume(work.out / "lumen_mask.nrrd", result.mask);
  segmentation::write_volume(work.out / "lumen_level_set.nrrd", result.level_set);
}

void do_centerline(StageWork& work) {
  const Progress progress = part(work.progress, 0.0, 0.4);
  const std::optional<TriangleMesh> given =
      has_surface_input(work) ? std::optional(read_given_surface(work)) : std::nullopt;
  const centerline::CenterlineOptions options =
      line_options(work.config, given ? &*given : nullptr);
  centerline::CenterlineResult result =
      given ? centerline::extract_centerline(*given, options, progress)
            : centerline::extract_centerline(read_level_set(work), options, progress);
  check_for_occlusion(work, result, given ? &*given : nullptr);
  if (const auto narrowed = narrowed_lumen(work, result.tree, part(work.progress, 0.4, 0.6))) {
    result = centerline::extract_centerline(*narrowed, options, part(work.progress, 0.6, 0.95));
    viewer::write_surface(work.out / fs::path(kNarrowedLumen).filename(), {*narrowed, {}, {}});
  }
  keep(work.warnings, result.warnings);
  write_centerlines(work.out / "centerlines.vtp", result.tree);
  write_paths(work.out / "paths.vtp", result.tree);
  const Resolution resolution = case_resolution(work.case_folder);
  const auto lesions =
      centerline::find_lesions(result.tree, whole_tree(lesion_options(work.config, resolution)));
  tell_of_thin_vessels(work, lesions);
  write_text_atomically(work.out / "lesions.json",
                        to_json(lesions, resolution.longest_mm).dump(2) + "\n");
}
void do_meshing(StageWork& work) {
  const CenterlineTree tree = read_centerlines(work.case_folder.path("centerline/centerlines.vtp"));
  const Progress lumen_progress = part(work.progress, 0.0, 0.5);
  const meshing::LumenMesh lumen =
      work.case_folder.exists(kNarrowedLumen)
          ? meshing::mesh_lumen(viewer::read_surface(work.case_folder.path(kNarrowedLumen)).mesh,
                                tree, work.config.lumen_mesh, lumen_progress)
      : has_surface_input(work)
          ? meshing::mesh_lumen(read_given_surface(work), tree, work.config.lumen_mesh,
                                lumen_progress)
          : meshing::mesh_lumen(read_level_set(work), tree, work.config.lumen_mesh, lumen_progress);
  keep(work.warnings, lumen.warnings);
  const std::optional<meshing::LumenVolume> volume = fill_lumen(work, lumen);

  const Resolution resolution = case_resolution(work.case_folder);
  Placement placement = place_on_a_lesion(work, tree, lumen, resolution);
  if (placement.setup) tell_of_balloon(work, resolution.longest_mm, placement);
  if (placement.setup && work.config.simulation.wall_model == simulation::WallModel::layered) {
    const meshing::WallLayers wall =
        layer_wall(placement.setup->region, tree, placement.lesion, resolution, work.config);
    keep(work.warnings, wall.warnings);
    write_layered_wall(work.out, wall);
  }
  write_lumen(work.out, lumen);
  if (volume) write_lumen_volume(work.out, *volume);
  if (placement.setup) write_balloon_setup(work.out, *placement.setup);
  const CenterlinePath& path = path_of(tree, placement.lesion.path_id);
  write_text_atomically(
      work.out / "placement.json",
      placement_json(resolution.longest_mm, path, lumen, volume, placement).dump(2) + "\n");
}

}  // namespace angio::pipeline
