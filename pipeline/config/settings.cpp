#include "pipeline/config/config.hpp"
#include "pipeline/config/setting_fields.hpp"

// The table of all settings.
namespace angio::pipeline {
namespace {

void add_reconstruction_settings(Config& c, std::vector<Setting>& table) {
  table.push_back(make_setting(
      "reconstruction.method", c.reconstruction.method,
      fmt::format("of a rotational run: fdk (filtered back-projection), few-views (the "
                  "vessels alone, by iteration), or auto: few-views where frames lie "
                  "more than {:g} degrees apart",
                  reconstruction::kFewViewsDegrees)));
  table.push_back(
      make_setting("reconstruction.gating", c.reconstruction.gating,
                   "the frames of one phase of the heart alone: on, off, or auto: where "
                   "the vessels move with it for three beats or more"));
  table.push_back(make_setting("reconstruction.phase_percent", c.reconstruction.phase_percent,
                               "the phase, of the way from R wave to R wave [%], 0 to 100"));
  table.push_back(make_setting("reconstruction.phase_width_percent",
                               c.reconstruction.phase_width_percent,
                               "how much of the beat around it, 2 to 100 [%]"));
  table.push_back(make_setting("reconstruction.voxel_mm", c.reconstruction.voxel_mm,
                               "of a rotational run: edge of a voxel [mm], 0.05 to 5; 0: a pixel's "
                               "size at the isocentre"));
  table.push_back(make_setting("reconstruction.largest_side", c.reconstruction.largest_side,
                               "voxels along an edge, 16 to 2048; where voxel_mm is 0 the voxels "
                               "grow until they are no more"));
  table.push_back(make_setting("reconstruction.air", c.reconstruction.air,
                               "a pixel's value where nothing is in the beam; 0: the brightest"));
  table.push_back(make_setting("reconstruction.calibrate", c.reconstruction.calibrate,
                               "find the C-arm's real path from the vessels where it is not the "
                               "header's"));
  table.push_back(make_setting("reconstruction.window", c.reconstruction.window,
                               "of the ramp filter: ram-lak, shepp-logan or hann"));
}

void add_views_settings(Config& c, std::vector<Setting>& table) {
  table.push_back(make_setting("input.views", c.input.views,
                               "angiograms of a C-arm that stood still: their numbers from `angio "
                               "inspect`, as \"1,3\"; \"\": all that can be used, of each side "
                               "the longest"));
  table.push_back(make_setting("views.frames", c.view_frames,
                               "which frame of each view, from 1, as [5, 9]; []: the one that "
                               "shows the most contrast medium"));
  table.push_back(make_setting("views.ends", c.view_ends,
                               "of the one vessel that is wanted, for each view: column and row of "
                               "its proximal end, then of its distal one, in pixels from 0; []: "
                               "all vessels that the views tell of"));
  table.push_back(make_setting("views.thinnest_mm", c.views.thinnest_mm,
                               "diameter of the thinnest vessel in them [mm], 0 to 5; a stenosis "
                               "may be thinner; 0: all that are seen"));
  table.push_back(make_setting("views.widest_mm", c.views.widest_mm,
                               "diameter of the widest vessel in them [mm], 1 to 40: what is wider "
                               "is background"));
  table.push_back(make_setting("views.shift_sd_mm", c.views.shift_sd_mm,
                               "how far a view may have been taken from where it says, beside what "
                               "is found of it, sd [mm], 0 to 20"));
  table.push_back(make_setting("views.turn_sd_degrees", c.views.turn_sd_degrees,
                               "and how far turned, sd [degrees], 0 to 20"));
}

void add_segmentation_settings(Config& c, std::vector<Setting>& table) {
  table.push_back(make_setting("input.experiment", c.experiment,
                               "the seed paper's experiment whose mesh a phantom input gives: "
                               "cloth, unilateral, bilateral, ytype or coronary; \"\": none"));
  table.push_back(
      make_setting("input.series", c.input.series,
                   "series of a DICOM folder: its number or key from `angio inspect`; \"\": "
                   "the one with the most voxels"));
  table.push_back(make_setting("input.allow_lossy", c.input.allow_lossy,
                               "measure on lossy-compressed pixels all the same"));
  table.push_back(make_setting("input.spacing_mm", c.input.spacing_mm,
                               "voxel size between columns, rows and slices [mm] for a scan that "
                               "states none; zeros: refuse it"));
  table.push_back(make_setting("input.resample", c.input.resample,
                               "interpolate missing or unevenly spaced slices"));
  table.push_back(make_setting("input.angles", c.input.angles,
                               "a projection run's angle increments: from-base or cumulative"));
  table.push_back(make_setting("input.max_memory_gib", c.input.max_memory_gib,
                               "refuse a scan that needs more [GiB]; 0: what is free"));
  table.push_back(
      make_setting("input.unit", c.surface_unit,
                   "what a given lumen surface or volume file is measured in: mm, cm, m or inch; "
                   "\"auto\": as the file says, otherwise by its size"));
  table.push_back(make_setting("segmentation.smallest_radius_mm", c.segmentation.smallest_radius_mm,
                               "thinnest vessel looked for [mm], 0.1 to 20"));
  table.push_back(make_setting("segmentation.largest_radius_mm", c.segmentation.largest_radius_mm,
                               "widest vessel looked for by its shape [mm], 0.2 to 30"));
  table.push_back(make_setting("segmentation.scale_count", c.segmentation.scale_count,
                               "scales of the vessel enhancement, 1 to 8"));
  table.push_back(make_setting("segmentation.seeds_lps_mm", c.segmentation.seeds_lps_mm,
                               "points inside the vessel, LPS [mm]; []: found automatically"));
  table.push_back(make_setting("segmentation.intensity_min", c.segmentation.intensity_min,
                               "lowest intensity of the lumen [the volume's unit]; \"auto\""));
  table.push_back(make_setting("segmentation.intensity_max", c.segmentation.intensity_max,
                               "highest intensity of the lumen; \"auto\""));
  table.push_back(make_setting("segmentation.exclude_bone", c.segmentation.exclude_bone,
                               "keep out bone, organs, calcification and metal"));
  table.push_back(make_setting("segmentation.region_lps_mm", c.segmentation.region_lps_mm,
                               "box [[x, y, z], [x, y, z]] in LPS [mm] in which vessels are looked "
                               "for; \"auto\": everywhere"));
  table.push_back(make_setting("segmentation.min_component_mm3", c.segmentation.min_component_mm3,
                               "smaller pieces are noise [mm3], 0 to 1e6"));
  table.push_back(
      make_setting("segmentation.max_diameter_mm", c.segmentation.max_diameter_mm,
                   "wider parts are left out, as the heart's chambers beside coronaries "
                   "[mm], 1 to 60; 0: none"));
  table.push_back(make_setting("segmentation.labels", c.segmentation.labels,
                               "of a label map: the labels that are lumen; []: all of them"));
}

void add_centerline_settings(Config& c, std::vector<Setting>& table) {
  table.push_back(make_setting("centerline.inlet_lps_mm", c.centerline.inlet_lps_mm,
                               "a point at the inlet, LPS [mm]; \"auto\": by the tree's shape"));
  table.push_back(make_setting("centerline.inlet_end", c.inlet_end,
                               "of a given surface: the number of the open end that is the inlet, "
                               "as `angio inspect` lists them; 0: not said so"));
  table.push_back(make_setting("centerline.outlets_lps_mm", c.centerline.outlets_lps_mm,
                               "points at the outlets, LPS [mm]; []: every other end"));
  table.push_back(make_setting("centerline.step_mm", c.centerline.step_mm,
                               "distance of points [mm], up to 5; 0: a quarter of the radius"));
  table.push_back(make_setting("centerline.min_branch_length_mm", c.centerline.min_branch_length_mm,
                               "shorter side branches are spurs [mm]; 0: by the parent's radius"));
  table.push_back(make_setting("lesion.narrow_percent", c.narrowing.percent,
                               "narrow a vessel without a stenosis (or the place named) by so much "
                               "of its healthy diameter [%], 5 to 100; 0: leave it"));
  table.push_back(make_setting("lesion.narrow_length_mm", c.narrowing.length_mm,
                               "of that narrowing [mm], 1 to 100; 0: three diameters"));
}

void add_meshing_settings(Config& c, std::vector<Setting>& table) {
  table.push_back(make_setting("lesion.centerline", c.lesion.centerline,
                               "CenterlineIds of the line to treat; -1: the whole tree"));
  table.push_back(
      make_setting("lesion.abscissa_mm", c.lesion.abscissa_mm,
                   "place on that line [mm from the inlet]; -1: the tightest stenosis"));
  table.push_back(make_setting("lesion.min_stenosis_percent", c.lesion.min_stenosis_percent,
                               "less is no stenosis [%], 10 to 90"));
  table.push_back(
      make_setting("mesh.edge_length_mm", c.lumen_mesh.edge_length_mm,
                   "target edge length of the lumen [mm], up to 5; 0: by the local radius"));
  table.push_back(make_setting("mesh.edges_per_circumference", c.lumen_mesh.edges_per_circumference,
                               "edges around the lumen where edge_length_mm is 0, 8 to 64"));
  table.push_back(make_setting("mesh.triangle_budget", c.lumen_mesh.triangle_budget,
                               "most triangles of the lumen, 1000 to 5000000"));
  table.push_back(make_setting("mesh.triangle_count", c.lumen_mesh.triangle_count,
                               "exact number of triangles, with caps on the outlets, even, 1000 to "
                               "1000000; 0: by the edge length"));
  table.push_back(make_setting("mesh.keep", c.lumen_mesh.keep,
                               "keep a given surface's triangles; it must be open at its ends"));
  table.push_back(make_setting("mesh.smoothing_iterations", c.lumen_mesh.smoothing_iterations,
                               "volume-keeping smoothing steps, 0 to 100"));
  table.push_back(make_setting("mesh.extension_diameters", c.lumen_mesh.extension_diameters,
                               "straight tubes on inlet and outlets [diameters], 0 to 20"));
  table.push_back(make_setting("volume.fill", c.fill_lumen,
                               "also fill the lumen with tetrahedra (meshing/lumen.vtu)"));
  table.push_back(make_setting("volume.edge_ratio", c.lumen_volume.edge_ratio,
                               "edges inside over those of the wall, 0.5 to 5"));
  table.push_back(make_setting("volume.tet_budget", c.lumen_volume.tet_budget,
                               "most tetrahedra of the lumen, 1000 to 50000000"));
  table.push_back(make_setting("volume.least_dihedral_degrees",
                               c.lumen_volume.least_dihedral_degrees,
                               "sharper tetrahedra are worked on [degrees], 5 to 25"));
}

void add_placement_settings(Config& c, std::vector<Setting>& table) {
  table.push_back(make_setting("balloon.nominal_diameter_mm", c.balloon.nominal_diameter_mm,
                               "[mm], 0.5 to 30; 0: the reference diameter, to the next 0.25 mm"));
  table.push_back(make_setting("balloon.rest_diameter_mm", c.balloon.rest_diameter_mm,
                               "of the unloaded balloon [mm], 0.5 to 30; 0: its chart's, else "
                               "the nominal one"));
  table.push_back(
      make_setting("balloon.length_mm", c.balloon.length_mm,
                   "of the cylindrical part [mm], 2 to 80; 0: the lesion and 3 mm each side, less "
                   "in a bend"));
  table.push_back(make_setting("balloon.start_diameter_mm", c.balloon.start_diameter_mm,
                               "crossing profile [mm]; 0: by the diameter (0.9 up to 4 mm), less "
                               "where it must pass"));
  table.push_back(
      make_setting("balloon.ends", c.balloon.ends,
                   "cones in necks on the shaft, the distal one free along the wire, or "
                   "hemispheres (the seed paper's), held"));
  table.push_back(make_setting("balloon.folds", c.balloon.folds,
                               "flaps wrapped around the shaft at the start: 2, 3 or 5; 0: folds "
                               "are not meshed"));
  table.push_back(make_setting("balloon.shaft_diameter_mm", c.balloon.shaft_diameter_mm,
                               "of the shaft inside the folds [mm], 0.2 to 10"));
  table.push_back(make_setting("balloon.fold_gap_mm", c.balloon.fold_gap_mm,
                               "between the folds' layers [mm], 0.005 to 0.5"));
  table.push_back(
      make_setting("balloon.ring_count", c.balloon.ring_count, "rings of vertices, 6 to 400"));
  table.push_back(make_setting("balloon.ring_vertex_count", c.balloon.ring_vertex_count,
                               "vertices a ring, 6 to 200"));
  table.push_back(make_setting("balloon.guidewire_node_count", c.balloon.guidewire_node_count,
                               "nodes of the guidewire, 2 to 1000"));
}

void add_material_settings(Config& c, std::vector<Setting>& table) {
  auto& s = c.simulation;
  table.push_back(
      make_setting("balloon.material", s.balloon.name,
                   "pa12 (semi-compliant), pet (non-compliant) or polyurethane (the seed "
                   "paper's)"));
  table.push_back(
      make_setting("balloon.chart", s.balloon.chart,
                   "compliance chart [[atm, mm], ...] that the membrane is made to follow; "
                   "[]: of pa12, that of its diameter (simulation/balloons.toml), if "
                   "neither balloon.c1_mpa nor balloon.rest_diameter_mm is given; "
                   "else the material as it is"));
  table.push_back(make_setting("balloon.c1_mpa", s.balloon.c1_mpa,
                               "Mooney-Rivlin C1 [MPa]; 0: the material's"));
  table.push_back(make_setting("balloon.c2_mpa", s.balloon.c2_mpa,
                               "Mooney-Rivlin C2 [MPa]; 0: the material's"));
  table.push_back(make_setting("balloon.membrane", s.membrane,
                               "automatic (by the start shape), plain, or relaxed (wrinkles carry "
                               "no compression)"));
  table.push_back(make_setting("balloon.wall_mm", s.balloon.wall_mm,
                               "membrane thickness before inflation [mm], 0.001 to 1; 0: by the "
                               "diameter (0.02 at 3 mm)"));
  table.push_back(
      make_setting("balloon.density_g_mm3", s.balloon.density_g_mm3, "[g/mm3]; 0: the material's"));
  table.push_back(make_setting("wall.model", c.wall_model,
                               "layered (a solid of intima, media, adventitia and plaque), or "
                               "shape_matching (the lumen's surface, plastic; the seed paper's)"));
  table.push_back(
      make_setting("wall.plaque", c.plaque,
                   "layered: what it is made of: fibrous, hypocellular, calcified or lipid"));
  table.push_back(make_setting("wall.calcium_from_scan", c.calcium_from_scan,
                               "layered: plaque is calcified where the scan shows it brighter than "
                               "the blood"));
  table.push_back(make_setting("wall.axial_stretch", s.layered_wall.axial_stretch,
                               "layered: in place, of the unloaded wall, 0.9 to 1.5"));
  table.push_back(make_setting("wall.layer_fractions", c.wall_layers.layer_fractions,
                               "layered: shares of intima, media and adventitia in its thickness"));
  table.push_back(make_setting("wall.elements_per_layer", c.wall_layers.elements_per_layer,
                               "layered: elements through each layer, 1 to 8"));
  table.push_back(make_setting("wall.plaque_elements", c.wall_layers.plaque_elements,
                               "layered: elements through the plaque, 2 to 16"));
  table.push_back(make_setting("wall.modulus_kpa", s.wall.modulus_kpa,
                               "circumferential modulus of the diseased wall [kPa], 1 to 1e6"));
  table.push_back(make_setting("wall.thickness_ratio", s.wall.thickness_ratio,
                               "wall thickness / outer diameter, up to 0.45"));
  table.push_back(make_setting("wall.yield_strain", s.wall.yield_strain,
                               "strain at which plastic flow begins, 0 to 10"));
  table.push_back(make_setting("wall.creep_per_s", s.wall.creep_per_s,
                               "rate of plastic flow [1/s], 0 to 1000"));
  table.push_back(make_setting("wall.max_plastic_strain", s.wall.max_plastic_strain,
                               "most plastic strain, 0 to 10"));
  table.push_back(make_setting("wall.foundation_kpa_per_mm", s.wall.foundation_kpa_per_mm,
                               "stiffness of the surrounding tissue [kPa/mm], 0 to 1e5"));
  table.push_back(make_setting("wall.density_g_mm3", s.wall.density_g_mm3, "[g/mm3]"));
  table.push_back(make_setting("wall.shape", s.wall.shape,
                               "what a slab of wall keeps as its plastic shape: linear (stretched) "
                               "or quadratic (also bent, twisted, unevenly widened)"));
  table.push_back(make_setting("wall.shape_beta", s.wall.shape_beta,
                               "quadratic only: share of bending and twist that costs nothing, 0 "
                               "to 1"));
}

void add_guidewire_settings(Config& c, std::vector<Setting>& table) {
  simulation::GuidewireOptions& g = c.simulation.guidewire;
  table.push_back(
      make_setting("guidewire.model", g.model,
                   "none (it holds the balloon's ends), or rod (elastic, it bends in the "
                   "balloon and meets it)"));
  table.push_back(make_setting("guidewire.rest", g.rest,
                               "rod: its unloaded shape, straight or placed (as it lies)"));
  table.push_back(
      make_setting("guidewire.tip", g.tip, "rod: held in its place and direction, or free"));
  table.push_back(make_setting("guidewire.shaft_modulus_mpa", g.shaft_modulus_mpa,
                               "rod: of the shaft around the wire [MPa], 1 to 1e6"));
  table.push_back(make_setting("guidewire.wire_diameter_mm", g.wire_diameter_mm,
                               "rod: and of the shaft's bore [mm], 0.05 to 0.95 of the shaft"));
  table.push_back(make_setting("guidewire.wire_modulus_mpa", g.wire_modulus_mpa,
                               "rod: of the wire in bending [MPa], 0 to 1e6"));
  table.push_back(make_setting("guidewire.density_g_mm3", g.density_g_mm3,
                               "rod: of wire and shaft [g/mm3], 1e-5 to 0.1"));
}

void add_inflation_settings(Config& c, std::vector<Setting>& table) {
  auto& s = c.simulation;
  table.push_back(make_setting("inflation.control", s.inflation.control,
                               "what the inflator prescribes: gas, pressure or volume"));
  table.push_back(make_setting("inflation.deflate_pressure_atm", s.inflation.deflate_pressure_atm,
                               "pressure control: at the end of the deflation [atm], -1 to 0"));
  table.push_back(make_setting("inflation.peak_volume_mm3", s.inflation.peak_volume_mm3,
                               "volume control: at the peak [mm3]; 0: the nominal volume"));
  table.push_back(make_setting("inflation.inflate_s", s.inflation.inflate_s, "[s], up to 600"));
  table.push_back(make_setting("inflation.hold_s", s.inflation.hold_s, "[s], 0 to 600"));
  table.push_back(make_setting("inflation.deflate_s", s.inflation.deflate_s, "[s], up to 600"));
  table.push_back(make_setting("inflation.rest_s", s.inflation.rest_s, "[s], 0 to 600"));
  table.push_back(make_setting("inflation.peak_pressure_atm", s.inflation.peak_pressure_atm,
                               "highest pressure above the outside [atm], up to 40; 0: nominal, by "
                               "the diameter (8 up to 4 mm)"));
  table.push_back(make_setting("inflation.rated_burst_atm", s.inflation.rated_burst_atm,
                               "a higher peak is warned about [atm], up to 100; 0: by the diameter "
                               "(14 up to 4 mm)"));
  table.push_back(make_setting("inflation.outside_pressure_kpa", s.inflation.outside_pressure_kpa,
                               "blood pressure around the balloon [kPa], 0 to 50"));
}

void add_simulation_settings(Config& c, std::vector<Setting>& table) {
  auto& s = c.simulation;
  table.push_back(make_setting("simulation.frame_s", s.frame_s, "time step [s], 0.0001 to 1"));
  table.push_back(make_setting("simulation.tolerance", s.tolerance,
                               "distance from equilibrium that ends a frame, over the balloon's "
                               "start radius, 1e-6 to 0.1"));
  table.push_back(make_setting("simulation.sweeps", s.sweeps,
                               "vertex block descent sweeps a frame, 1 to 1000; 0: by the "
                               "tolerance"));
  table.push_back(make_setting("simulation.contact_distance_mm", s.contact.distance_mm,
                               "contact acts below this gap [mm], 0.001 to 1; 0: by the balloon's "
                               "diameter (0.03 from 2 to 4 mm)"));
  table.push_back(
      make_setting("simulation.self_contact", s.contact.self_contact,
                   "a slack balloon, its meshed folds and the wall around it do not pass "
                   "through themselves"));
  table.push_back(make_setting("simulation.friction_static", s.contact.friction_static, "0 to 2"));
  table.push_back(
      make_setting("simulation.friction_kinetic", s.contact.friction_kinetic, "0 to 2"));
  table.push_back(make_setting("simulation.contact_model", s.contact.model,
                               "barrier, or paper (the seed paper's projections, for comparison: "
                               "does not converge)"));
  table.push_back(make_setting("simulation.gas_model", s.gas_model,
                               "enclosed, or per_tet (the seed paper's, for comparison: volume "
                               "control, no balance of forces)"));
  table.push_back(make_setting("simulation.contact_stiffness", s.contact.stiffness,
                               "factor on the barrier's stiffness, 0.01 to 100"));
  table.push_back(make_setting("simulation.adhesion_traction_kpa", s.contact.adhesion_traction_kpa,
                               "most that the film between wet surfaces holds [kPa], 0 to 100; 0: "
                               "none; -1: by the diameter (2.5 from 2 to 4 mm)"));
  table.push_back(make_setting("simulation.adhesion_gap_1_mm", s.contact.adhesion_gap_1_mm,
                               "surfaces nearer than this have touched [mm], up to 1; 0: by the "
                               "diameter (0.03 from 2 to 4 mm)"));
  table.push_back(make_setting("simulation.adhesion_gap_2_mm", s.contact.adhesion_gap_2_mm,
                               "the film breaks here [mm], above gap 1, up to 2; 0: by the "
                               "diameter (0.06 from 2 to 4 mm)"));
  table.push_back(make_setting("simulation.paper_volume_1_mm3", s.contact.paper_volume_1_mm3,
                               "contact_model paper: V_th1 [mm3], 0 to 100; 0: from the gaps"));
  table.push_back(make_setting("simulation.paper_volume_2_mm3", s.contact.paper_volume_2_mm3,
                               "contact_model paper: V_th2 [mm3], 0 to 100; 0: from the gaps"));
  table.push_back(
      make_setting("simulation.guard", c.guard,
                   "simulate a second time from a start that is moved by 1e-6 mm and "
                   "with 2 % more tolerance, and say whether the result is determined"));
  table.push_back(
      make_setting("simulation.write_every", c.write_every,
                   "solver frames per frame written; first, peak and last always are, 1 to "
                   "10000"));
}

void add_flow_settings(Config& c, std::vector<Setting>& table) {
  table.push_back(
      make_setting("flow.vessel", c.flow_vessel,
                   "coronary, other, or auto: coronary where the input says that it is "
                   "of the heart; elsewhere nothing is called fractional flow reserve"));
  table.push_back(make_setting("flow.aortic_pressure_mmhg", c.flow.aortic_pressure_mmhg,
                               "mean, at the inlet [mmHg], 40 to 200"));
  table.push_back(make_setting("flow.venous_pressure_mmhg", c.flow.venous_pressure_mmhg,
                               "behind the small vessels [mmHg], 0 to 30"));
  table.push_back(make_setting("flow.inlet_flow_ml_min", c.flow.inlet_flow_ml_min,
                               "hyperaemic, of the healthy tree [mL/min], up to 2000; 0: by the "
                               "velocity and the inlet's healthy diameter"));
  table.push_back(make_setting("flow.hyperaemic_velocity_m_s", c.flow.hyperaemic_velocity_m_s,
                               "mean in the healthy inlet [m/s], 0.05 to 2"));
  table.push_back(make_setting("flow.branching_exponent", c.flow.branching_exponent,
                               "n of flow ~ diameter^n at forks (3: Murray), 2 to 4"));
  table.push_back(
      make_setting("flow.viscosity_mpa_s", c.flow.viscosity_mpa_s, "of blood [mPa s], 0.5 to 20"));
  table.push_back(
      make_setting("flow.density_kg_m3", c.flow.density_kg_m3, "of blood [kg/m3], 900 to 1200"));
  table.push_back(make_setting("flow.expansion_coefficient", c.flow.expansion_coefficient,
                               "of the loss behind a throat (1.52: Young and Tsai), 0 to 5"));
  table.push_back(make_setting("flow.diameter_error_mm", c.flow.diameter_error_mm,
                               "standard deviation of diameters [mm], 0 to 2; \"auto\": the "
                               "voxel / sqrt(12), of a surface 0.1"));
  table.push_back(make_setting("flow.flow_error_percent", c.flow.flow_error_percent,
                               "standard deviation of the flow [%], 0 to 90"));
}

void add_view_settings(Config& c, std::vector<Setting>& table) {
  table.push_back(make_setting("view.primary_limit_degrees", c.view.primary_limit_degrees,
                               "how far the C-arm goes to LAO and RAO [degrees], 0 to 180"));
  table.push_back(make_setting("view.secondary_limit_degrees", c.view.secondary_limit_degrees,
                               "how far the C-arm goes to CRA and CAU [degrees], 0 to 90"));
  table.push_back(make_setting("view.overlap_weight", c.view.overlap_weight,
                               "per cent of foreshortening that a per cent of overlap is as bad "
                               "as, 0 to 100"));
  table.push_back(make_setting("view.second_view_degrees", c.view.second_view_degrees,
                               "least angle between best and second view [degrees], 0 to 90"));
}

void add_cloth_settings(Config& c, std::vector<Setting>& table) {
  table.push_back(make_setting("cloth.side_mm", c.cloth.side_mm, "of the square [mm]"));
  table.push_back(make_setting("cloth.cells", c.cloth.cells, "along a side, even, 2 to 1000"));
  table.push_back(
      make_setting("cloth.thickness_mm", c.cloth.thickness_mm, "before it is pulled [mm]"));
  table.push_back(make_setting("cloth.stretch", c.cloth.stretch,
                               "growth of the corners' distance in the end, up to 3"));
  table.push_back(make_setting("cloth.steps", c.cloth.steps, "in which it is pulled, 1 to 10000"));
  table.push_back(
      make_setting("cloth.solver", c.cloth.solver, "newton (double precision) or vbd (single)"));
}

}  // namespace

std::vector<Setting> settings(Config& config) {
  std::vector<Setting> table;
  add_segmentation_settings(config, table);
  add_reconstruction_settings(config, table);
  add_views_settings(config, table);
  add_centerline_settings(config, table);
  add_meshing_settings(config, table);
  add_placement_settings(config, table);
  add_material_settings(config, table);
  add_guidewire_settings(config, table);
  add_inflation_settings(config, table);
  add_simulation_settings(config, table);
  add_flow_settings(config, table);
  add_view_settings(config, table);
  add_cloth_settings(config, table);
  return table;
}

}  // namespace angio::pipeline
