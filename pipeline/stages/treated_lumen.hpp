#pragma once

#include <array>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "centerline/centerline.hpp"
#include "core/beside.hpp"
#include "core/centerline.hpp"
#include "core/triangle_mesh.hpp"
#include "pipeline/case/stage_files.hpp"

namespace angio::pipeline {

/// Where minimal diameters and areas are looked for, along the treated path [mm].
struct TreatedSpans {
  /// The lesion's edges, as far as the balloon's cylindrical part goes: where it treats the lesion.
  double lesion_first = 0.0, lesion_last = 0.0;
  double segment_first = 0.0, segment_last = 0.0;  ///< what the balloon reaches, and the lesion
  double untreated_mm = 0.0;                       ///< of the lesion, that the balloon leaves out
  /// Of the balloon's cylindrical part. Beyond it a section looks for its wall farther than the
  /// balloon's tapering end is.
  double cylinder_first = std::numeric_limits<double>::lowest(),
         cylinder_last = std::numeric_limits<double>::max();
};

/// @param placement  meshing/placement.json
TreatedSpans treated_spans(const nlohmann::json& placement);

/// What is told of the lumen at one moment: of the lesion, where it is treated, and of all that
/// the balloon reaches.
struct TreatedMeasures {
  centerline::Tightest lesion, segment;
  std::optional<double> lumen_eccentricity;  ///< of the lesion's section of least area
};

/// The lumen along the treated path, as a frame has it. It is the program's one measure of the
/// lumen in a simulation: metrics, time series, profile, report and viewer get it from here.
class TreatedLumen {
 public:
  /// @param region  index in `lumen` of each vertex of the wall that moves
  /// @param is_kept  a given mesh, perhaps too coarse to be measured on its vertices alone
  TreatedLumen(TriangleMesh lumen, std::vector<int> region, CenterlinePath path,
               const TreatedSpans& spans, double least_radius_mm, bool is_kept);

  /// The lumen is nowhere narrower than a balloon in it: in a crease of the wall, where a section
  /// of it tells little, the balloon's own counts.
  /// @param wall  [mm], shape [region]
  /// @param balloon  its surface's vertices [mm]; empty: there is none
  [[nodiscard]] centerline::LumenProfile profile(const std::vector<Vec3>& wall,
                                                 const std::vector<Vec3>& balloon = {}) const;
  /// Without the eccentricity.
  [[nodiscard]] TreatedMeasures measures(const centerline::LumenProfile& profile) const;
  /// Of the wall's section at a place of the path (SectionWidths::eccentricity); unset: its plane
  /// meets no closed wall.
  [[nodiscard]] std::optional<double> eccentricity(const std::vector<Vec3>& wall,
                                                   double abscissa) const;
  /// The lesion's measure alone, without sections anywhere else: that of measures(profile(...)),
  /// sooner.
  [[nodiscard]] centerline::Tightest lesion(const std::vector<Vec3>& wall,
                                            const std::vector<Vec3>& balloon = {}) const;
  /// The lesion moment after moment (centerline::LumenFollower).
  class LesionFollower;
  /// The whole lumen with the region moved.
  [[nodiscard]] TriangleMesh mesh(const std::vector<Vec3>& wall) const;

