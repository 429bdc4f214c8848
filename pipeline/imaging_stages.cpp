#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <string>

#include "centerline/centerline.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "datasets/phantom.hpp"
#include "meshing/lumen_volume.hpp"
#include "meshing/meshing.hpp"
#include "meshing/repair_surface.hpp"
#include "pipeline/case_files.hpp"
#include "pipeline/layered_wall.hpp"
#include "pipeline/metrics.hpp"
#include "pipeline/stage_parts.hpp"
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

/// Scales a given surface to millimetres. @throws InputError if no vessel is that small or large
void convert_to_mm(TriangleMesh& mesh, LengthUnit unit) {
  // From one short coronary segment to an aorta with the arteries of both legs.
  constexpr double kLeastMm = 3.0, kMostMm = 2000.0;
  for (Vec3& vertex : mesh.vertices) vertex *= kMillimetresOf[int(unit)];
  Vec3 low = mesh.vertices.front(), high = low;
  for (const Vec3& vertex : mesh.vertices)
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], vertex[axis]);
      high[axis] = std::max(high[axis], vertex[axis]);
    }
  const double extent = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
  if (extent >= kLeastMm && extent <= kMostMm) return;
  std::string fitting;
  for (std::size_t u = 0; u < std::size(kLengthUnitNames); ++u) {
    const double in_unit = extent / kMillimetresOf[int(unit)] * kMillimetresOf[u];
    if (in_unit >= 10.0 && in_unit <= 500.0)
      fitting += (fitting.empty() ? "--unit " : " or --unit ") + std::string(kLengthUnitNames[u]);
  }
  throw InputError(fmt::format(
      "the surface is {:.3g} mm across, read in {} (vessels are {} to {} mm long; the file does "
      "not say its unit). {}",
      extent, kLengthUnitNames[int(unit)], kLeastMm, kMostMm,
      fitting.empty() ? "Check what it was exported from" : "Try " + fitting));
}

/// A lumen surface needs no segmentation; it is kept as the later stages read it.
void take_surface(StageWork& work) {
  const fs::path source = work.input.empty()
                              ? work.case_folder.path("segmentation/lumen_surface.vtp")
                              : fs::path(work.input);
  viewer::SurfaceData surface = viewer::read_surface(source);
  if (!work.input.empty()) {
    convert_to_mm(surface.mesh, work.config.surface_unit);
    work.record.input_description =
        fmt::format("lumen surface, {} triangles", surface.mesh.triangles.size());
    meshing::RepairedSurface repaired = meshing::repair_surface(surface.mesh);
    for (const meshing::SurfaceRepair& repair : repaired.repairs)
      if (!repair.is_routine) work.warnings.push_back("repaired: " + to_text(repair));
    surface.mesh = std::move(repaired.mesh);
  }
  viewer::write_surface(work.out / "lumen_surface.vtp", {surface.mesh, {}, {}});
}

TriangleMesh read_given_surface(const StageWork& work) {
  return viewer::read_surface(work.case_folder.path("segmentation/lumen_surface.vtp")).mesh;
}

json to_json(const std::vector<centerline::Lesion>& lesions) {
  json list = json::array();
  for (const centerline::Lesion& lesion : lesions)
    if (lesion.is_stenosis) list.push_back(lesion_metrics(lesion));
  return list;
}

json to_json(const Vec3& v) { return json::array({v.x, v.y, v.z}); }

