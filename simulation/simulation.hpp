#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "air_mesh/air_report.hpp"
#include "core/backend.hpp"
#include "core/progress.hpp"
#include "core/tet_mesh.hpp"
#include "core/triangle_mesh.hpp"
#include "simulation/chart.hpp"
#include "simulation/wall.hpp"

namespace angio::simulation {

using angio::Backend;

/// How the balloon's membrane takes compression. `automatic` is `relaxed` where the start shape is
/// folded (it differs from the rest shape), else `plain`.
enum class MembraneModel { automatic, plain, relaxed };

struct BalloonMaterial {
  std::string name = "pa12";   ///< "pa12", "pet" or "polyurethane" fill in the rest
  double c1_mpa = 0.0;         ///< Mooney-Rivlin C1 [MPa], >= 0; 0: the named material's
  double c2_mpa = 0.0;         ///< Mooney-Rivlin C2 [MPa], >= 0
  double wall_mm = 0.02;       ///< membrane thickness H before inflation, [0.001, 1]
  double density_g_mm3 = 0.0;  ///< 0: the named material's
  /// Compliance chart that the balloon alone is to reproduce, by fibres around it; its unloaded
  /// diameter is rest_diameter_mm(chart). Empty: the material as it is.
  std::vector<ChartPoint> chart;
};

/// What a slab of wall can keep as its plastic shape (Mueller 2005, sections 4.2 and 4.3).
enum class WallShape {
  linear,     ///< a stretched one: one 3 x 3 map
  quadratic,  ///< also a bent, twisted or unevenly widened one: one 3 x 9 map
};

struct WallMaterial {
  WallShape shape = WallShape::linear;
  /// Mueller 2005 beta, quadratic only, [0, 1]: share of bending, twist and uneven widening, at the
  /// scale of a slab, that costs nothing.
  double shape_beta = 0.0;
  double modulus_kpa = 1000.0;     ///< circumferential modulus of the diseased wall, [1, 1e6]
  double thickness_ratio = 0.189;  ///< wall thickness / outer diameter (Holzapfel 2005), (0, 0.45)
  /// Mueller 2005 c_yield, [0, 10]: strain below it stays elastic.
  double yield_strain = 0.03;
  /// Mueller 2005 c_creep [1/s], [0, 1000]: what is above yields at this rate, so that a lumen held
  /// for a time T recoils by about exp(-T c) of its widening. 0.4 gives the 20-35 % of diameter
  /// seen after plain balloons (docs/method/simulation.md).
  double creep_per_s = 0.4;
  double max_plastic_strain = 3.0;      ///< Mueller 2005 c_max, [0, 10]
  double foundation_kpa_per_mm = 10.0;  ///< surrounding tissue, [0, 1e5]
  double density_g_mm3 = 1.1e-3;
};

/// What the inflator prescribes: `gas` adds and withdraws gas, as a hand pump does, up to the peak
/// pressure; `pressure` ramps the pressure, as an inflation device's gauge shows it; `volume` ramps
/// the volume, with the pressure as the answer. Gas and volume are stable past a limit point.
enum class InflationControl { gas, pressure, volume };

/// How the wall answers: the layered solid of SimulationModel::layered_wall, where the model has
/// one, or the paper's shape matching on the lumen's surface.
enum class WallModel { shape_matching, layered };

/// How balloon and wall touch: a barrier on exact distances, or the paper's projections of air tets
/// (sections 4.2, 4.3; not convergent, for comparison only).
enum class ContactModel { barrier, paper };

/// Does the guidewire, in the shaft of the balloon's catheter, bend and meet the balloon?
enum class GuidewireModel {
  none,  ///< it is not there: the balloon's fixed vertices stay where they are
  rod,   ///< an elastic rod inside the balloon, to which its fixed vertices are tied
};

/// A guidewire's unloaded shape.
enum class GuidewireRest {
  straight,  ///< it resists being bent into the vessel
  placed,    ///< as it lies at the start: it has settled there
};

/// What holds a guidewire's far end.
enum class GuidewireTip {
  held,  ///< both ends stay in their places and directions
  free,  ///< the near end does, the tip goes where the balloon takes it
};

struct GuidewireOptions {
  GuidewireModel model = GuidewireModel::none;
  GuidewireRest rest = GuidewireRest::straight;
  GuidewireTip tip = GuidewireTip::held;
  double shaft_diameter_mm = 0.6;    ///< 0.59 to 0.69 (Amstutz 2023), [0.2, 10]
  double shaft_modulus_mpa = 900.0;  ///< a polyamide's (De Beule 2008, Gervaso 2008), [1, 1e6]
  double wire_diameter_mm = 0.36;    ///< 0.014 inch, in the shaft's bore; [0.05, 0.95 shaft]
  /// In bending, [0, 1e6]: 9500 is the flexural modulus of a plain wire (Harrison 2011, J Endovasc
  /// Ther 18:797, on 0.035 inch wires).
  double wire_modulus_mpa = 9500.0;
  double density_g_mm3 = 1.1e-3;  ///< of both, [1e-5, 0.1]

