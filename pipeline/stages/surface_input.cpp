#include "pipeline/stages/surface_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/error.hpp"
#include "datasets/phantom.hpp"
#include "formats/case_file.hpp"
#include "formats/files.hpp"
#include "meshing/meshing.hpp"
#include "pipeline/case/doubts.hpp"
#include "pipeline/case/input_kind.hpp"
#include "pipeline/case/tell.hpp"

namespace angio::pipeline {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

const char* unit_name(LengthUnit unit) { return kLengthUnitNames[int(unit)]; }

std::string options_of(const std::vector<LengthUnit>& units) {
  std::string text;
  for (const LengthUnit unit : units)
    text += (text.empty() ? "--unit " : " or --unit ") + std::string(unit_name(unit));
  return text;
}

/// Sets unit, source and warnings; the size is still in the file's unit.
void choose_unit(GivenSurface& given, std::optional<LengthUnit> stated,
                 std::optional<LengthUnit> asked) {
  const meshing::UnitGuess guess = meshing::guess_unit(given.size);
  const auto words = [&](LengthUnit unit) { return meshing::size_in_words(given.size, unit); };
  const auto warn = [&](std::string text) { given.warnings.push_back(std::move(text)); };
  if (asked || stated) {
    given.unit = asked ? *asked : *stated;
    given.unit_source = asked ? "option" : "file";
    const char* name = unit_name(given.unit);
    if (asked && stated && *asked != *stated)
      warn(fmt::format("the file says that it is in {}; it is read in {}", unit_name(*stated),
                       name));
    if (guess.is_vessel && !meshing::is_possible(given.size, given.unit))
      warn(
          fmt::format("read in {}, as {}: {}. No scan shows such a vessel; in {} it would be {}: "
                      "add --unit {} if so",
                      name, asked ? "asked" : "the file says", words(given.unit),
                      unit_name(guess.unit), words(guess.unit), unit_name(guess.unit)));
    else if (!asked && given.unit != LengthUnit::mm)
      warn(fmt::format("read in {}, as the file says: {}", name, words(given.unit)));
    return;
  }
  constexpr double kLeastSeenMm = 0.3;  // of a vessel's diameter
  given.unit = guess.unit;
  given.unit_source = guess.is_vessel ? "size" : "default";
  const std::string read = fmt::format("{}; it is read in {}: {}. ", kUnitGuessed,
                                       unit_name(guess.unit), words(guess.unit));
  if (!guess.others.empty())
    warn(read + fmt::format("In {} it would be {}: add {} if so", unit_name(guess.others.front()),
                            words(guess.others.front()), options_of(guess.others)));
  else if (guess.unit != LengthUnit::mm && given.size.median < kLeastSeenMm)
    warn(read +
         fmt::format("In mm {} ({}). --unit says otherwise", kOnlyUnit, words(LengthUnit::mm)));
  else if (guess.unit != LengthUnit::mm)
    warn(read + fmt::format("In mm it would be smaller than what is scanned ({}): add --unit mm if "
                            "it is",
                            words(LengthUnit::mm)));
}

/// @throws InputError if no vessel is that small or large
void check_extent(const GivenSurface& given) {
  // From one short coronary segment to an aorta with the arteries of both legs.
  constexpr double kLeastMm = 3.0, kMostMm = 2000.0;
  const double in_file = given.size.extent;
  const double extent = in_file * kMillimetresOf[int(given.unit)];
  if (extent >= kLeastMm && extent <= kMostMm) return;
  std::vector<LengthUnit> fitting;
  for (std::size_t u = 0; u < std::size(kLengthUnitNames); ++u)
    if (in_file * kMillimetresOf[u] >= kLeastMm && in_file * kMillimetresOf[u] <= 500.0)
      fitting.push_back(LengthUnit(u));
  throw InputError(fmt::format(
      "the surface is {:.3g} mm across, read in {} (vessels are {} to {} mm long). {}", extent,
      unit_name(given.unit), kLeastMm, kMostMm,
      fitting.empty() ? "Check what it was exported from" : "Try " + options_of(fitting)));
}

void scale(GivenSurface& given, double factor) {
  if (factor == 1.0) return;
  for (Vec3& vertex : given.mesh.vertices) vertex *= factor;
  for (meshing::SurfaceRepair& repair : given.repairs) repair.scale(factor);
  given.size.scale(factor);
}

/// Of a surface around a vessel's wall, its inner side.
void take_lumen_of_wall(GivenSurface& given) {
  constexpr double kLeastInside = 0.02;
  if (!meshing::is_wall(given.size)) return;
  const double share = given.size.hollow_share;
  const double wall_volume = given.size.volume;
  meshing::RepairedSurface lumen = meshing::repair_surface(meshing::lumen_of_wall(given.mesh));
  given.mesh = std::move(lumen.mesh);
  given.repairs.insert(given.repairs.end(), lumen.repairs.begin(), lumen.repairs.end());
  given.size = meshing::measure_surface(given.mesh);
  if (given.mesh.triangles.empty() || given.size.volume < kLeastInside * wall_volume ||
      meshing::is_wall(given.size))
    throw InputError(
        fmt::format("the surface is that of a vessel's wall ({:.0f} % of it faces a hollow inside "
                    "it), and no lumen was found in it. Give the lumen's own surface",
                    100.0 * share));
  given.warnings.push_back(
      fmt::format("the surface is that of a vessel's wall: {:.0f} % of it faces a hollow inside "
                  "it. That inner side is taken for the lumen",
                  100.0 * share));
}

GivenSurface settle(const formats::SurfaceData& surface, std::optional<LengthUnit> asked) {
  GivenSurface given;
  meshing::RepairedSurface repaired = meshing::repair_surface(surface.mesh);
  given.mesh = std::move(repaired.mesh);
  given.repairs = std::move(repaired.repairs);
  given.size = meshing::measure_surface(given.mesh);
  take_lumen_of_wall(given);
  choose_unit(given, surface.unit, asked);
  check_extent(given);
  scale(given, kMillimetresOf[int(given.unit)]);
  return given;
}

/// What a file holds, before it is repaired.
struct RawCounts {
  std::size_t vertices = 0, triangles = 0, crossings = 0;
  SurfaceTopology topology;
};

json to_json(const Vec3& v) { return json::array({v.x, v.y, v.z}); }

json rims_json(const std::vector<SurfaceRim>& rims) {
  json list = json::array();
  for (const SurfaceRim& rim : rims)
    list.push_back({{"centre_mm", to_json(rim.centre)},
                    {"normal", to_json(rim.normal)},
                    {"diameter_mm", rim.diameter_mm},
                    {"unevenness_mm", rim.unevenness_mm}});
  return list;
}

json inspection_json(const RawCounts& raw, const GivenSurface* given, const std::string& verdict) {
  json out = {{"kind", "lumen surface"},
              {"vertices", raw.vertices},
              {"triangles", raw.triangles},
              {"components", raw.topology.component_count},
              {"boundary_edges", raw.topology.boundary_edge_count},
              {"non_manifold_edges", raw.topology.nonmanifold_edge_count},
              {"self_intersections", raw.crossings},
              {"closed", raw.topology.is_closed()},
              {"usable", given != nullptr},
              {"verdict", verdict}};
  if (!given) return out;
  json repairs = json::array();
  for (const auto& repair : given->repairs)
    if (!repair.is_routine) repairs.push_back(to_text(repair));
  const meshing::SurfaceSize& size = given->size;
  out.update({{"unit", unit_name(given->unit)},
              {"unit_source", given->unit_source},
              {"low_mm", to_json(size.low)},
              {"high_mm", to_json(size.high)},
              {"volume_mm3", size.volume},
              {"area_mm2", size.area},
              {"thin_diameter_mm", size.thin},
              {"median_diameter_mm", size.median},
              {"wide_diameter_mm", size.wide},
              {"hollow_share", size.hollow_share},
              {"open_ends", rims_json(size.rims)},
              {"repairs", repairs},
              {"warnings", given->warnings}});
  return out;
}

const char* source_in_words(const std::string& unit_source) {
  if (unit_source == "option") return "--unit";
  if (unit_source == "file") return "stated in the file";
  if (unit_source == "size") return "by its size; the file does not say";
  return "assumed; the file does not say";
}

void print_inspection(const RawCounts& raw, const GivenSurface* given, const std::string& verdict) {
  tell(
      "lumen surface: {} triangles, {} vertices, {} piece(s), {}, {} non-manifold edges, {} "
      "crossings",
      raw.triangles, raw.vertices, raw.topology.component_count,
      raw.topology.boundary_edge_count == 0 ? "closed" : "open",
      raw.topology.nonmanifold_edge_count, raw.crossings);
  if (given) {
    const meshing::SurfaceSize& size = given->size;
    const Vec3 sides = size.high - size.low;
    tell("   unit: {} ({})", unit_name(given->unit), source_in_words(given->unit_source));
    tell("   {:.1f} x {:.1f} x {:.1f} mm, from ({:.1f}, {:.1f}, {:.1f}) mm; {:.4g} mm3", sides.x,
         sides.y, sides.z, size.low.x, size.low.y, size.low.z, size.volume);
    tell("   diameter: {:.2f} mm thin, {:.2f} mm median, {:.2f} mm wide", size.thin, size.median,
         size.wide);
    tell("   {} open end(s)", size.rims.size());
    int number = 0;
    for (const SurfaceRim& rim : size.rims)
      tell("      {}: {:.2f} mm at ({:.1f}, {:.1f}, {:.1f}) mm", ++number, rim.diameter_mm,
           rim.centre.x, rim.centre.y, rim.centre.z);
  }
  tell("   {}: {}", given ? "usable" : "refused", verdict);
  if (!given) return;
  for (const auto& repair : given->repairs)
    if (!repair.is_routine) tell("   repair: {}", to_text(repair));
  for (const std::string& warning : given->warnings) tell("   note: {}", warning);
}

/// The lumen surface that an experiment of the seed paper's begins with.
TriangleMesh exact_surface(StageWork& work) {
  const datasets::PhantomOptions options = datasets::parse_phantom(work.input);
  const bool is_coronary = options.name == "coronary";
  if (is_coronary)
    work.warnings.emplace_back(
        "no INPUT was given: the vessel is a generated coronary, not a patient's");
  TriangleMesh surface = is_coronary ? datasets::make_phantom_surface(options).surface
                                     : datasets::make_paper_surface(options);
  work.input_description = fmt::format("the seed paper's experiment, {} vessel",
                                       is_coronary ? "generated coronary" : options.name.c_str());
  return surface;
}

}  // namespace

