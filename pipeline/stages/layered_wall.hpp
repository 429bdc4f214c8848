#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "centerline/centerline.hpp"
#include "meshing/wall_layers.hpp"
#include "pipeline/case/stage_files.hpp"
#include "simulation/simulation.hpp"

/// The wall as a layered solid (`wall.model = "layered"`): from the lumen's surface to the solver
/// and to files.
namespace angio::pipeline {

/// Extrudes the region's surface, with plaque along the treated lesion and every other stenosis.
/// @param lesions  how stenoses are found, with what the data can show; wherever they look
meshing::WallLayers layer_wall(const meshing::ContactRegion& region, const CenterlineTree& tree,
                               const centerline::Lesion& treated,
                               const centerline::LesionOptions& lesions,
                               const meshing::WallLayerOptions& options);

/// wall.vtu: wedges with Layer, Region (0 intima, 1 media, 2 adventitia, 3 plaque, 4 calcium),
/// Axial; Fixed at the points, the first of which are the region's.
void write_layered_wall(const std::filesystem::path& meshing_folder,
                        const meshing::WallLayers& wall);
/// Empty if the meshing stage has made none.
/// @param lumen  the region's surface
simulation::LayeredWall read_layered_wall(const StageFiles& files, const TriangleMesh& lumen);

/// frames/wall_NNNNNN.vtu: displacement at the points; stress [kPa], strain and volume ratio of
/// each wedge.
void write_wall_frame(const std::filesystem::path& file, const simulation::LayeredWall& wall,
                      const simulation::SimulationFrame& frame);

/// Of metrics.json: the share of the wall that has reached its strength, and for each region that
/// the wall has, stress at the peak [kPa] and what plastic strain stays. Of the wedges' values; the
/// 99th percentile, as single corners peak. Of what the balloon touches at the peak stress and
/// largest principal log strain (from the wall as it was imaged) have quantiles by volume; null
/// where it touches nothing of a region.
nlohmann::json wall_summary(const simulation::LayeredWall& wall,
                            const simulation::SimulationFrame& peak,
                            const simulation::SimulationFrame& last);

/// (t_max - t_min) / t_max of the thickness of intima, plaque and media round a place of the
/// treated line before the balloon: 0 the same all round. The plaque eccentricity of intravascular
/// ultrasound: Mintz et al., J. Am. Coll. Cardiol. 37(5), 2001, 1478-1492,
/// doi:10.1016/S0735-1097(01)01175-5.
///
/// @param reach_mm  along the line, to both sides
/// @return NaN where no wall is near
double plaque_eccentricity(const simulation::SimulationModel& model, double abscissa_mm,
                           double reach_mm);

}  // namespace angio::pipeline
