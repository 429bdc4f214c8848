#include "pipeline/cli/convert_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <optional>

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "formats/case_file.hpp"
#include "formats/files.hpp"
#include "formats/gltf.hpp"
#include "formats/nrrd.hpp"
#include "formats/volume_files.hpp"
#include "pipeline/case/dicom_folder.hpp"
#include "pipeline/case/input_kind.hpp"
#include "pipeline/case/slicer_folder.hpp"
#include "pipeline/cli/data_commands.hpp"
#include "pipeline/cli/stale_note.hpp"
#include "pipeline/config/config.hpp"
#include "pipeline/stages/reporter.hpp"
#include "segmentation/read_volume.hpp"
#include "viewer/case_scene.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
namespace {

enum class Kind { surface, volume, scene };

bool is_nifti(const fs::path& output) {
  const std::string name = output.filename().string();
  return name.ends_with(".nii.gz") || name.ends_with(".NII.GZ");
}

void write_volume(const fs::path& output, const Volume<float>& volume) {
  if (is_nifti(output))
    formats::write_nifti(output, volume);
  else if (lower_extension(output) == ".mha")
    formats::write_mha(output, volume);
  else
    formats::write_nrrd(output, volume);
}

/// A report on paper, of a case.
bool is_pdf(const fs::path& output) { return lower_extension(output) == ".pdf"; }

/// By the ending. @throws Error (64) naming the endings that work
Kind output_kind(const fs::path& output) {
  const std::string extension = lower_extension(output);
  if (extension == ".stl" || extension == ".ply" || extension == ".vtp" || extension == ".obj")
    return Kind::surface;
  if (extension == ".nrrd" || extension == ".mha" || is_nifti(output)) return Kind::volume;
  if (is_pdf(output) || extension == ".gltf" || extension == ".glb") return Kind::scene;
  throw Error(ExitCode::usage,
              "nothing can be written as " + output.filename().string() +
                  " (the ending names no format known here). Give .stl, .ply, .vtp or .obj for a "
                  "surface, .nrrd, .mha or .nii.gz for a volume, .glb, .gltf or .pdf for a case");
}

Kind kind_of_input(const std::string& input) {
  if (fs::exists(fs::path(input) / formats::case_file::kRun)) return Kind::scene;
  return input_kind(input) == InputKind::surface ? Kind::surface : Kind::volume;
}

std::optional<LengthUnit> unit_of(const ConvertArguments& a) {
  Config config;
  if (!a.unit.empty()) apply_setting(config, "input.unit=" + a.unit);
  return config.surface_unit;
}

/// In millimetres, as everything that is written.
void convert_surface(const ConvertArguments& a) {
  formats::SurfaceData surface = formats::read_surface(a.input);
  const std::optional<LengthUnit> given = unit_of(a);
  if (const auto unit = given ? given : surface.unit)
    for (Vec3& point : surface.mesh.vertices) point = kMillimetresOf[int(*unit)] * point;
  formats::write_surface(a.output, surface);
}

void convert_volume(const ConvertArguments& a, Reporter& reporter) {
  segmentation::ReadOptions options;
  options.unit = unit_of(a);
  const auto loaded = segmentation::read_volume(a.input, options, reporter.progress());
  for (const std::string& warning : loaded.warnings) reporter.warn("convert", warning);
  write_volume(a.output, loaded.volume);
}

void require_case(const ConvertArguments& a) {
  if (kind_of_input(a.input) != Kind::scene)
    throw Error(ExitCode::usage,
                fmt::format("{} is no case (--to {} writes one). Give the folder of `angio run`",
                            a.input, a.to));
}

int convert_to_dicom(const ConvertArguments& a, Reporter& reporter) {
  require_case(a);
  reporter.begin_stage("convert");
  for (const fs::path& file :
       write_dicom_folder(a.input, a.output, a.keep_link ? DicomLink::source : DicomLink::none,
                          reporter.progress()))
    reporter.result(file.string());
  return int(ExitCode::done);
}

int convert_for_slicer(const ConvertArguments& a, Reporter& reporter) {
  require_case(a);
  for (const fs::path& file : write_slicer_folder(a.input, a.output))
    reporter.result(file.string());
  return int(ExitCode::done);
}

constexpr const char* kWords[] = {"a surface", "a volume", "a case"};
constexpr const char* kEndings[] = {".stl, .ply, .vtp or .obj", ".nrrd, .mha or .nii.gz",
                                    ".glb, .gltf or .pdf"};

}  // namespace

CLI::App& add_convert_command(CLI::App& app, ConvertArguments& a) {
  CLI::App& command = *app.add_subcommand(
      "convert",
      "a surface, a volume or a case into another format: .stl .ply .vtp .obj of a\n"
      "surface, .nrrd .mha .nii.gz of a volume or DICOM, .glb .gltf (moving) or .pdf (the report) "
      "of a case");
  command.add_option("IN", a.input, "a surface, volume, DICOM folder or case")->required();
  command.add_option("OUT", a.output, "the file to be written; its ending says the format")
      ->required();
  command
      .add_option("--to", a.to,
                  "slicer: a case as a folder for 3D Slicer, lumen.seg.nrrd and centerlines.vtp;\n"
                  "dicom: a case as DICOM objects, report.dcm, measurements.dcm and lumen.dcm")
      ->check(CLI::IsMember({"slicer", "dicom"}));
  command.add_flag("--keep-link", a.keep_link,
                   "of --to dicom: under the scan's patient and study, with references to its "
                   "images (the case was run with --keep-link)");
  add_unit_option(command, a.unit);
  add_output_options(command, a.shared);
  return command;
}

int do_convert(const ConvertArguments& a) {
  Reporter reporter(a.shared.style());
  if (a.keep_link && a.to != "dicom")
    throw Error(ExitCode::usage, "--keep-link is for --to dicom. Leave it out");
  if (!a.unit.empty() && kind_of_input(a.input) == Kind::scene)
    throw Error(ExitCode::usage, "--unit is for a surface or a volume file. Leave it out");
  if (a.to == "dicom") return convert_to_dicom(a, reporter);
  if (a.to == "slicer") return convert_for_slicer(a, reporter);
  const Kind wanted = output_kind(a.output), given = kind_of_input(a.input);
  if (wanted != given)
    throw Error(
        ExitCode::usage,
        fmt::format("{} is {}, which cannot be written as {}. Give a name ending in {}", a.input,
                    kWords[int(given)], a.output.filename().string(), kEndings[int(given)]));
  reporter.begin_stage("convert");
  switch (wanted) {
    case Kind::surface:
      convert_surface(a);
      break;
    case Kind::volume:
      convert_volume(a, reporter);
      break;
    case Kind::scene:
      note_if_stale(a.input, reporter);
      if (is_pdf(a.output))
        write_case_pdf(a.input, a.output);
      else
        formats::write_gltf(a.output, viewer::read_case_scene(a.input, reporter.progress()));
      break;
  }
  reporter.result(a.output.string());
  return int(ExitCode::done);
}

}  // namespace angio::pipeline
