#include "pipeline/stages/centerline.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>

#include "centerline/centerline.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/surface_rims.hpp"
#include "formats/case_file.hpp"
#include "formats/files.hpp"
#include "meshing/meshing.hpp"
#include "meshing/narrow_lumen.hpp"
#include "pipeline/case/case_files.hpp"
#include "pipeline/case/doubts.hpp"
#include "pipeline/case/metrics.hpp"
#include "pipeline/case/resolution.hpp"

// From the lumen to its lines and lesions.
namespace angio::pipeline {
namespace file = formats::case_file;
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

/// A lumen in pieces has no way through for a balloon: refused where a surface in one piece is so
/// narrow that its lines cannot pass; told where pieces, which may be other vessels, have no lines.
void check_for_occlusion(StageWork& work, const centerline::CenterlineResult& result,
                         const TriangleMesh* surface) {
  constexpr double kSpeck = 0.02;  // of the lumen
  const bool is_one_vessel = surface && surface_topology(*surface).component_count == 1;
  if (result.left_out < kSpeck && !(is_one_vessel && result.tree_count > 1)) return;
  const std::string needed = fmt::format("a balloon crosses a lumen of at least {:.2f} mm",
                                         meshing::least_lumen_to_cross_mm());
  if (is_one_vessel)
    throw InputError(fmt::format(
        "the vessel is shut: {:.0f} % of the lumen cannot be reached from the rest ({}). Open it "
        "there, or give the part to be treated as a vessel of its own",
        100.0 * result.beside_largest, needed));
  work.warnings.push_back(
      fmt::format("if the lumen's pieces are one vessel, it is shut between them ({})", needed));
}

/// The options of the lines, with the inlet's place where it is named as an open end.
centerline::CenterlineOptions line_options(const CenterlineSettings& settings,
                                           const TriangleMesh* surface) {
  centerline::CenterlineOptions options = settings.get<&Config::centerline>();
  options.least_throat_mm = meshing::least_lumen_to_cross_mm();
  const int inlet_end = settings.get<&Config::inlet_end>();
  if (inlet_end == 0) return options;
  const std::vector<SurfaceRim> rims = surface ? surface_rims(*surface) : std::vector<SurfaceRim>{};
  if (inlet_end < 0 || inlet_end > int(rims.size()))
    throw OptionError(fmt::format(
        "centerline.inlet_end is {}, but the lumen has {} open end(s). `angio inspect SURFACE` "
        "lists them; --inlet X,Y,Z names a point of a scan or a closed surface",
        inlet_end, rims.size()));
  options.inlet_lps_mm = rims[std::size_t(inlet_end) - 1].centre;
  return options;
}

/// The lumen with a narrowing at the place that the lesion's settings name, or in the middle of
/// its longest suitable branch. Nothing where there is a stenosis already and no place is named.
std::optional<TriangleMesh> narrowed_lumen(StageWork& work, const CenterlineSettings& settings,
                                           const CenterlineTree& tree, const Progress& progress) {
  const meshing::NarrowingOptions& asked = settings.get<&Config::narrowing>();
  const centerline::LesionOptions& lesion = settings.get<&Config::lesion>();
  if (asked.percent <= 0.0) return std::nullopt;
  const auto lesions =
      centerline::find_lesions(tree, {.min_stenosis_percent = lesion.min_stenosis_percent});
  if (lesions.front().is_stenosis && lesion.abscissa_mm < 0.0) {
    work.warnings.push_back(
        fmt::format("nothing was narrowed: there is a stenosis of {:.0f} % already. You "
                    "can name a place to narrow all the same (--set lesion.centerline=N "
                    "lesion.abscissa_mm=S)",
                    lesions.front().diameter_stenosis_percent));
    return std::nullopt;
  }
  const meshing::Narrowing narrowing =
      meshing::choose_narrowing(tree, asked, lesion.centerline, lesion.abscissa_mm);
  // Against the healthy diameter, as a stenosis is measured; some of it may be there already.
  const centerline::Lesion before =
      centerline::find_lesions(tree, {.centerline = narrowing.path_id,
                                      .abscissa_mm = narrowing.abscissa_mm,
                                      .min_stenosis_percent = lesion.min_stenosis_percent})
          .front();
  const double wanted = before.reference_diameter_mm * (1.0 - 0.01 * asked.percent);
  if (wanted < meshing::least_lumen_to_cross_mm())
    throw InputError(fmt::format(
        "a stenosis of {:.0f} % of {:.2f} mm would leave {:.2f} mm (a balloon crosses "
        "a lumen of at "
        "least {:.2f} mm). Lower lesion.narrow_percent",
        asked.percent, before.reference_diameter_mm, wanted, meshing::least_lumen_to_cross_mm()));
  const double percent = std::max(0.0, 100.0 * (1.0 - wanted / narrowing.diameter_mm));
  const meshing::LumenMesh lumen =
      has_surface_input(work.files)
          ? meshing::mesh_lumen(read_given_surface(work.files), tree, {}, progress)
          : meshing::mesh_lumen(read_level_set(work.files), tree, {}, progress);
  work.warnings.push_back(fmt::format(
      "the vessel was narrowed by {:.0f} % over {:.1f} mm on line {}, {:.1f} mm from the inlet "
      "(of {:.2f} mm): this lesion is made, not the patient's",
      asked.percent, narrowing.length_mm, narrowing.path_id, narrowing.abscissa_mm,
      before.reference_diameter_mm));
  return meshing::narrow_lumen(lumen.capped, path_of(tree, narrowing.path_id), narrowing, percent);
}

json to_json(const std::vector<centerline::Lesion>& lesions, const CenterlineTree& tree,
             const centerline::Resolution& resolution) {
  json list = json::array();
  for (const centerline::Lesion& lesion : lesions)
    if (lesion.is_stenosis)
      list.push_back(lesion_metrics(lesion, path_of(tree, lesion.path_id), resolution));
  return list;
}

/// Narrowings that nobody can measure are not listed, but told of.
void tell_of_thin_vessels(StageWork& work, const std::vector<centerline::Lesion>& lesions,
                          const centerline::Resolution& resolution) {
  const auto is_told = [](const centerline::Lesion& lesion) {
    return lesion.is_too_thin && !lesion.is_too_small;
  };
  const auto thin = std::count_if(lesions.begin(), lesions.end(), is_told);
  if (thin == 0) return;
  const bool has_voxels = resolution.mean_mm > 0.0;
  const std::string data =
      !resolution.surface ? "scan"
      : has_voxels
          ? fmt::format("surface, which was made from voxels of {:.2f} mm,", resolution.mean_mm)
          : "surface";
  double widest = 0.0;
  for (const centerline::Lesion& lesion : lesions)
    if (is_told(lesion)) widest = std::max(widest, lesion.reference_diameter_mm);
  work.warnings.push_back(
      fmt::format("{} narrowing{} in vessels under {} wide ({:.2f} mm at most) {} not listed: the "
                  "{} is too coarse to measure a stenosis there",
                  thin, thin == 1 ? "" : "s",
                  !resolution.surface ? "three voxels"
                  : has_voxels        ? "three voxels or three triangles' edges"
                                      : "three triangles' edges",
                  widest, thin == 1 ? "is" : "are", data));
}

/// Narrowings in vessels that are thinner than those that are looked at are told of.
void tell_of_small_vessels(StageWork& work, const std::vector<centerline::Lesion>& lesions,
                           double least_mm) {
  const auto small = std::count_if(lesions.begin(), lesions.end(),
                                   [](const auto& lesion) { return lesion.is_too_small; });
  if (small > 0)
    work.warnings.push_back(
        fmt::format("{} narrowing{} in vessels under {:.1f} mm wide {} not listed: balloons are "
                    "made for wider ones",
                    small, small == 1 ? "" : "s", least_mm, small == 1 ? "is" : "are"));
}

/// What narrowings may be instead of stenoses.
std::string what_else(const centerline::Lesion& lesion, bool is_surface) {
  switch (lesion.doubt) {
    case centerline::Doubt::faint:
      return "healthy vessels of such a tree may vary as much, or its diameters err";
    case centerline::Doubt::crowded:
      return "in so large a tree, or one where so many vessels touch or form loops, it may be "
             "where one vessel meets another; " +
             std::string(is_surface
                             ? "a surface of the vessel alone shows it without its neighbours"
                             : "a region around the vessel, or seeds in it, take it without "
                               "its neighbours (segmentation.region_lps_mm, "
                               "segmentation.seeds_lps_mm)");
    case centerline::Doubt::beside_no_tube:
      return "the lumen beside it is no tube, but an organ's or a sac's";
    case centerline::Doubt::heart:
      return "it may be a valve of the heart, or lie beyond the heart";
    case centerline::Doubt::at_beginning:
      return "the line begins in it, and no healthy vessel is seen before it";
    case centerline::Doubt::at_end:
      return "the line ends in it, and no healthy vessel is seen behind it";
    case centerline::Doubt::beyond_aneurysm:
      return "nothing is seen beyond it on one side, and an aneurysm lies on the other: the vessel "
             "may be as thin there by itself";
    case centerline::Doubt::other_blood:
      return "the scan is not as bright, or not as even, on both sides of it as one vessel's blood "
             "is: the line may leave the vessel there";
    case centerline::Doubt::bead:
      return "the width swings to and fro like beads on a string, as in a ragged " +
             std::string(is_surface ? "surface" : "segmentation") +
             " or in fibromuscular dysplasia, where a diameter stenosis is no measure";
    case centerline::Doubt::bridge:
      return "it is short, or the line turns round it, and another vessel passes it by: it may be "
             "where the two touch";
    case centerline::Doubt::wide_sides:
      return fmt::format(
          "that is against the healthy tree, which would be {:.2f} mm wide there; the same vessel "
          "is up to {:.2f} mm wide before and behind it, and against that it is a stenosis of "
          "{:.0f} %: it may be dilated there, or narrow on its way to it",
          lesion.reference_diameter_mm, lesion.widest_beside_mm, lesion.percent_of_sides());
    case centerline::Doubt::none:
    case centerline::Doubt::diffuse:
      break;
  }
  throw InternalError("a doubt without a reason");
}

/// Narrowings that are as likely something else are not listed, but told of.
void tell_of_doubtful(StageWork& work, const std::vector<centerline::Lesion>& lesions) {
  const bool is_surface = has_surface_input(work.files);
  using centerline::Doubt;
  for (const Doubt doubt : {Doubt::faint, Doubt::crowded, Doubt::beside_no_tube, Doubt::heart,
                            Doubt::at_beginning, Doubt::at_end, Doubt::bead, Doubt::bridge,
                            Doubt::beyond_aneurysm, Doubt::wide_sides, Doubt::other_blood}) {
    const auto is_told = [&](const centerline::Lesion& lesion) {
      return lesion.doubt == doubt && !lesion.is_too_thin && !lesion.is_too_small;
    };
    const auto worst = std::find_if(lesions.begin(), lesions.end(), is_told);
    if (worst == lesions.end()) continue;
    const auto count = std::count_if(lesions.begin(), lesions.end(), is_told);
    work.warnings.push_back(fmt::format(
        "{} narrowing{} not listed, the worst of {:.0f} % on line {}, {:.1f} mm from "
        "the inlet: {}. "
        "That line can be looked at alone (--set lesion.centerline={})",
        count, count == 1 ? " is" : "s are", worst->diameter_stenosis_percent, worst->path_id,
        worst->abscissa_mm, what_else(*worst, is_surface), worst->path_id));
  }
}

/// A vessel that is thin for most of its length is told of: its ends may be dilated.
void tell_of_diffuse(StageWork& work, const std::vector<centerline::Lesion>& lesions) {
  for (const centerline::Lesion& lesion : lesions)
    if (lesion.doubt == centerline::Doubt::diffuse)
      work.warnings.push_back(fmt::format(
          "from {:.1f} to {:.1f} mm line {} is up to {:.0f} % narrower than before and behind "
          "({:.2f} mm at {:.1f} mm): diffuse disease, or ends that are dilated; it is not listed, "
          "for most of the vessel is as thin. A balloon can be placed there (--set "
          "lesion.centerline={} lesion.abscissa_mm={:.1f})",
          lesion.proximal_mm, lesion.distal_mm, lesion.path_id, lesion.diameter_stenosis_percent,
          lesion.mld_mm, lesion.abscissa_mm, lesion.path_id, lesion.abscissa_mm));
}

/// Tells of the stenoses that would be far worse, or far less, by the vessel beside them.
void tell_of_references(StageWork& work, const CenterlineTree& tree,
                        const std::vector<centerline::Lesion>& lesions) {
  const auto tell = [&](const centerline::Lesion& lesion, std::string_view where, double width_mm,
                        std::string_view what) {
    work.warnings.push_back(fmt::format(
        "{} on line {}, {:.1f} mm from the inlet, is the healthy tree's there, {:.2f} mm; {} "
        "{:.2f} "
        "mm wide. Against that it would be {:.0f} % and not {:.0f} %: {} Look before a balloon is "
        "chosen by it (--balloon)",
        kDoubtfulReference, lesion.path_id, lesion.abscissa_mm, lesion.reference_diameter_mm, where,
        width_mm, 100.0 * (1.0 - lesion.mld_mm / width_mm), lesion.diameter_stenosis_percent,
        what));
  };
  for (const centerline::Lesion& lesion : lesions) {
    if (!lesion.is_stenosis) continue;
    if (lesion.is_in_thin_vessel())
      tell(lesion, "right before and behind the throat the vessel is", lesion.beside_throat_mm,
           "diseased along its length, or as thin there by itself?");
    if (lesion.has_wide_sides())
      tell(lesion, "before and behind it the same vessel is, in the mean of both, up to",
           lesion.widest_beside_mm, "dilated beside it, or narrow on its way to it?");
    const double to_end = path_of(tree, lesion.path_id).abscissa.back() - lesion.distal_mm;
    if (!(lesion.reference_distal_mm > 0.0) && to_end < lesion.reference_diameter_mm)
      work.warnings.push_back(fmt::format(
          "{} on line {}, {:.1f} mm from the inlet, rests on the vessel before it: the line ends "
          "{:.1f} mm behind the stenosis, and no healthy vessel is seen there. A vessel that "
          "tapers "
          "to its end looks the same. Look before a balloon is chosen by it (--balloon)",
          kDoubtfulReference, lesion.path_id, lesion.abscissa_mm, std::max(0.0, to_end)));
  }
}

}  // namespace