GivenSurface read_given_surface(const fs::path& file, std::optional<LengthUnit> asked) {
  return settle(formats::read_surface(file), asked);
}

void take_surface(StageWork& work, std::optional<LengthUnit> unit) {
  const fs::path kept = work.out / "lumen_surface.vtp";
  if (work.input.starts_with(kPhantomPrefix))
    return formats::write_surface(kept, {exact_surface(work), {}, {}});
  if (work.input.empty()) {
    const fs::path source = work.files.path(formats::case_file::kGivenLumen);
    return formats::write_surface(kept, {formats::read_surface(source).mesh, {}, {}});
  }
  const formats::SurfaceData surface = formats::read_surface(work.input);
  work.input_description =
      fmt::format("lumen surface, {} triangles", surface.mesh.triangles.size());
  const GivenSurface given = settle(surface, unit);
  work.warnings.insert(work.warnings.end(), given.warnings.begin(), given.warnings.end());
  for (const meshing::SurfaceRepair& repair : given.repairs)
    if (!repair.is_routine) work.warnings.push_back(std::string(kRepaired) + to_text(repair));
  formats::write_surface(kept, {given.mesh, {}, {}});
}

void inspect_surface(const fs::path& file, std::optional<LengthUnit> asked, bool as_json) {
  const formats::SurfaceData surface = formats::read_surface(file);
  const RawCounts raw{surface.mesh.vertices.size(), surface.mesh.triangles.size(),
                      std::size_t(meshing::count_self_intersections(surface.mesh)),
                      surface_topology(surface.mesh)};
  std::optional<GivenSurface> given;
  std::string verdict = "a lumen surface";
  try {
    given = settle(surface, asked);
  } catch (const InputError& error) {
    verdict = error.what();
  }
  if (as_json)
    fmt::print("{}\n", inspection_json(raw, given ? &*given : nullptr, verdict).dump(2));
  else
    print_inspection(raw, given ? &*given : nullptr, verdict);
  if (!given) throw InputError(verdict);
}

}  // namespace angio::pipeline
