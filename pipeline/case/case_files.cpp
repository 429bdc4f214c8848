#include "pipeline/case/case_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "core/error.hpp"
#include "formats/case_file.hpp"
#include "formats/checked_arrays.hpp"
#include "formats/files.hpp"
#include "formats/frame_file.hpp"
#include "segmentation/read_volume.hpp"
#include "simulation/balloon_measures.hpp"

namespace angio::pipeline {
namespace file = formats::case_file;
namespace fs = std::filesystem;
namespace {

constexpr const char* kInBalloon = "InBalloon";

DataArray scalar(std::string array_name, std::vector<double> values,
                 ArrayType type = ArrayType::float64) {
  return {std::move(array_name), std::move(values), 1, type};
}

template <class Integer>
DataArray integers(std::string array_name, const std::vector<Integer>& values, ArrayType type) {
  return scalar(std::move(array_name), std::vector<double>(values.begin(), values.end()), type);
}

DataArray vectors(std::string array_name, const std::vector<Vec3>& values) {
  DataArray array{std::move(array_name), {}, 3, ArrayType::float64};
  array.values.reserve(3 * values.size());
  for (const Vec3& v : values) array.values.insert(array.values.end(), {v.x, v.y, v.z});
  return array;
}

// What a case's own files may hold: they may come from elsewhere.
constexpr double kMostLength = 1e5;     // [mm]
constexpr double kMostPressure = 1e12;  // [kPa]

formats::CheckedArrays arrays_of(const formats::SurfaceData& data, const fs::path& file) {
  return {data.point_arrays, data.mesh.vertices.size(), file.filename().string()};
}

std::vector<double> subtract(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  std::vector<double> difference;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Vec3 d = a[i] - b[i];
    difference.insert(difference.end(), {d.x, d.y, d.z});
  }
  return difference;
}

std::string frame_file(const char* body, int frame) {
  return fmt::format("{}_{:06d}.vtp", body, frame);
}

void write_wire(const fs::path& file, const simulation::WholeWire& wire) {
  formats::PolylineData line;
  line.points = wire.nodes;
  line.point_arrays = {integers(kInBalloon, wire.in_balloon, ArrayType::uint8)};
  line.lines.emplace_back(wire.nodes.size());
  std::iota(line.lines[0].begin(), line.lines[0].end(), 0);
  formats::write_polylines(file, line);
}

/// The points of all paths, one path after the other, with their arrays.
formats::PolylineData points_of(const CenterlineTree& tree) {
  formats::PolylineData data;
  std::vector<double> radius, tube, abscissa, equivalent, area;
  const auto append = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  for (const CenterlinePath& path : tree.paths) {
    append(data.points, path.points);
    append(radius, path.inscribed_radius);
    append(tube, measured_radius(path));
    append(abscissa, path.abscissa);
    append(equivalent, path.equivalent_radius);
    append(area, path.section_area);
  }
  data.point_arrays = {scalar("MaximumInscribedSphereRadius", radius), scalar("TubeRadius", tube),
                       scalar("Abscissas", abscissa), scalar("EquivalentRadius", equivalent),
                       scalar("SectionArea", area)};
  return data;
}

}  // namespace

// ---- centreline --------------------------------------------------------------------------------

void write_centerlines(const fs::path& file, const CenterlineTree& tree,
                       const std::vector<std::vector<double>>& radius_sd) {
  formats::PolylineData data = points_of(tree);
  if (!radius_sd.empty()) {
    DataArray& sd = data.point_arrays.emplace_back(scalar("RadiusStandardDeviation", {}));
    for (const std::vector<double>& path : radius_sd)
      sd.values.insert(sd.values.end(), path.begin(), path.end());
  }
  std::vector<int> centerline_ids, group_ids, tract_ids, blanking;
  int first = 0;
  for (const CenterlinePath& path : tree.paths) {
    for (const CenterlineTract& tract : path.tracts) {
      std::vector<int>& line = data.lines.emplace_back();
      for (int p = tract.first_point; p <= tract.last_point; ++p) line.push_back(first + p);
      centerline_ids.push_back(path.id);
      group_ids.push_back(tract.group_id);
      tract_ids.push_back(tract.tract_id);
      blanking.push_back(tract.blanking ? 1 : 0);
    }
    first += int(path.points.size());
  }
  data.cell_arrays = {integers("CenterlineIds", centerline_ids, ArrayType::int32),
                      integers("GroupIds", group_ids, ArrayType::int32),
                      integers("TractIds", tract_ids, ArrayType::int32),
                      integers("Blanking", blanking, ArrayType::int32)};
  formats::write_polylines(file, data);
}