  void validate() const;
};

/// What fills the balloon: one gas in the volume it encloses, or the paper's gas of each
/// tetrahedron between its triangles and the guidewire's nodes (section 5.1; volume control, not
/// convergent, for comparison only).
enum class GasModel { enclosed, per_tet };

struct InflationSchedule {
  InflationControl control = InflationControl::gas;
  double inflate_s = 4.0;          ///< at a near constant rate, (0, 600]
  double hold_s = 1.0;             ///< gas, pressure or volume stays, [0, 600]
  double deflate_s = 2.0;          ///< back to the start volume, (0, 600]
  double rest_s = 0.5;             ///< [0, 600]
  double peak_pressure_atm = 8.0;  ///< above the outside, (0, 40]: the most that is applied
  /// What the balloon is rated for, [0, 100]; a higher peak is warned about. 0: not known.
  double rated_burst_atm = 0.0;
  double outside_pressure_kpa = 10.0;  ///< blood, [0, 50] (seed paper 5.1)
  double deflate_pressure_atm = 0.0;   ///< above the outside at the end, `pressure` only, [-1, 0]
  double peak_volume_mm3 = 0.0;        ///< `volume` only, [0, 1e6]; 0: the nominal volume
};

/// Contact of balloon and wall, with each other and with themselves.
struct ContactOptions {
  ContactModel model = ContactModel::barrier;
  double distance_mm = 0.03;  ///< contact acts below this gap, [1e-3, 1]
  /// Of the barrier, times that which carries the peak pressure at half the contact distance,
  /// [0.01, 100].
  double stiffness = 1.0;
  /// Contact of a slack balloon with itself, and of the wall around it with itself: without
  /// friction, barrier only. A balloon alone has it where it starts in folds that are meshed.
  bool self_contact = true;
  double friction_static = 0.2;    ///< the usual value in balloon models, [0, 2]
  double friction_kinetic = 0.15;  ///< [0, 2]
  /// Adhesion of the wet surfaces: the most that a film of blood holds [kPa], [0, 100]; 0: none.
  /// 2.5 is the capillary pressure 2 s / h of a film of h = 0.045 mm, the middle of its gaps, with
  /// the surface tension of blood, s = 55.89 mN/m (Hrncir, Rosina, Physiol. Res. 46 (1997) 319).
  double adhesion_traction_kpa = 2.5;
  double adhesion_gap_1_mm = 0.03;  ///< surfaces nearer than this have touched, [0, 1]
  double adhesion_gap_2_mm = 0.06;  ///< the film breaks here, above gap 1, up to 2
  /// V_th1 and V_th2 of ContactModel::paper [mm^3], [0, 100]; the paper does not give them. Second
  /// 0: a mean wall triangle's area times a third of the two gaps above.
  double paper_volume_1_mm3 = 0.0, paper_volume_2_mm3 = 0.0;
};

struct SimulationOptions {
  BalloonMaterial balloon;
  WallMaterial wall;         ///< of shape matching
  WallOptions layered_wall;  ///< of the layered wall
  InflationSchedule inflation;
  GasModel gas_model = GasModel::enclosed;
  GuidewireOptions guidewire;
  double frame_s = 0.025;    ///< time step, [1e-4, 1]
  double tolerance = 0.005;  ///< distance from equilibrium that ends a frame's sweeps, as a
                             ///< share of the balloon's start radius, [1e-6, 0.1]
  int sweeps = 0;            ///< vertex block descent sweeps a frame, [0, 1000]. 0: from the
                             ///< tolerance; else at least these, up to 6 times as many
                             ///< while the force balance is open
  ContactOptions contact;
  MembraneModel membrane = MembraneModel::automatic;
  Backend backend = Backend::automatic;

