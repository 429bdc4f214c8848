#include "pipeline/data_commands.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/error.hpp"
#include "core/triangle_mesh.hpp"
#include "pipeline/stage_work.hpp"
#include "segmentation/read_volume.hpp"
#include "viewer/files.hpp"

namespace angio::pipeline {
namespace {

nlohmann::json to_json(const segmentation::SeriesSummary& s) {
  const auto& g = s.geometry;
  return {{"key", s.key},
          {"kind", s.kind},
          {"transfer_syntax", s.transfer_syntax},
          {"files", s.file_count},
          {"frames", s.frame_count},
          {"size", {g.size[0], g.size[1], g.size[2]}},
          {"spacing_mm", {g.spacing.x, g.spacing.y, g.spacing.z}},
          {"usable", s.usable},
          {"verdict", s.verdict}};
}

int inspect_surface(const std::string& input, bool as_json) {
  const TriangleMesh mesh = viewer::read_surface(input).mesh;
  const SurfaceTopology topology = surface_topology(mesh);
  if (as_json)
    fmt::print("{}\n", nlohmann::json{{"kind", "lumen surface"},
                                      {"vertices", mesh.vertices.size()},
                                      {"triangles", mesh.triangles.size()},
                                      {"components", topology.component_count},
                                      {"boundary_edges", topology.boundary_edge_count},
                                      {"non_manifold_edges", topology.nonmanifold_edge_count},
                                      {"usable", true}}
                           .dump(2));
  else
    fmt::print("lumen surface: {} triangles, {} vertices, {} piece(s), {}, {} non-manifold edges\n",
               mesh.triangles.size(), mesh.vertices.size(), topology.component_count,
               topology.boundary_edge_count == 0 ? "closed" : "open",
               topology.nonmanifold_edge_count);
  return int(ExitCode::done);
}

}  // namespace

int do_inspect(const std::string& input, bool as_json) {
  const InputKind kind = input_kind(input);
  if (kind == InputKind::surface) return inspect_surface(input, as_json);
  if (kind == InputKind::phantom)
    throw Error(ExitCode::usage, "a phantom has nothing to inspect. See `angio phantom --help`");
  const std::vector<segmentation::SeriesSummary> all = segmentation::inspect(input);
  if (as_json) {
    nlohmann::json list = nlohmann::json::array();
    for (const auto& series : all) list.push_back(to_json(series));
    fmt::print("{}\n", nlohmann::json{{"series", list}}.dump(2));
    return int(ExitCode::done);
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto& s = all[i];
    const auto& g = s.geometry;
    fmt::print("{}  {}  {}, {} file(s), {} frame(s), {}\n", i + 1, s.key, s.kind, s.file_count,
               s.frame_count, s.transfer_syntax);
    if (s.usable)
      fmt::print("   {} x {} x {} voxels of {:.4g} x {:.4g} x {:.4g} mm\n", g.size[0], g.size[1],
                 g.size[2], g.spacing.x, g.spacing.y, g.spacing.z);
    fmt::print("   {}: {}\n", s.usable ? "usable" : "refused", s.verdict);
  }
  return int(ExitCode::done);
}

void add_phantom_command(CLI::App& app, PhantomArguments& phantom) {
  CLI::App& command = *app.add_subcommand(
      "phantom",
      "a phantom with its truth\n"
      "NAME: straight, concentric, unilateral, bilateral, tandem, helix, torus,\n"
      "ytype, trifurcation, aneurysm, coronary or cloth");
  auto& o = phantom.options;
  command.add_option("NAME", o.name, "which phantom")->required();
  command.add_option("-o,--output", phantom.folder, "folder to write into")->required();
  command
      .add_option("--format", phantom.format,
                  "dicom (CT series), xray3d (X-Ray 3D Angiographic DICOM), nrrd or surface")
      ->check(CLI::IsMember({"dicom", "xray3d", "nrrd", "surface"}))
      ->capture_default_str();
  command.add_option("--stenosis", o.stenosis_percent, "diameter stenosis [%], 0 to 95")
      ->capture_default_str();
  command.add_option("--radius", o.radius_mm, "at the inlet [mm], 0.4 to 15; 0: the phantom's own")
      ->capture_default_str();
  command
      .add_option("--length", o.length_mm,
                  "of the main branch [mm], 5 to 200; 0: the phantom's own")
      ->capture_default_str();
  command.add_option("--spacing", o.spacing_mm, "voxel size [mm], 0.05 to 2")
      ->capture_default_str();
  command
      .add_option("--noise", o.noise_sd, "standard deviation as a fraction of the contrast, 0 to 1")
      ->capture_default_str();
  command
      .add_option("--blur", o.blur_mm,
                  "standard deviation of the scanner's blur [mm], 0 to 3; 0: 0.6 voxels")
      ->capture_default_str();
  command
      .add_option("--oblique", o.oblique_degrees,
                  "turn of the voxel grid around (1, 2, 3) [degrees], 0 to 90")
      ->capture_default_str();
  command.add_option("--seed", o.seed, "of the noise")->capture_default_str();
}

int do_phantom(const PhantomArguments& arguments) {
  using datasets::PhantomFormat;
  const PhantomFormat format = arguments.format == "nrrd"      ? PhantomFormat::nrrd
                               : arguments.format == "xray3d"  ? PhantomFormat::xray_3d
                               : arguments.format == "surface" ? PhantomFormat::surface
                                                               : PhantomFormat::dicom;
  try {
    arguments.options.validate();
  } catch (const OptionError& error) {  // on the command line, not in a configuration
    throw Error(ExitCode::usage, error.what());
  }
  const datasets::Phantom phantom = format == PhantomFormat::surface
                                        ? datasets::make_phantom_surface(arguments.options)
                                        : datasets::make_phantom(arguments.options);
  const std::filesystem::path written =
      datasets::write_phantom(phantom, arguments.options, format, arguments.folder);
  fmt::print("{}\n", written.string());
  return int(ExitCode::done);
}

}  // namespace angio::pipeline