void write_paths(const fs::path& file, const CenterlineTree& tree) {
  formats::PolylineData data = points_of(tree);
  std::vector<int> blanking(data.points.size(), 0), ids;
  int first = 0;
  for (const CenterlinePath& path : tree.paths) {
    ids.push_back(path.id);
    for (const CenterlineTract& tract : path.tracts)
      if (tract.blanking)
        std::fill(blanking.begin() + first + tract.first_point,
                  blanking.begin() + first + tract.last_point + 1, 1);
    std::vector<int>& line = data.lines.emplace_back(path.points.size());
    std::iota(line.begin(), line.end(), first);
    first += int(path.points.size());
  }
  DataArray radius = data.point_arrays.front();
  radius.name = "Radius";
  data.point_arrays.insert(data.point_arrays.begin(), std::move(radius));
  data.point_arrays.push_back(integers("Blanking", blanking, ArrayType::int32));
  data.cell_arrays = {integers("CenterlineIds", ids, ArrayType::int32)};
  formats::write_polylines(file, data);
}

CenterlineTree read_centerlines(const fs::path& file) {
  const formats::PolylineData data = formats::read_polylines(file);
  const std::string name = file.filename().string();
  const formats::CheckedArrays at_points(data.point_arrays, data.points.size(), name);
  const formats::CheckedArrays of_lines(data.cell_arrays, data.lines.size(), name);
  const auto radius = at_points.numbers("MaximumInscribedSphereRadius", 0.0, kMostLength);
  const auto tube = at_points.numbers("TubeRadius", 0.0, kMostLength);
  const auto abscissa = at_points.numbers("Abscissas", 0.0, kMostLength);
  const auto equivalent = at_points.numbers("EquivalentRadius", 0.0, kMostLength);
  const auto area = at_points.numbers("SectionArea", 0.0, kMostLength * kMostLength);
  const auto centerline_ids = of_lines.integers<int>("CenterlineIds", 0.0);
  const auto group_ids = of_lines.integers<int>("GroupIds", 0.0);
  const auto tract_ids = of_lines.integers<int>("TractIds", 0.0);
  const auto blanking = of_lines.integers<int>("Blanking", 0.0, 1.0);

  CenterlineTree tree;
  std::map<int, std::size_t> index_of_id;
  for (std::size_t cell = 0; cell < data.lines.size(); ++cell) {
    const auto [entry, is_new] = index_of_id.try_emplace(centerline_ids[cell], tree.paths.size());
    if (is_new) tree.paths.emplace_back().id = centerline_ids[cell];
    CenterlinePath& path = tree.paths[entry->second];
    const std::vector<int>& line = data.lines[cell];
    const int shared = path.points.empty() ? 0 : 1;  // tracts share their border point
    CenterlineTract tract;
    tract.first_point = int(path.points.size()) - shared;
    for (std::size_t i = std::size_t(shared); i < line.size(); ++i) {
      const auto p = std::size_t(line[i]);
      path.points.push_back(data.points[p]);
      path.inscribed_radius.push_back(radius[p]);
      path.tube_radius.push_back(tube[p]);
      path.abscissa.push_back(abscissa[p]);
      path.equivalent_radius.push_back(equivalent[p]);
      path.section_area.push_back(area[p]);
    }
    tract.last_point = int(path.points.size()) - 1;
    tract.group_id = group_ids[cell];
    tract.tract_id = tract_ids[cell];
    tract.blanking = blanking[cell] != 0;
    path.tracts.push_back(tract);
  }
  if (tree.paths.empty()) throw InputError(name + " holds no line. Run `angio centerline` again");
  for (const CenterlinePath& path : tree.paths)
    if (path.points.size() < 2 || !std::is_sorted(path.abscissa.begin(), path.abscissa.end()))
      throw InputError(
          fmt::format("{}: line {} does not run on from point to point (the file was "
                      "changed or is damaged). Run `angio centerline` again",
                      name, path.id));
  return tree;
}

// ---- meshes ------------------------------------------------------------------------------------

const CenterlinePath& path_of(const CenterlineTree& tree, int path_id) {
  const auto found = std::find_if(tree.paths.begin(), tree.paths.end(),
                                  [&](const CenterlinePath& path) { return path.id == path_id; });
  if (found == tree.paths.end())
    throw OptionError(
        fmt::format("lesion.centerline = {} is not in this case (it has {} lines, "
                    "numbered from 0)",
                    path_id, tree.paths.size()));
  return *found;
}

bool has_surface_input(const StageFiles& files) { return files.exists(file::kGivenLumen); }

TriangleMesh read_given_surface(const StageFiles& files) {
  return formats::read_surface(files.path(file::kGivenLumen)).mesh;
}

Volume<float> read_level_set(const StageFiles& files) {
  return segmentation::read_volume_file(files.path(file::kLevelSet));
}