 private:
  /// The wall round a point of the path: a vertex of the lumen and its share in the mean.
  struct Share {
    int vertex = 0;
    double weight = 0.0;
  };
  /// The lumen's vertices with the region moved.
  [[nodiscard]] std::vector<Vec3> moved(const std::vector<Vec3>& wall) const;
  void find_shares();
  /// Sections of the mesh as it was made that are far wider than the image's: that took another
  /// vessel or an organ for their wall. Places beside the lesion that have none. And
  /// those that the tube fitted to the wall's points does not tell: as where a neighbour's wall or
  /// a side branch stands beside it.
  void find_mistaken();
  /// What the plane across a path cuts out of the lumen, triangle by triangle.
  struct Cut {
    double area = 0.0;              ///< [mm^2]
    double inscribed_radius = 0.0;  ///< [mm]
    double chord_share = 1.0;       ///< radius of a regular polygon of its corners over its apothem
  };
  /// Nothing where it is not round the path.
  [[nodiscard]] std::optional<Cut> cut_at(const CenterlinePath& path,
                                          const std::vector<Vec3>& lumen, double abscissa) const;
  /// Whether the tube's section is that of the mesh, but for chords and noise.
  [[nodiscard]] static bool tells(const centerline::LumenProfile& seen, std::size_t i,
                                  const Cut& cut);
  /// A profile with what planes cut out of the lumen in place of the tube's, where that was found
  /// not to hold, or holds no more: as where the vessel was opened as far as its neighbours. Places
  /// that the tube has lost are cut; without those that a plane does not cut now.
  /// @param between  abscissas that `seen` was looked for between [mm]
  [[nodiscard]] centerline::LumenProfile with_cuts(const centerline::LumenProfile& seen,
                                                   const CenterlinePath& path,
                                                   const std::vector<Vec3>& lumen,
                                                   std::pair<double, double> between) const;
  /// A lesion that is a single place is measured in one section at all moments: the nearest of
  /// those before.
  void measure_single_place_in(const centerline::LumenProfile& seen);
  [[nodiscard]] centerline::LumenProfile without_mistaken(
      const centerline::LumenProfile& all) const;
  /// The profiles of the wall's points and of the balloon's, if there are any, along one path.
  struct Profiles {
    centerline::LumenProfile wall, balloon;
  };
  using Measure = std::function<Profiles(std::vector<Vec3> wall, const std::vector<Vec3>& balloon,
                                         const CenterlinePath& path)>;
  [[nodiscard]] centerline::LumenProfile profile_of(const std::vector<Vec3>& wall,
                                                    const std::vector<Vec3>& balloon,
                                                    std::pair<double, double> between,
                                                    const Measure& measure) const;
  [[nodiscard]] centerline::LumenProfile profile_between(double first, double last,
                                                         const std::vector<Vec3>& wall,
                                                         const std::vector<Vec3>& balloon) const;
  /// Where the lesion is looked for along the path [mm]: it may be a single place, and the nearest
  /// section lie a little beside it.
  [[nodiscard]] std::pair<double, double> round_lesion() const;
  [[nodiscard]] std::vector<Vec3> points(const std::vector<Vec3>& lumen) const;
  /// The path, taken along by the wall: every point by the mean motion of the wall round it, by
  /// area, out to two radii. A balloon that straightens a bend takes the lumen off its old line.
  [[nodiscard]] CenterlinePath moved_path(const std::vector<Vec3>& lumen) const;

  TriangleMesh lumen_;
  std::vector<int> region_;
  CenterlinePath path_;
  TreatedSpans spans_;
  std::vector<std::array<int, 2>> halved_;  ///< edges whose middles count, too
  std::vector<std::vector<Share>> shares_;  ///< shape [point of the path]
  std::vector<int> near_;                   ///< of vertices and middles: those round the segment
  std::vector<Triangle> near_triangles_;    ///< between vertices of `near_`
  std::set<double> mistaken_;               ///< abscissas [mm] of sections that count at no moment
  std::set<double> cut_;                    ///< of those that planes measure, not the tube
  std::set<double> told_;                   ///< of those that the tube told at the beginning
  std::set<double> branches_;               ///< of those whose planes run along a side branch
};

class TreatedLumen::LesionFollower {
 public:
  explicit LesionFollower(const TreatedLumen& lumen);
  /// As TreatedLumen::lesion, of the moment that comes next.
  centerline::Tightest measure(const std::vector<Vec3>& wall, const std::vector<Vec3>& balloon);

 private:
  const TreatedLumen& lumen_;
  centerline::LumenFollower wall_follower_, balloon_follower_;
  std::vector<Vec3> wall_, balloon_;  ///< as last measured
  centerline::Tightest tightest_;
  Beside beside_;  ///< for the balloon, while the wall is measured
};

/// lumen_profile.csv: a row for each place of the segment; a cell is empty where the section misses
/// the lumen (near a rim).
std::string profile_csv(const centerline::LumenProfile& before,
                        const centerline::LumenProfile& peak,
                        const centerline::LumenProfile& after);

}  // namespace angio::pipeline