/// What the simulation and the metrics must know of the placement beyond the meshes.
json placement_json(const centerline::Lesion& lesion, const CenterlinePath& path,
                    const meshing::LumenMesh& lumen,
                    const std::optional<meshing::LumenVolume>& volume,
                    const meshing::Balloon& balloon) {
  const CenterlineSample at = sample(path, lesion.abscissa_mm);
  return {
      {"lesion", lesion_metrics(lesion)},
      {"site",
       {{"point", to_json(at.point)},
        {"tangent", to_json(at.tangent)},
        {"balloon_first_abscissa_mm", project(path, balloon.guidewire.front())},
        {"balloon_last_abscissa_mm", project(path, balloon.guidewire.back())}}},
      {"balloon",
       {{"nominal_diameter_mm", balloon.nominal_diameter_mm}, {"length_mm", balloon.length_mm}}},
      {"balloon_start_diameter_mm", balloon.start_diameter_mm},
      {"mesh", mesh_metrics(lumen, volume)}};
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

struct Placement {
  centerline::Lesion lesion;
  meshing::BalloonSetup setup;
};

/// The balloon across the place that the user named, otherwise across the most severe lesion that
/// one can be brought to.
Placement place_on_a_lesion(StageWork& work, const CenterlineTree& tree,
                            const meshing::LumenMesh& lumen) {
  const std::vector<centerline::Lesion> lesions =
      lesions_to_treat(work.case_folder, work.config, tree);
  for (std::size_t i = 0;; ++i) {
    const centerline::Lesion& lesion = lesions[i];
    try {
      return {lesion,
              meshing::place_balloon(lumen, tree, path_of(tree, lesion.path_id), lesion.abscissa_mm,
                                     lesion.length_mm, lesion.reference_diameter_mm,
                                     work.config.balloon, part(work.progress, 0.7, 0.95))};
    } catch (const InputError& error) {
      if (work.config.lesion.abscissa_mm >= 0.0 || i + 1 == lesions.size()) throw;
      work.warnings.push_back(fmt::format(
          "the stenosis of {:.0f} % on line {}, {:.1f} mm from the inlet, is passed over: {}",
          lesion.diameter_stenosis_percent, lesion.path_id, lesion.abscissa_mm, error.what()));
    }
  }
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
  const Progress progress = part(work.progress, 0.0, 0.95);
  const centerline::CenterlineResult result =
      has_surface_input(work)
          ? centerline::extract_centerline(read_given_surface(work), work.config.centerline,
                                           progress)
          : centerline::extract_centerline(read_level_set(work), work.config.centerline, progress);
  keep(work.warnings, result.warnings);
  write_centerlines(work.out / "centerlines.vtp", result.tree);
  const auto lesions = centerline::find_lesions(
      result.tree, {.min_stenosis_percent = work.config.lesion.min_stenosis_percent});
  write_text_atomically(work.out / "lesions.json", to_json(lesions).dump(2) + "\n");
}
void do_meshing(StageWork& work) {
  const CenterlineTree tree = read_centerlines(work.case_folder.path("centerline/centerlines.vtp"));
  const Progress lumen_progress = part(work.progress, 0.0, 0.5);
  const meshing::LumenMesh lumen =
      has_surface_input(work)
          ? meshing::mesh_lumen(read_given_surface(work), tree, work.config.lumen_mesh,
                                lumen_progress)
          : meshing::mesh_lumen(read_level_set(work), tree, work.config.lumen_mesh, lumen_progress);
  keep(work.warnings, lumen.warnings);
  const std::optional<meshing::LumenVolume> volume = fill_lumen(work, lumen);

  const auto [lesion, setup] = place_on_a_lesion(work, tree, lumen);
  keep(work.warnings, setup.warnings);
  if (!lesion.is_stenosis && work.config.lesion.abscissa_mm < 0.0)
    work.warnings.push_back(fmt::format(
        "no stenosis of {:.0f} % or more was found; the balloon is placed at the tightest place "
        "of the longest vessel (line {}, {:.1f} mm from the inlet). --set lesion.centerline=N "
        "lesion.abscissa_mm=S moves it",
        work.config.lesion.min_stenosis_percent, lesion.path_id, lesion.abscissa_mm));

  if (work.config.simulation.wall_model == simulation::WallModel::layered) {
    const meshing::WallLayers wall = layer_wall(setup.region, tree, lesion, work.config);
    keep(work.warnings, wall.warnings);
    write_layered_wall(work.out, wall);
  }
  write_lumen(work.out, lumen);
  if (volume) write_lumen_volume(work.out, *volume);
  write_balloon_setup(work.out, setup);
  write_text_atomically(
      work.out / "placement.json",
      placement_json(lesion, path_of(tree, lesion.path_id), lumen, volume, setup.balloon).dump(2) +
          "\n");
}

}  // namespace angio::pipeline