CenterlineSettings centerline_settings(const Config& config) {
  Config seen = config;
  if (seen.narrowing.percent <= 0.0) {
    const centerline::LesionOptions nowhere;
    seen.lesion.centerline = nowhere.centerline;
    seen.lesion.abscissa_mm = nowhere.abscissa_mm;
  }
  return CenterlineSettings(seen);
}

void do_centerline(StageWork& work, const CenterlineSettings& settings) {
  const Progress progress = part(work.progress, 0.0, 0.4);
  const std::optional<TriangleMesh> given =
      has_surface_input(work.files) ? std::optional(read_given_surface(work.files)) : std::nullopt;
  const centerline::Resolution resolution = case_resolution(work.files);
  centerline::CenterlineOptions options = line_options(settings, given ? &*given : nullptr);
  if (!given) options.voxel_mm = resolution.longest_mm;
  centerline::CenterlineResult result =
      given ? centerline::extract_centerline(*given, options, progress)
            : centerline::extract_centerline(read_level_set(work.files), options, progress);
  check_for_occlusion(work, result, given ? &*given : nullptr);
  if (const auto narrowed =
          narrowed_lumen(work, settings, result.tree, part(work.progress, 0.4, 0.6))) {
    result = centerline::extract_centerline(*narrowed, options, part(work.progress, 0.6, 0.95));
    formats::write_surface(work.out / fs::path(file::kNarrowedLumen).filename(),
                           {*narrowed, {}, {}});
  }
  keep(work.warnings, result.warnings);
  write_centerlines(work.out / "centerlines.vtp", result.tree);
  write_paths(work.out / "paths.vtp", result.tree);
  const auto lesions =
      centerline::find_lesions(result.tree, centerline::whole_tree(centerline::lesion_options(
                                                settings.get<&Config::lesion>(), resolution)));
  tell_of_thin_vessels(work, lesions, resolution);
  tell_of_small_vessels(work, lesions, settings.get<&Config::lesion>().min_reference_mm);
  tell_of_doubtful(work, lesions);
  tell_of_diffuse(work, lesions);
  tell_of_references(work, result.tree, lesions);
  write_text_atomically(work.out / "lesions.json",
                        to_json(lesions, result.tree, resolution).dump(2) + "\n");
}

}  // namespace angio::pipeline