void write_lumen(const fs::path& folder, const meshing::LumenMesh& lumen) {
  formats::write_surface(folder / "lumen.vtp", {lumen.open, {}, {}});
  formats::write_surface(folder / "lumen.stl", {lumen.open, {}, {}});
  const formats::SurfaceData capped{
      lumen.capped, {integers("InletOutletId", lumen.inlet_outlet_id, ArrayType::int32)}, {}};
  formats::write_surface(folder / "lumen_capped.vtp", capped);
  formats::write_surface(folder / "lumen_capped.stl", capped);
}

void write_lumen_volume(const fs::path& folder, const meshing::LumenVolume& volume) {
  std::vector<int> entity(volume.mesh.tets.size(), 0);
  entity.insert(entity.end(), volume.boundary_entity_id.begin(), volume.boundary_entity_id.end());
  formats::write_tets(
      folder / "lumen.vtu",
      {volume.mesh, {}, {integers("CellEntityIds", entity, ArrayType::int32)}, volume.boundary});
}

TriangleMesh read_open_lumen(const StageFiles& files) {
  return formats::read_surface(files.path(file::kLumen)).mesh;
}

void write_balloon_setup(const fs::path& folder, const meshing::BalloonSetup& setup) {
  const meshing::Balloon& balloon = setup.balloon;
  formats::write_surface(
      folder / "balloon.vtp",
      {balloon.start,
       {vectors("RestPosition", balloon.rest), integers("Fixed", balloon.fixed, ArrayType::uint8),
        integers("Sliding", balloon.sliding, ArrayType::uint8)},
       {}});

  simulation::SimulationModel wire;
  wire.guidewire = balloon.guidewire;
  wire.guidewire_before = balloon.guidewire_before;
  wire.guidewire_behind = balloon.guidewire_behind;
  write_wire(folder / "guidewire.vtp", simulation::whole_wire(wire, wire.guidewire));

  const meshing::ContactRegion& region = setup.region;
  formats::write_surface(
      folder / "region.vtp",
      {region.mesh,
       {integers("LumenVertexIds", region.lumen_vertex, ArrayType::int32),
        integers("Fixed", region.fixed, ArrayType::uint8), scalar("Abscissas", region.abscissa),
        integers("GroupIds", region.group, ArrayType::int32)},
       {}});

  formats::TetData air{setup.air.tets, {}, {}, {}};
  std::vector<int> body(air.mesh.vertices.size(), 1);
  std::fill_n(body.begin(), balloon.start.vertices.size(), 0);
  air.point_arrays = {integers("BodyIds", body, ArrayType::int32)};  // 0 balloon, 1 vessel
  formats::write_tets(folder / "air.vtu", air);
}

namespace {

// A wire of a program before the array was there lies in the balloon.
void read_wire(const fs::path& file, simulation::SimulationModel& model) {
  const formats::PolylineData wire = formats::read_polylines(file);
  const bool is_marked = std::any_of(wire.point_arrays.begin(), wire.point_arrays.end(),
                                     [](const DataArray& a) { return a.name == kInBalloon; });
  const formats::CheckedArrays at_points(wire.point_arrays, wire.points.size(),
                                         file.filename().string());
  const std::vector<char> inside = is_marked ? at_points.integers<char>(kInBalloon, 0.0, 1.0)
                                             : std::vector<char>(wire.points.size(), 1);
  for (std::size_t i = 0; i < wire.points.size(); ++i) {
    std::vector<Vec3>& part = inside[i] != 0            ? model.guidewire
                              : model.guidewire.empty() ? model.guidewire_before
                                                        : model.guidewire_behind;
    part.push_back(wire.points[i]);
  }
}

}  // namespace

simulation::SimulationModel read_simulation_model(const StageFiles& files) {
  simulation::SimulationModel model;
  const formats::SurfaceData balloon = formats::read_surface(files.path(file::kBalloon));
  const formats::CheckedArrays of_balloon = arrays_of(balloon, file::kBalloon);
  model.balloon = balloon.mesh;
  model.balloon_rest = of_balloon.vectors("RestPosition");
  model.balloon_fixed = of_balloon.integers<char>("Fixed", 0.0, 1.0);
  model.balloon_sliding = of_balloon.integers<char>("Sliding", 0.0, 1.0);
  read_wire(files.path(file::kGuidewire), model);
  const formats::SurfaceData region = formats::read_surface(files.path(file::kRegion));
  const formats::CheckedArrays of_region = arrays_of(region, file::kRegion);
  model.wall = region.mesh;
  model.wall_fixed = of_region.integers<char>("Fixed", 0.0, 1.0);
  model.wall_abscissa = of_region.numbers("Abscissas", -kMostLength, kMostLength);
  model.wall_group = of_region.integers<int>("GroupIds", 0.0);
  model.air = formats::read_tets(files.path(file::kAir)).mesh.tets;
  return model;
}

