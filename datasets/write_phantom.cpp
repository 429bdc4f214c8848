#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <system_error>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "datasets/detail/anatomy.hpp"
#include "datasets/detail/organ_motion.hpp"
#include "datasets/detail/write_dicom.hpp"
#include "datasets/phantom.hpp"
#include "datasets/rotational_run.hpp"
#include "formats/files.hpp"
#include "formats/nrrd.hpp"

namespace angio::datasets {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Everything that the bytes of a phantom depend on.
std::string fingerprint(const PhantomOptions& o, const VolumeGeometry& g) {
  std::ostringstream out;
  out << std::setprecision(17) << o.name << ' ' << o.stenosis_percent << ' ' << o.radius_mm << ' '
      << o.length_mm << ' ' << o.spacing_mm << ' ' << o.noise_sd << ' ' << o.blur_mm << ' '
      << o.oblique_degrees << ' ' << o.seed;
  for (int axis = 0; axis < 3; ++axis) {
    out << ' ' << g.size[std::size_t(axis)] << ' ' << g.spacing[axis] << ' ' << g.origin[axis];
    for (int column = 0; column < 3; ++column) out << ' ' << g.direction(axis, column);
  }
  return out.str();
}

Json json_from(const Vec3& v) { return Json::array({v.x, v.y, v.z}); }

Json json_rows(const Mat3& m) {
  Json rows = Json::array();
  for (int row = 0; row < 3; ++row) rows.push_back({m(row, 0), m(row, 1), m(row, 2)});
  return rows;
}

Json json_from(const CenterlinePath& path) {
  Json points = Json::array();
  for (const Vec3& point : path.points) points.push_back(json_from(point));
  Json tracts = Json::array();
  for (const CenterlineTract& tract : path.tracts)
    tracts.push_back({{"first_point", tract.first_point},
                      {"last_point", tract.last_point},
                      {"group_id", tract.group_id},
                      {"tract_id", tract.tract_id},
                      {"blanking", tract.blanking}});
  return {{"id", path.id},
          {"points_mm", points},
          {"inscribed_radius_mm", path.inscribed_radius},
          {"abscissa_mm", path.abscissa},
          {"section_area_mm2", path.section_area},
          {"equivalent_radius_mm", path.equivalent_radius},
          {"tracts", tracts}};
}

Json json_from(const PhantomOptions& o) {
  return {{"stenosis_percent", o.stenosis_percent},
          {"radius_mm", o.radius_mm},
          {"length_mm", o.length_mm},
          {"spacing_mm", o.spacing_mm},
          {"slice_mm", o.slice_mm},
          {"noise_sd", o.noise_sd},
          {"blur_mm", o.blur_mm},
          {"oblique_degrees", o.oblique_degrees},
          {"seed", o.seed}};
}

Json json_from(const LesionTruth& lesion) {
  return {{"mld_mm", lesion.mld_mm},
          {"mla_mm2", lesion.mla_mm2},
          {"reference_diameter_mm", lesion.reference_diameter_mm},
          {"diameter_stenosis_percent", lesion.diameter_stenosis_percent},
          {"lesion_path", lesion.lesion_path},
          {"lesion_abscissa_mm", lesion.lesion_abscissa_mm},
          {"lesion_point_mm", json_from(lesion.lesion_point)}};
}

Json truth_json(const Phantom& phantom, const PhantomOptions& sized) {
  const PhantomTruth& truth = phantom.truth;
  Json json;
  json["phantom"] = sized.name;
  json["space"] = "LPS";
  json["units"] = {{"length", "mm"},
                   {"area", "mm2"},
                   {"stenosis", "percent"},
                   {"noise_sd", "fraction of the contrast"}};
  json["options"] = json_from(sized);
  json["intensity"] = {{"lumen", kLumenIntensity}, {"background", kBackgroundIntensity}};
  json["has_lesion"] = truth.has_lesion;
  json.update(json_from(static_cast<const LesionTruth&>(truth)));
  json["lesions"] = Json::array();
  for (const LesionTruth& lesion : truth.lesions) json["lesions"].push_back(json_from(lesion));
  if (const VolumeGeometry& g = phantom.volume.geometry; g.voxel_count() > 0)
    json["volume"] = {{"size", g.size},
                      {"spacing_mm", json_from(g.spacing)},
                      {"origin_mm", json_from(g.origin)},
                      {"direction_rows", json_rows(g.direction)}};
  json["surface"] = {{"vertex_count", phantom.surface.vertices.size()},
                     {"triangle_count", phantom.surface.triangles.size()}};
  json["paths"] = Json::array();
  for (const CenterlinePath& path : truth.tree.paths) json["paths"].push_back(json_from(path));
  return json;
}

std::string as_text(const Json& json) { return json.dump(1) + "\n"; }

Json motion_json(const RotationalRunOfPhantom& run) {
  const RotationalRunOptions& o = run.options;
  Json shifts = Json::array(), r_waves = Json::array();
  for (const Vec3& shift : run.motion.breathing_shifts_mm) shifts.push_back(json_from(shift));
  for (const int frame : run.motion.r_wave_frames) r_waves.push_back(frame + 1);
  return {{"frame_time_ms", o.frame_time_ms},
          {"heartbeat_mm", o.heartbeat_mm},
          {"heart_rate_per_min", o.heart_rate_per_min},
          {"breathing_mm", o.breathing_mm},
          {"breaths_per_min", o.breaths_per_min},
          {"inflow_s", o.inflow_s},
          {"tells_r_waves", o.tells_r_waves},
          {"truth_phase_percent", 100.0 * detail::kRestingPhase},
          {"r_wave_frames", r_waves},
          {"cardiac_phases", run.motion.cardiac_phases},
          {"heart_excursions", run.motion.heart_excursions},
          {"breathing_shifts_mm", shifts},
          {"filled_parts", run.motion.filled_parts}};
}

Json json_from(const RotationalRunOfPhantom& run) {
  const RotationalRunOptions& o = run.options;
  Json matrices = Json::array();
  for (const angiogram::ConeBeamFrame& frame : run.frames)
    matrices.push_back(angiogram::ConeBeamView(frame).matrix());
  Json json = {{"frames", o.frames},
               {"arc_degrees", o.arc_degrees},
               {"columns", run.mount.columns},
               {"rows", run.mount.rows},
               {"column_spacing_mm", run.mount.column_spacing_mm},
               {"source_to_detector_mm", o.source_to_detector_mm},
               {"source_to_isocentre_mm", o.source_to_isocentre_mm},
               {"noise", o.noise},
               {"body", o.body},
               {"mask_run", o.mask_run},
               {"contrast_per_mm", o.contrast_per_mm},
               {"wobble_mm", o.wobble_mm},
               {"wobble_degrees", o.wobble_degrees},
               {"primary_angles_degrees", run.primary_angles_degrees},
               {"matrices", matrices}};
  if (o.moves()) json["motion"] = motion_json(run);
  return json;
}

/// A series is only whole with all its files: they are written beside, then the folder is renamed.
/// @param write  into the folder that it gets
void write_folder(const fs::path& folder, const std::function<void(const fs::path&)>& write) {
  std::error_code ignored;
  bool is_ours = !fs::exists(folder) || fs::is_directory(folder);
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored))
    is_ours = is_ours && entry.path().extension() == ".dcm";
  if (!is_ours)
    throw IoError(
        "cannot replace " + folder.string() +
            " (it is not a phantom's, or holds other files too). Choose another output folder",
        ExitCode::cannot_create);
  const fs::path temporary = folder.parent_path() / (".dicom.tmp-" + std::to_string(::getpid()));
  make_folder(temporary);
  try {
    write(temporary);
    fs::remove_all(folder);
    fs::rename(temporary, folder);
  } catch (const fs::filesystem_error& error) {
    fs::remove_all(temporary, ignored);
    throw IoError("cannot create " + folder.string() + " (" + error.code().message() +
                      "). Choose another output folder",
                  ExitCode::cannot_create);
  } catch (...) {
    fs::remove_all(temporary, ignored);
    throw;
  }
}

