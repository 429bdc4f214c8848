#pragma once

#include <filesystem>
#include <vector>

#include "core/centerline.hpp"
#include "core/volume.hpp"
#include "meshing/lumen_volume.hpp"
#include "meshing/meshing.hpp"
#include "pipeline/case/stage_files.hpp"
#include "simulation/simulation.hpp"

/// The stages' results as the files of docs/contract.md, and back. What is read is what was
/// written, bit for bit, so a stage gives the same result from memory and from files.
namespace angio::pipeline {

/// @param radius_sd  of each point's radius [mm], shape [paths][points]; empty: not known, not
///                   written
void write_centerlines(const std::filesystem::path& file, const CenterlineTree& tree,
                       const std::vector<std::vector<double>>& radius_sd = {});
/// paths.vtp: one polyline from the inlet to each outlet, for programs that follow one vessel; the
/// radius also by the name that SlicerVMTK asks for.
void write_paths(const std::filesystem::path& file, const CenterlineTree& tree);
CenterlineTree read_centerlines(const std::filesystem::path& file);

/// @throws OptionError if no line has that id
const CenterlinePath& path_of(const CenterlineTree& tree, int path_id);

/// Was the case's lumen given as a surface, not found in a volume?
bool has_surface_input(const StageFiles& files);
TriangleMesh read_given_surface(const StageFiles& files);
Volume<float> read_level_set(const StageFiles& files);

/// lumen.vtp, lumen.stl, lumen_capped.stl, lumen_capped.vtp (with InletOutletId)
void write_lumen(const std::filesystem::path& folder, const meshing::LumenMesh& lumen);
/// lumen.vtu: tetrahedra, then the faces of the boundary as triangles; the cell array
/// CellEntityIds, VMTK's name, is 0 in the volume, 1 on the wall, 2 at the inlet, 3... at the
/// outlets.
void write_lumen_volume(const std::filesystem::path& folder, const meshing::LumenVolume& volume);
TriangleMesh read_open_lumen(const StageFiles& files);

/// balloon.vtp, guidewire.vtp, region.vtp, air.vtu
void write_balloon_setup(const std::filesystem::path& folder, const meshing::BalloonSetup& setup);
/// Everything but the place where diameters are watched and the reference radius.
simulation::SimulationModel read_simulation_model(const StageFiles& files);
/// Index in the open lumen of each vertex of the region.
std::vector<int> read_region_lumen_vertices(const StageFiles& files, std::size_t lumen_vertices);

/// frames/balloon_NNNNNN.vtp and frames/vessel_NNNNNN.vtp
void write_frame(const std::filesystem::path& frames_folder,
                 const simulation::SimulationModel& model,
                 const simulation::SimulationFrame& frame);

/// The frame's shape and contact pressure as written.
struct FrameShape {
  TriangleMesh balloon;
  TriangleMesh wall;
  std::vector<double> contact_pressure_kpa;
  std::vector<Vec3> guidewire;  ///< where it moves; otherwise it stays where meshing has put it
};
FrameShape read_frame(const std::filesystem::path& frames_folder, int frame);
/// Many, in their order: one guarded process reads them (formats::read_vtp_surfaces).
std::vector<FrameShape> read_frames(const std::filesystem::path& frames_folder,
                                    const std::vector<int>& frames);

/// Header and row of timeseries.csv. @param lumen_mld_mm  of the treated path (TreatedLumen)
extern const char* const kTimeSeriesHeader;
std::string time_series_row(const simulation::SimulationFrame& frame, double lumen_mld_mm);

}  // namespace angio::pipeline