  void validate() const;
};

/// A place in the vessel at which a section of the balloon is measured.
struct WatchedPlace {
  Vec3 point;    ///< [mm]
  Vec3 tangent;  ///< of the vessel there
};

/// What does not change while the balloon moves.
struct SimulationModel {
  TriangleMesh balloon;             ///< start shape, closed
  std::vector<Vec3> balloon_rest;   ///< unloaded shape, shape [balloon vertex]
  std::vector<char> balloon_fixed;  ///< tied to the shaft
  /// Of the fixed ones: the distal neck. Without a rod it slides, as one body, along the direction
  /// in which the guidewire ends. Empty: nothing slides.
  std::vector<char> balloon_sliding;
  std::vector<Vec3> guidewire;  ///< nodes from the near end to the tip, inside the balloon
  /// Where it goes on outside, to be drawn: nodes before the first of those inside, and behind the
  /// last; may be empty.
  std::vector<Vec3> guidewire_before, guidewire_behind;
  TriangleMesh wall;             ///< contact region, normals leave the lumen
  std::vector<char> wall_fixed;  ///< shape [wall vertex]
  /// The wall as a solid; without it the wall is shape-matched. Its first vertices are those of
  /// `wall`, further out follow whole copies of them. A column of copies with a held vertex does
  /// not move.
  LayeredWall layered_wall;
  /// Its pre-stress where that is known (prestress_wall), of this wall or of one that nobody could
  /// tell apart from it; null: it is found.
  std::shared_ptr<const WallSolution> wall_seen;
  std::vector<double> wall_abscissa;  ///< along the lesion's line [mm], shape [wall vertex]
  std::vector<int> wall_group;        ///< branch, shape [wall vertex]
  /// Over balloon vertices, then wall vertices; empty: the air is not followed. It is built anew
  /// where nothing else helps, if this program can (air_mesh/build/build_air.hpp).
  std::vector<Tet> air;
  bool rebuild_each_frame = false;   ///< rather than where nothing else helps: for comparison
  double reference_radius_mm = 1.5;  ///< of the healthy vessel at the lesion
  Vec3 measure_point;                ///< where balloon_diameter_mm is watched
  Vec3 measure_tangent;              ///< of the vessel there
  /// Likewise near the ends of the balloon's cylindrical part, the proximal one first; empty: they
  /// are not watched.
  std::vector<WatchedPlace> balloon_ends;
};

enum class Phase { insert, inflate, hold, deflate, rest };
const char* name(Phase phase);

/// What contact did in a frame.
struct ContactMeasures {
  double friction_delta_mm = 0.0;
  double viscous_delta_mm = 0.0;
  int count = 0;          ///< balloon vertices in contact
  double area_mm2 = 0.0;  ///< of the wall, by its vertices under contact pressure
  double max_penetration_mm = 0.0;
};

/// The balloon's membrane, per vertex, weighted by area.
struct MembraneMeasures {
  std::vector<double> thickness_mm, stretch_1, stretch_2;
};

/// One row of timeseries.csv and the state behind it.
struct SimulationFrame {
  int frame = 0;
  double time_s = 0.0;
  Phase phase = Phase::insert;
  double pressure_atm = 0.0;  ///< above the outside
  double balloon_volume_mm3 = 0.0;
  /// 2 sqrt(area / pi) of the balloon's section through measure_point across its own axis
  double balloon_diameter_mm = 0.0;
  std::vector<double> end_diameters_mm;  ///< the same at model.balloon_ends
  ContactMeasures contact;
  air_mesh::AirReport air;  ///< since the last frame
  double residual = 0.0;    ///< of the force balance, relative
  double lag = 0.0;         ///< estimated distance from equilibrium over the start radius
  int sweep_count = 0;
  std::vector<Vec3> balloon;  ///< positions [mm]
  std::vector<Vec3> wall;
  /// Nodes inside the balloon: of GuidewireModel::rod; without one it is drawn as the smoothest
  /// curve that stays inside
  std::vector<Vec3> guidewire;
  MembraneMeasures membrane;
  std::vector<double> plastic_strain, contact_pressure_kpa;  ///< wall, per vertex
  std::vector<Vec3> layered_wall;  ///< positions of the solid's vertices [mm]
  /// Stress and strain of the solid's wedges, found when it is called: few frames are asked. Empty
  /// without a layered wall.
  std::function<std::vector<WallStress>()> wall_stress;
};

/// Where the time of a run goes [s].
struct TimeSplit {
  double solver = 0.0;   ///< steps and the search for contact; of it, in the steps:
  double pairs = 0.0;    ///< search for near pairs, renewal of what they and the wall are in
  double balloon = 0.0;  ///< sweeps over it
  double wall = 0.0;     ///< sweeps over it
  double rest = 0.0;     ///< beginning and end
  double air = 0.0;      ///< the air mesh follows, beside the solver
  double outputs = 0.0;  ///< a frame's fields and measures, beside the solver: all threads' sum
  double wire = 0.0;     ///< the drawn wire follows, beside the solver
  double files = 0.0;    ///< in on_frame, beside the solver
  double waiting = 0.0;  ///< of the solver for what is done beside it
};

struct SimulationSummary {
  std::string backend;  ///< "cpu" or "cuda"
  std::string device;   ///< processor or GPU name
  int frame_count = 0;
  double simulated_s = 0.0;
  double wall_s = 0.0;
  TimeSplit time;
  double peak_pressure_atm = 0.0;
  double peak_diameter_mm = 0.0;
  int peak_frame = 0;
  double max_penetration_mm = 0.0;
  int inverted_air_tets = 0;          ///< in the worst frame
  int frames_without_air = 0;         ///< without a whole air mesh
  double air_left_out_percent = 0.0;  ///< of the gap's volume, in the worst frame with a whole one
  int flip_count = 0;                 ///< of the air mesh, in all frames
  int air_rebuild_count = 0;
  double worst_residual = 0.0;
  double mean_sweeps = 0.0;           ///< a frame
  int open_frames = 0;                ///< that ended before they had converged
  double worst_pressure_ratio = 0.0;  ///< of a patch of wall, over the peak pressure: SuccessWatch
  /// Why this is no result: what happened, where, the likely cause, what to try. Empty: it is one.
  std::string failure;
  std::vector<std::string> warnings;
};

/// What simulations can run on.
struct CudaSupport {
  bool built = false;  ///< the program has the CUDA backend
  std::string device;  ///< the GPU that it would use; empty: none that works
};
CudaSupport cuda_support();

/// Inflates, holds, deflates. `on_frame` gets every frame in order, while the next one is computed:
/// from another thread, one call at a time, all of them before this returns.
///
/// @param has_spare_thread  where the solver has one thread only frames are completed and handed
///                          over between two steps, unless there is one to spare
SimulationSummary simulate(const SimulationModel& model, const SimulationOptions& options,
                           const std::function<void(const SimulationFrame&)>& on_frame,
                           const Progress& progress = {}, bool has_spare_thread = false);

/// The gap that contact keeps where balloon and wall touch: the mean distance of the wall's
/// vertices from the balloon's triangles, weighted by the force on them.
///
///     g = sum p_i A_i d_i / sum p_i A_i
///
/// @return [mm]; 0 where nothing touches
double contact_gap_mm(const SimulationModel& model, const SimulationFrame& frame);

}  // namespace angio::simulation
