#include <fmt/format.h>
#include <toml++/toml.h>

#include <array>
#include <cmath>
#include <sstream>

#include "core/error.hpp"
#include "pipeline/config.hpp"

// The table of all settings, and how each kind of field stands in TOML.
namespace angio::pipeline {
namespace {

[[noreturn]] void refuse_value(const std::string& key, const std::string& value,
                               const char* expected) {
  throw OptionError(
      fmt::format("{} = {} cannot be used (expected {}). See `angio run --print-config`", key,
                  value, expected));
}
// ---- one field <-> TOML --------------------------------------------------------------------

double number_of(const std::string& key, const toml::node& node) {
  const auto value = node.value<double>();
  if (!value || !std::isfinite(*value)) {
    std::ostringstream text;
    text << toml::node_view<const toml::node>(node);
    refuse_value(key, text.str(), "a number");
  }
  return *value;
}

Vec3 point_of(const std::string& key, const toml::node& node) {
  const toml::array* array = node.as_array();
  if (!array || array->size() != 3) refuse_value(key, "this value", "a point [x, y, z] in LPS mm");
  return {number_of(key, (*array)[0]), number_of(key, (*array)[1]), number_of(key, (*array)[2])};
}

void read_field(const std::string& key, const toml::node& node, double& field) {
  field = number_of(key, node);
}
void read_field(const std::string& key, const toml::node& node, int& field) {
  const double number = number_of(key, node);
  if (number != std::floor(number) || std::abs(number) > 1e9)
    refuse_value(key, fmt::format("{}", number), "a whole number");
  field = int(number);
}
void read_field(const std::string& key, const toml::node& node, bool& field) {
  if (!node.is_boolean()) refuse_value(key, "this value", "true or false");
  field = node.as_boolean()->get();
}
void read_field(const std::string& key, const toml::node& node, std::string& field) {
  if (!node.is_string()) refuse_value(key, "this value", "a text");
  field = node.as_string()->get();
}
void read_field(const std::string& key, const toml::node& node, std::optional<double>& field) {
  if (node.is_string() && node.as_string()->get() == "auto")
    field.reset();
  else
    field = number_of(key, node);
}
void read_field(const std::string& key, const toml::node& node, std::optional<Vec3>& field) {
  if (node.is_string() && node.as_string()->get() == "auto")
    field.reset();
  else
    field = point_of(key, node);
}
void read_field(const std::string& key, const toml::node& node, std::array<double, 3>& field) {
  const Vec3 values = point_of(key, node);
  field = {values.x, values.y, values.z};
}
void read_field(const std::string& key, const toml::node& node,
                std::optional<segmentation::LpsBox>& field) {
  if (node.is_string() && node.as_string()->get() == "auto") return field.reset();
  const toml::array* array = node.as_array();
  if (!array || array->size() != 2)
    refuse_value(key, "this value", "two corners [[x, y, z], [x, y, z]] in LPS mm, or \"auto\"");
  field = {point_of(key, (*array)[0]), point_of(key, (*array)[1])};
}
void read_field(const std::string& key, const toml::node& node, std::vector<double>& field) {
  const toml::array* array = node.as_array();
  if (!array) refuse_value(key, "this value", "a list of numbers [1, 2, ...]");
  field.clear();
  for (const toml::node& element : *array) field.push_back(number_of(key, element));
}
void read_field(const std::string& key, const toml::node& node, std::vector<Vec3>& field) {
  const toml::array* array = node.as_array();
  if (!array) refuse_value(key, "this value", "a list of points [[x, y, z], ...] in LPS mm");
  field.clear();
  for (const toml::node& element : *array) field.push_back(point_of(key, element));
}

void read_field(const std::string& key, const toml::node& node,
                std::vector<simulation::ChartPoint>& field) {
  constexpr const char* kExpected = "a list of points [[atm, mm], ...]";
  const toml::array* array = node.as_array();
  if (!array) refuse_value(key, "this value", kExpected);
  field.clear();
  for (const toml::node& element : *array) {
    const toml::array* point = element.as_array();
    if (!point || point->size() != 2) refuse_value(key, "this value", kExpected);
    field.push_back({number_of(key, (*point)[0]), number_of(key, (*point)[1])});
  }
}

constexpr const char* kMembraneModels[] = {"automatic", "plain", "relaxed"};

/// One of an enumeration's names.
template <class Enum, std::size_t kCount>
void read_name(const std::string& key, const toml::node& node, const char* const (&names)[kCount],
               Enum& field) {
  const std::string text = node.value_or(std::string());
  std::string expected;
  for (std::size_t i = 0; i < kCount; ++i) {
    if (text == names[i]) {
      field = Enum(i);
      return;
    }
    expected += (i == 0 ? "" : i + 1 == kCount ? " or " : ", ") + std::string(names[i]);
  }
  refuse_value(key, text, expected.c_str());
}
void read_field(const std::string& key, const toml::node& node, simulation::MembraneModel& field) {
  read_name(key, node, kMembraneModels, field);
}
constexpr const char* kWallShapes[] = {"linear", "quadratic"};
void read_field(const std::string& key, const toml::node& node, simulation::WallShape& field) {
  read_name(key, node, kWallShapes, field);
}
constexpr const char* kWallModels[] = {"shape_matching", "layered"};
void read_field(const std::string& key, const toml::node& node, simulation::WallModel& field) {
  read_name(key, node, kWallModels, field);
}
constexpr const char* kPlaques[] = {"fibrous", "hypocellular", "calcified"};
void read_field(const std::string& key, const toml::node& node, simulation::Plaque& field) {
  read_name(key, node, kPlaques, field);
}
constexpr const char* kContactModels[] = {"barrier", "paper"};
void read_field(const std::string& key, const toml::node& node, simulation::ContactModel& field) {
  read_name(key, node, kContactModels, field);
}
constexpr const char* kGasModels[] = {"enclosed", "per_tet"};
void read_field(const std::string& key, const toml::node& node, simulation::GasModel& field) {
  read_name(key, node, kGasModels, field);
}
constexpr const char* kGuidewires[] = {"none", "rod"};
void read_field(const std::string& key, const toml::node& node, simulation::GuidewireModel& field) {
  read_name(key, node, kGuidewires, field);
}
constexpr const char* kGuidewireRests[] = {"straight", "placed"};
void read_field(const std::string& key, const toml::node& node, simulation::GuidewireRest& field) {
  read_name(key, node, kGuidewireRests, field);
}
constexpr const char* kGuidewireTips[] = {"held", "free"};
void read_field(const std::string& key, const toml::node& node, simulation::GuidewireTip& field) {
  read_name(key, node, kGuidewireTips, field);
}
constexpr const char* kControls[] = {"gas", "pressure", "volume"};
void read_field(const std::string& key, const toml::node& node,
                simulation::InflationControl& field) {
  read_name(key, node, kControls, field);
}
constexpr const char* kClothSolvers[] = {"newton", "vbd"};
void read_field(const std::string& key, const toml::node& node, simulation::ClothSolver& field) {
  read_name(key, node, kClothSolvers, field);
}
constexpr const char* kAngleNames[] = {"from-base", "cumulative"};
void read_field(const std::string& key, const toml::node& node,
                segmentation::AngleIncrements& field) {
  read_name(key, node, kAngleNames, field);
}
void read_field(const std::string& key, const toml::node& node, std::optional<LengthUnit>& field) {
  if (node.is_string() && node.as_string()->get() == "auto") return field.reset();
  LengthUnit unit = LengthUnit::mm;
  read_name(key, node, kLengthUnitNames, unit);
  field = unit;
}

std::string quoted(const std::string& text) {
  std::ostringstream out;
  out << toml::value<std::string>(text);
  return out.str();
}
std::string write_field(double field) {
  const std::string text = fmt::format("{}", field);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}
std::string write_field(int field) { return fmt::format("{}", field); }
std::string write_field(bool field) { return field ? "true" : "false"; }
std::string write_field(const std::string& field) { return quoted(field); }
std::string write_field(simulation::MembraneModel field) {
  return quoted(kMembraneModels[int(field)]);
}
std::string write_field(simulation::ContactModel field) {
  return quoted(kContactModels[int(field)]);
}
std::string write_field(simulation::GasModel field) { return quoted(kGasModels[int(field)]); }
std::string write_field(simulation::GuidewireModel field) {
  return quoted(kGuidewires[int(field)]);
}
std::string write_field(simulation::GuidewireRest field) {
  return quoted(kGuidewireRests[int(field)]);
}
std::string write_field(simulation::GuidewireTip field) {
  return quoted(kGuidewireTips[int(field)]);
}
std::string write_field(simulation::WallModel field) { return quoted(kWallModels[int(field)]); }
std::string write_field(simulation::Plaque field) { return quoted(kPlaques[int(field)]); }
std::string write_field(simulation::WallShape field) { return quoted(kWallShapes[int(field)]); }
std::string write_field(simulation::InflationControl field) {
  return quoted(kControls[int(field)]);
}
std::string write_field(simulation::ClothSolver field) { return quoted(kClothSolvers[int(field)]); }
std::string write_field(const std::optional<LengthUnit>& field) {
  return quoted(field ? kLengthUnitNames[int(*field)] : "auto");
}
std::string write_field(const simulation::ChartPoint& field) {
  return fmt::format("[{}, {}]", write_field(field.pressure_atm), write_field(field.diameter_mm));
}
std::string write_field(const Vec3& field) {
  return fmt::format("[{}, {}, {}]", write_field(field.x), write_field(field.y),
                     write_field(field.z));
}
std::string write_field(segmentation::AngleIncrements field) {
  return quoted(kAngleNames[int(field)]);
}
std::string write_field(const std::array<double, 3>& field) {
  return write_field(Vec3{field[0], field[1], field[2]});
}
std::string write_field(const segmentation::LpsBox& field) {
  return fmt::format("[{}, {}]", write_field(field.low), write_field(field.high));
}
template <class Value>
std::string write_field(const std::optional<Value>& field) {
  return field ? write_field(*field) : "\"auto\"";
}
template <class Value>
std::string write_field(const std::vector<Value>& field) {
  std::string text;
  for (const Value& point : field) text += (text.empty() ? "" : ", ") + write_field(point);
  return "[" + text + "]";
}

/// A bare word is a text: `--set balloon.material=pa12` needs no quotes.
toml::table parse_value(const std::string& key, const std::string& value) {
  try {
    return toml::parse("value = " + value);
  } catch (const toml::parse_error&) {
  }
  try {
    return toml::parse("value = " + quoted(value));
  } catch (const toml::parse_error&) {
    refuse_value(key, value, "a TOML value");
  }
}

template <class Field>
Setting make_setting(std::string key, Stage stage, Field& field, std::string help) {
  Setting setting{key, stage, std::move(help), nullptr, nullptr};
  setting.get = [&field] { return write_field(field); };
  setting.set = [&field, key](const std::string& value) {
    const toml::table table = parse_value(key, value);
    read_field(key, *table.get("value"), field);
  };
  return setting;
}

// ---- the table ---------------------------------------------------------------------------------

void add_segmentation_settings(Config& c, std::vector<Setting>& table) {
  const auto seg = Stage::segmentation;
  table.push_back(make_setting("input.experiment", seg, c.experiment,
                               "the seed paper's experiment whose mesh a phantom input gives: "
                               "cloth, unilateral, bilateral, ytype or coronary; \"\": none"));
  table.push_back(
      make_setting("input.series", seg, c.input.series,
                   "series of a DICOM folder: its number or key from `angio inspect`; \"\": "
                   "the one with the most voxels"));
  table.push_back(make_setting("input.allow_lossy", seg, c.input.allow_lossy,
                               "measure on lossy-compressed pixels all the same"));
  table.push_back(make_setting("input.spacing_mm", seg, c.input.spacing_mm,
                               "voxel size between columns, rows and slices [mm] for a scan that "
                               "states none; zeros: refuse it"));
  table.push_back(make_setting("input.resample", seg, c.input.resample,
                               "interpolate missing or unevenly spaced slices"));
  table.push_back(make_setting("input.angles", seg, c.input.angles,
                               "a projection run's angle increments: from-base or cumulative"));
  table.push_back(make_setting("input.max_memory_gib", seg, c.input.max_memory_gib,
                               "refuse a scan that needs more [GiB]; 0: what is free"));
  table.push_back(
      make_setting("input.unit", seg, c.surface_unit,
                   "what a given lumen surface is measured in: mm, cm, m or inch; \"auto\": "
                   "as the file says, otherwise by its size"));
  table.push_back(make_setting("segmentation.smallest_radius_mm", seg,
                               c.segmentation.smallest_radius_mm,
                               "thinnest vessel looked for [mm], 0.1 to 20"));
  table.push_back(make_setting("segmentation.largest_radius_mm", seg,
                               c.segmentation.largest_radius_mm,
                               "widest vessel looked for by its shape [mm], 0.2 to 30"));
  table.push_back(make_setting("segmentation.scale_count", seg, c.segmentation.scale_count,
                               "scales of the vessel enhancement, 1 to 8"));
  table.push_back(make_setting("segmentation.seeds_lps_mm", seg, c.segmentation.seeds_lps_mm,
                               "points inside the vessel, LPS [mm]; []: found automatically"));
  table.push_back(make_setting("segmentation.intensity_min", seg, c.segmentation.intensity_min,
                               "lowest intensity of the lumen [the volume's unit]; \"auto\""));
  table.push_back(make_setting("segmentation.intensity_max", seg, c.segmentation.intensity_max,
                               "highest intensity of the lumen; \"auto\""));
  table.push_back(make_setting("segmentation.exclude_bone", seg, c.segmentation.exclude_bone,
                               "keep out bone, calcification and metal brighter than the vessels"));
  table.push_back(make_setting("segmentation.region_lps_mm", seg, c.segmentation.region_lps_mm,
                               "box [[x, y, z], [x, y, z]] in LPS [mm] in which vessels are looked "
                               "for; \"auto\": everywhere"));
  table.push_back(make_setting("segmentation.min_component_mm3", seg,
                               c.segmentation.min_component_mm3,
                               "smaller pieces are noise [mm3], 0 to 1e6"));
  table.push_back(make_setting("segmentation.labels", seg, c.segmentation.labels,
                               "of a label map: the labels that are lumen; []: all of them"));
}

void add_centerline_settings(Config& c, std::vector<Setting>& table) {
  const auto line = Stage::centerline;
  table.push_back(make_setting("centerline.inlet_lps_mm", line, c.centerline.inlet_lps_mm,
                               "a point at the inlet, LPS [mm]; \"auto\": by the tree's shape"));
  table.push_back(make_setting("centerline.inlet_end", line, c.inlet_end,
                               "of a given surface: the number of the open end that is the inlet, "
                               "as `angio inspect` lists them; 0: not said so"));
  table.push_back(make_setting("centerline.outlets_lps_mm", line, c.centerline.outlets_lps_mm,
                               "points at the outlets, LPS [mm]; []: every other end"));
  table.push_back(make_setting("centerline.step_mm", line, c.centerline.step_mm,
                               "distance of points [mm], up to 5; 0: a quarter of the radius"));
  table.push_back(make_setting("centerline.min_branch_length_mm", line,
                               c.centerline.min_branch_length_mm,
                               "shorter side branches are spurs [mm]; 0: by the parent's radius"));
  table.push_back(make_setting("lesion.narrow_percent", line, c.narrowing.percent,
                               "narrow a vessel without a stenosis (or the place named) by so much "
                               "of its healthy diameter [%], 5 to 100; 0: leave it"));
  table.push_back(make_setting("lesion.narrow_length_mm", line, c.narrowing.length_mm,
                               "of that narrowing [mm], 1 to 100; 0: three diameters"));
}

void add_meshing_settings(Config& c, std::vector<Setting>& table) {
  const auto mesh = Stage::meshing;
  table.push_back(make_setting("lesion.centerline", mesh, c.lesion.centerline,
                               "CenterlineIds of the line to treat; -1: the whole tree"));
  table.push_back(
      make_setting("lesion.abscissa_mm", mesh, c.lesion.abscissa_mm,
                   "place on that line [mm from the inlet]; -1: the tightest stenosis"));
  table.push_back(make_setting("lesion.min_stenosis_percent", mesh, c.lesion.min_stenosis_percent,
                               "less is no stenosis [%], 10 to 90"));
  table.push_back(
      make_setting("mesh.edge_length_mm", mesh, c.lumen_mesh.edge_length_mm,
                   "target edge length of the lumen [mm], up to 5; 0: by the local radius"));
  table.push_back(make_setting("mesh.edges_per_circumference", mesh,
                               c.lumen_mesh.edges_per_circumference,
                               "edges around the lumen where edge_length_mm is 0, 8 to 64"));
  table.push_back(make_setting("mesh.triangle_budget", mesh, c.lumen_mesh.triangle_budget,
                               "most triangles of the lumen, 1000 to 5000000"));
  table.push_back(make_setting("mesh.triangle_count", mesh, c.lumen_mesh.triangle_count,
                               "exact number of triangles, with caps on the outlets, even, 1000 to "
                               "1000000; 0: by the edge length"));
  table.push_back(make_setting("mesh.keep", mesh, c.lumen_mesh.keep,
                               "keep a given surface's triangles; it must be open at its ends"));
  table.push_back(make_setting("mesh.smoothing_iterations", mesh, c.lumen_mesh.smoothing_iterations,
                               "volume-keeping smoothing steps, 0 to 100"));
  table.push_back(make_setting("mesh.extension_diameters", mesh, c.lumen_mesh.extension_diameters,
                               "straight tubes on inlet and outlets [diameters], 0 to 20"));
  table.push_back(make_setting("volume.fill", mesh, c.fill_lumen,
                               "also fill the lumen with tetrahedra (meshing/lumen.vtu)"));
  table.push_back(make_setting("volume.edge_ratio", mesh, c.lumen_volume.edge_ratio,
                               "edges inside over those of the wall, 0.5 to 5"));
  table.push_back(make_setting("volume.tet_budget", mesh, c.lumen_volume.tet_budget,
                               "most tetrahedra of the lumen, 1000 to 50000000"));
  table.push_back(make_setting("volume.least_dihedral_degrees", mesh,
                               c.lumen_volume.least_dihedral_degrees,
                               "sharper tetrahedra are worked on [degrees], 5 to 25"));
  table.push_back(make_setting("balloon.nominal_diameter_mm", mesh, c.balloon.nominal_diameter_mm,
                               "[mm], 0.5 to 30; 0: the reference diameter, to the next 0.25 mm"));
  table.push_back(make_setting("balloon.rest_diameter_mm", mesh, c.balloon.rest_diameter_mm,
                               "of the unloaded balloon [mm], 0.5 to 30; 0: the nominal one"));
  table.push_back(
      make_setting("balloon.length_mm", mesh, c.balloon.length_mm,
                   "of the cylindrical part [mm], 2 to 80; 0: the lesion and 3 mm each side, less "
                   "in a bend"));
  table.push_back(make_setting("balloon.start_diameter_mm", mesh, c.balloon.start_diameter_mm,
                               "crossing profile [mm]; 0: by the diameter (0.9 up to 4 mm), less "
                               "where it must pass"));
  table.push_back(make_setting("balloon.folds", mesh, c.balloon.folds,
                               "flaps wrapped around the shaft at the start: 2, 3 or 5; 0: folds "
                               "are not meshed"));
  table.push_back(make_setting("balloon.shaft_diameter_mm", mesh, c.balloon.shaft_diameter_mm,
                               "of the shaft inside the folds [mm], 0.2 to 10"));
  table.push_back(make_setting("balloon.fold_gap_mm", mesh, c.balloon.fold_gap_mm,
                               "between the folds' layers [mm], 0.005 to 0.5"));
  table.push_back(make_setting("balloon.ring_count", mesh, c.balloon.ring_count,
                               "rings of vertices, 6 to 400"));
  table.push_back(make_setting("balloon.ring_vertex_count", mesh, c.balloon.ring_vertex_count,
                               "vertices a ring, 6 to 200"));
  table.push_back(make_setting("balloon.guidewire_node_count", mesh, c.balloon.guidewire_node_count,
                               "nodes of the guidewire, 2 to 1000"));
}

void add_material_settings(Config& c, std::vector<Setting>& table) {
  const auto sim = Stage::simulation;
  auto& s = c.simulation;
  table.push_back(
      make_setting("balloon.material", sim, s.balloon.name,
                   "pa12 (semi-compliant), pet (non-compliant) or polyurethane (the seed "
                   "paper's)"));
  table.push_back(make_setting("balloon.chart", sim, s.balloon.chart,
                               "compliance chart [[atm, mm], ...] that the skin is made to follow; "
                               "[]: the material as it is"));
  table.push_back(make_setting("balloon.c1_mpa", sim, s.balloon.c1_mpa,
                               "Mooney-Rivlin C1 [MPa]; 0: the material's"));
  table.push_back(make_setting("balloon.c2_mpa", sim, s.balloon.c2_mpa,
                               "Mooney-Rivlin C2 [MPa]; 0: the material's"));
  table.push_back(make_setting("balloon.membrane", sim, s.membrane,
                               "automatic (by the start shape), plain, or relaxed (wrinkles carry "
                               "no compression)"));
  table.push_back(make_setting("balloon.wall_mm", sim, s.balloon.wall_mm,
                               "membrane thickness before inflation [mm], 0.001 to 1; 0: by the "
                               "diameter (0.02 up to 4 mm)"));
  table.push_back(make_setting("balloon.density_g_mm3", sim, s.balloon.density_g_mm3,
                               "[g/mm3]; 0: the material's"));
  table.push_back(make_setting("wall.model", Stage::meshing, s.wall_model,
                               "shape_matching (the lumen's surface, plastic), or layered (a solid "
                               "of intima, media, adventitia and plaque)"));
  table.push_back(make_setting("wall.plaque", sim, c.plaque,
                               "layered: what it is made of: fibrous, hypocellular or calcified"));
  table.push_back(make_setting("wall.axial_stretch", sim, s.layered_wall.axial_stretch,
                               "layered: in place, of the unloaded wall, 0.9 to 1.5"));
  table.push_back(make_setting("wall.layer_fractions", Stage::meshing,
                               c.wall_layers.layer_fractions,
                               "layered: shares of intima, media and adventitia in its thickness"));
  table.push_back(make_setting("wall.elements_per_layer", Stage::meshing,
                               c.wall_layers.elements_per_layer,
                               "layered: elements through each layer, 1 to 8"));
  table.push_back(make_setting("wall.plaque_elements", Stage::meshing,
                               c.wall_layers.plaque_elements,
                               "layered: elements through the plaque, 2 to 16"));
  table.push_back(make_setting("wall.modulus_kpa", sim, s.wall.modulus_kpa,
                               "circumferential modulus of the diseased wall [kPa], 1 to 1e6"));
  table.push_back(make_setting("wall.thickness_ratio", Stage::meshing, s.wall.thickness_ratio,
                               "wall thickness / outer diameter, up to 0.45"));
  table.push_back(make_setting("wall.yield_strain", sim, s.wall.yield_strain,
                               "strain at which plastic flow begins, 0 to 10"));
  table.push_back(make_setting("wall.creep_per_s", sim, s.wall.creep_per_s,
                               "rate of plastic flow [1/s], 0 to 1000"));
  table.push_back(make_setting("wall.max_plastic_strain", sim, s.wall.max_plastic_strain,
                               "most plastic strain, 0 to 10"));
  table.push_back(make_setting("wall.foundation_kpa_per_mm", sim, s.wall.foundation_kpa_per_mm,
                               "stiffness of the surrounding tissue [kPa/mm], 0 to 1e5"));
  table.push_back(make_setting("wall.density_g_mm3", sim, s.wall.density_g_mm3, "[g/mm3]"));
  table.push_back(make_setting("wall.shape", sim, s.wall.shape,
                               "what a slab of wall keeps as its plastic shape: linear (stretched) "
                               "or quadratic (also bent, twisted, unevenly widened)"));
  table.push_back(make_setting("wall.shape_beta", sim, s.wall.shape_beta,
                               "quadratic only: share of bending and twist that costs nothing, 0 "
                               "to 1"));
}

void add_guidewire_settings(Config& c, std::vector<Setting>& table) {
  const auto sim = Stage::simulation;
  simulation::GuidewireOptions& g = c.simulation.guidewire;
  table.push_back(
      make_setting("guidewire.model", sim, g.model,
                   "none (it holds the balloon's ends), or rod (elastic, it bends in the "
                   "balloon and meets it)"));
  table.push_back(make_setting("guidewire.rest", sim, g.rest,
                               "rod: its unloaded shape, straight or placed (as it lies)"));
  table.push_back(
      make_setting("guidewire.tip", sim, g.tip, "rod: held in its place and direction, or free"));
  table.push_back(make_setting("guidewire.shaft_modulus_mpa", sim, g.shaft_modulus_mpa,
                               "rod: of the shaft around the wire [MPa], 1 to 1e6"));
  table.push_back(make_setting("guidewire.wire_diameter_mm", sim, g.wire_diameter_mm,
                               "rod: and of the shaft's bore [mm], 0.05 to 0.95 of the shaft"));
  table.push_back(make_setting("guidewire.wire_modulus_mpa", sim, g.wire_modulus_mpa,
                               "rod: of the wire in bending [MPa], 0 to 1e6"));
  table.push_back(make_setting("guidewire.density_g_mm3", sim, g.density_g_mm3,
                               "rod: of wire and shaft [g/mm3], 1e-5 to 0.1"));
}

void add_inflation_settings(Config& c, std::vector<Setting>& table) {
  const auto sim = Stage::simulation;
  auto& s = c.simulation;
  table.push_back(make_setting("inflation.control", sim, s.inflation.control,
                               "what the inflator prescribes: gas, pressure or volume"));
  table.push_back(make_setting("inflation.deflate_pressure_atm", sim,
                               s.inflation.deflate_pressure_atm,
                               "pressure control: at the end of the deflation [atm], -1 to 0"));
  table.push_back(make_setting("inflation.peak_volume_mm3", sim, s.inflation.peak_volume_mm3,
                               "volume control: at the peak [mm3]; 0: the nominal volume"));
  table.push_back(
      make_setting("inflation.inflate_s", sim, s.inflation.inflate_s, "[s], up to 600"));
  table.push_back(make_setting("inflation.hold_s", sim, s.inflation.hold_s, "[s], 0 to 600"));
  table.push_back(
      make_setting("inflation.deflate_s", sim, s.inflation.deflate_s, "[s], up to 600"));
  table.push_back(make_setting("inflation.rest_s", sim, s.inflation.rest_s, "[s], 0 to 600"));
  table.push_back(make_setting("inflation.peak_pressure_atm", sim, s.inflation.peak_pressure_atm,
                               "highest pressure above the outside [atm], up to 40; 0: nominal, by "
                               "the diameter (8 up to 4 mm)"));
  table.push_back(make_setting("inflation.rated_burst_atm", sim, s.inflation.rated_burst_atm,
                               "a higher peak is warned about [atm], up to 100; 0: by the diameter "
                               "(14 up to 4 mm)"));
  table.push_back(make_setting("inflation.outside_pressure_kpa", sim,
                               s.inflation.outside_pressure_kpa,
                               "blood pressure around the balloon [kPa], 0 to 50"));
}

void add_simulation_settings(Config& c, std::vector<Setting>& table) {
  const auto sim = Stage::simulation;
  auto& s = c.simulation;
  table.push_back(make_setting("simulation.frame_s", sim, s.frame_s, "time step [s], 0.0001 to 1"));
  table.push_back(make_setting("simulation.tolerance", sim, s.tolerance,
                               "distance from equilibrium that ends a frame, over the balloon's "
                               "start radius, 1e-6 to 0.1"));
  table.push_back(make_setting("simulation.sweeps", sim, s.sweeps,
                               "vertex block descent sweeps a frame, 1 to 1000; 0: by the "
                               "tolerance"));
  table.push_back(make_setting("simulation.contact_distance_mm", sim, s.contact_distance_mm,
                               "contact acts below this gap [mm], 0.001 to 1; 0: by the balloon's "
                               "diameter (0.03 from 2 to 4 mm)"));
  table.push_back(
      make_setting("simulation.self_contact", sim, s.self_contact,
                   "a slack balloon, its meshed folds and the wall around it do not pass "
                   "through themselves"));
  table.push_back(make_setting("simulation.friction_static", sim, s.friction_static, "0 to 2"));
  table.push_back(make_setting("simulation.friction_kinetic", sim, s.friction_kinetic, "0 to 2"));
  table.push_back(make_setting("simulation.contact_model", sim, s.contact_model,
                               "barrier, or paper (the seed paper's projections, for comparison: "
                               "does not converge)"));
  table.push_back(make_setting("simulation.gas_model", sim, s.gas_model,
                               "enclosed, or per_tet (the seed paper's, for comparison: volume "
                               "control, no balance of forces)"));
  table.push_back(make_setting("simulation.contact_stiffness", sim, s.contact_stiffness,
                               "factor on the barrier's stiffness, 0.01 to 100"));
  table.push_back(make_setting("simulation.adhesion_traction_kpa", sim, s.adhesion_traction_kpa,
                               "most that the film between wet surfaces holds [kPa], 0 to 100; 0: "
                               "none; -1: by the diameter (2.5 from 2 to 4 mm)"));
  table.push_back(make_setting("simulation.adhesion_gap_1_mm", sim, s.adhesion_gap_1_mm,
                               "surfaces nearer than this have touched [mm], up to 1; 0: by the "
                               "diameter (0.03 from 2 to 4 mm)"));
  table.push_back(make_setting("simulation.adhesion_gap_2_mm", sim, s.adhesion_gap_2_mm,
                               "the film breaks here [mm], above gap 1, up to 2; 0: by the "
                               "diameter (0.06 from 2 to 4 mm)"));
  table.push_back(make_setting("simulation.paper_volume_1_mm3", sim, s.paper_volume_1_mm3,
                               "contact_model paper: V_th1 [mm3], 0 to 100; 0: from the gaps"));
  table.push_back(make_setting("simulation.paper_volume_2_mm3", sim, s.paper_volume_2_mm3,
                               "contact_model paper: V_th2 [mm3], 0 to 100; 0: from the gaps"));
  table.push_back(
      make_setting("simulation.write_every", sim, c.write_every,
                   "solver frames per frame written; first, peak and last always are, 1 to "
                   "10000"));
}

void add_cloth_settings(Config& c, std::vector<Setting>& table) {
  const auto mesh = Stage::meshing, sim = Stage::simulation;
  table.push_back(make_setting("cloth.side_mm", mesh, c.cloth.side_mm, "of the square [mm]"));
  table.push_back(
      make_setting("cloth.cells", mesh, c.cloth.cells, "along a side, even, 2 to 1000"));
  table.push_back(
      make_setting("cloth.thickness_mm", sim, c.cloth.thickness_mm, "before it is pulled [mm]"));
  table.push_back(make_setting("cloth.stretch", sim, c.cloth.stretch,
                               "growth of the corners' distance in the end, up to 3"));
  table.push_back(
      make_setting("cloth.steps", sim, c.cloth.steps, "in which it is pulled, 1 to 10000"));
  table.push_back(make_setting("cloth.solver", sim, c.cloth.solver,
                               "newton (double precision) or vbd (single)"));
}

}  // namespace

std::vector<Setting> settings(Config& config) {
  std::vector<Setting> table;
  add_segmentation_settings(config, table);
  add_centerline_settings(config, table);
  add_meshing_settings(config, table);
  add_material_settings(config, table);
  add_guidewire_settings(config, table);
  add_inflation_settings(config, table);
  add_simulation_settings(config, table);
  add_cloth_settings(config, table);
  return table;
}

}  // namespace angio::pipeline