std::vector<int> read_region_lumen_vertices(const StageFiles& files, std::size_t lumen_vertices) {
  const formats::SurfaceData region = formats::read_surface(files.path(file::kRegion));
  return arrays_of(region, file::kRegion)
      .integers<int>("LumenVertexIds", 0.0, double(lumen_vertices) - 1.0);
}

// ---- frames ------------------------------------------------------------------------------------

void write_frame(const fs::path& frames_folder, const simulation::SimulationModel& model,
                 const simulation::SimulationFrame& frame) {
  const auto f32 = ArrayType::float32;
  const formats::FrameMoment moment{frame.time_s, frame.pressure_atm,
                                    simulation::name(frame.phase)};
  formats::write_frame_surface(
      frames_folder / frame_file("balloon", frame.frame),
      {{frame.balloon, model.balloon.triangles},
       {{"displacement", subtract(frame.balloon, model.balloon.vertices), 3, f32},
        scalar("thickness", frame.membrane.thickness_mm, f32),
        scalar("stretch_1", frame.membrane.stretch_1, f32),
        scalar("stretch_2", frame.membrane.stretch_2, f32)},
       {}},
      moment);
  formats::write_frame_surface(
      frames_folder / frame_file("vessel", frame.frame),
      {{frame.wall, model.wall.triangles},
       {{"displacement", subtract(frame.wall, model.wall.vertices), 3, f32},
        scalar("plastic_strain", frame.plastic_strain, f32),
        scalar("contact_pressure", frame.contact_pressure_kpa, f32)},
       {}},
      moment);
  if (!frame.guidewire.empty())
    write_wire(frames_folder / frame_file("guidewire", frame.frame),
               simulation::whole_wire(model, frame.guidewire));
}

std::vector<FrameShape> read_frames(const fs::path& frames_folder, const std::vector<int>& frames) {
  std::vector<fs::path> surfaces, wires;
  for (const int frame : frames) {
    surfaces.push_back(frames_folder / frame_file("balloon", frame));
    surfaces.push_back(frames_folder / frame_file("vessel", frame));
    const fs::path wire = frames_folder / frame_file("guidewire", frame);
    if (fs::exists(wire)) wires.push_back(wire);
  }
  if (!wires.empty() && wires.size() < frames.size())
    throw InputError("some frames have a guidewire and some do not, in " + frames_folder.string() +
                     " (files were removed). Run `angio simulate` again");
  std::vector<formats::SurfaceData> bodies = formats::read_vtp_surfaces(surfaces);
  std::vector<formats::PolylineData> moved = formats::read_polylines(wires);
  std::vector<FrameShape> shapes(frames.size());
  for (std::size_t n = 0; n < shapes.size(); ++n) {
    formats::SurfaceData &balloon = bodies[2 * n], &wall = bodies[2 * n + 1];
    shapes[n].balloon = std::move(balloon.mesh);
    shapes[n].contact_pressure_kpa =
        arrays_of(wall, surfaces[2 * n + 1]).numbers("contact_pressure", 0.0, kMostPressure);
    shapes[n].wall = std::move(wall.mesh);
    if (!moved.empty()) shapes[n].guidewire = std::move(moved[n].points);
  }
  return shapes;
}

FrameShape read_frame(const fs::path& frames_folder, int frame) {
  return std::move(read_frames(frames_folder, {frame}).front());
}

const char* const kTimeSeriesHeader =
    "frame,time_s,phase,pressure_atm,balloon_volume_mm3,balloon_diameter_mm,lumen_mld_mm,"
    "friction_delta_mm,viscous_delta_mm,contact_count,min_air_volume_mm3,max_penetration_mm,"
    "air_tet_count,flip_count,balloon_proximal_diameter_mm,balloon_distal_diameter_mm";

std::string time_series_row(const simulation::SimulationFrame& f, double lumen_mld_mm) {
  std::string row = fmt::format(
      "{},{:.6g},{},{:.6g},{:.7g},{:.6g},{:.6g},{:.6g},{:.6g},{},{:.6g},{:.6g},{},{}", f.frame,
      f.time_s, simulation::name(f.phase), f.pressure_atm, f.balloon_volume_mm3,
      f.balloon_diameter_mm, lumen_mld_mm, f.contact.friction_delta_mm, f.contact.viscous_delta_mm,
      f.contact.count, f.air.min_volume, f.contact.max_penetration_mm, f.air.tet_count,
      f.air.flip_count);
  for (const std::size_t end : {0U, 1U})
    row += end < f.end_diameters_mm.size() ? fmt::format(",{:.6g}", f.end_diameters_mm[end]) : ",";
  return row;
}

}  // namespace angio::pipeline