void write_dicom(const Phantom& phantom, const PhantomOptions& sized, PhantomFormat format,
                 const fs::path& folder) {
  const auto write =
      format == PhantomFormat::dicom ? detail::write_dicom_series : detail::write_dicom_xray_3d;
  write_folder(folder, [&](const fs::path& temporary) {
    write(phantom.volume, sized.name, fingerprint(sized, phantom.volume.geometry), temporary);
  });
}

}  // namespace

fs::path write_phantom(const Phantom& phantom, const PhantomOptions& options, PhantomFormat format,
                       const fs::path& folder) {
  const PhantomOptions sized = detail::with_size(options);
  if (format != PhantomFormat::surface && phantom.volume.values.empty())
    throw InputError("the phantom " + sized.name +
                     " has no volume to write (only its surface was made, or it is a sheet without "
                     "a lumen). Use --format surface");
  make_folder(folder);
  fs::path written;
  switch (format) {
    case PhantomFormat::dicom:
    case PhantomFormat::xray_3d:
      written = folder / "dicom";
      write_dicom(phantom, sized, format, written);
      break;
    case PhantomFormat::nrrd:
      written = folder / "volume.nrrd";
      formats::write_nrrd(written, phantom.volume, formats::NrrdEncoding::raw);
      break;
    case PhantomFormat::surface:
      written = folder / "lumen.stl";
      formats::write_surface(written, {phantom.surface, {}, {}});
      break;
  }
  write_text_atomically(folder / "truth.json", as_text(truth_json(phantom, sized)));
  return written;
}

fs::path write_rotational_run(const RotationalRunOfPhantom& run, const PhantomOptions& options,
                              const fs::path& folder) {
  const PhantomOptions sized = detail::with_size(options);
  const Json of_run = json_from(run);
  const std::string origin = fingerprint(sized, {}) + " " + of_run.dump();
  make_folder(folder);
  const std::size_t views = run.options.views.size();
  const fs::path written = folder / (views == 0 ? "run" : "xa_views");
  write_folder(written, [&](const fs::path& temporary) {
    for (std::size_t v = 0; v < views; ++v)
      detail::write_xa_run(run, run.pictures, sized.name, origin, int(v) + 1, true,
                           temporary / fmt::format("IM{:04}.dcm", v + 1),
                           v * std::size_t(run.options.frames));
    if (views > 0) return;
    const int number = run.masks.empty() ? 1 : 2;
    detail::write_xa_run(run, run.pictures, sized.name, origin, number, true,
                         temporary / "IM0001.dcm");
    if (!run.masks.empty())
      detail::write_xa_run(run, run.masks, sized.name, origin, 1, false, temporary / "IM0002.dcm");
  });
  Json truth = truth_json(run.phantom, sized);
  truth["run"] = of_run;
  truth["options"]["noise_sd"] = of_run.at("noise");  // not the volume's
  truth["units"]["noise_sd"] = "fraction of a pixel behind the body";
  write_text_atomically(folder / "truth.json", as_text(truth));
  return written;
}

}  // namespace angio::datasets
