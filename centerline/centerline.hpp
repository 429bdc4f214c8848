#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/centerline.hpp"
#include "core/progress.hpp"
#include "core/triangle_mesh.hpp"
#include "core/volume.hpp"

namespace angio::centerline {

struct CenterlineOptions {
  std::optional<Vec3>
      inlet_lps_mm;  ///< of the tree there; unset: told by the tree (detail/inlet.hpp)
  std::vector<Vec3>
      outlets_lps_mm;     ///< empty: every other end; else trees without one are left out
  double step_mm = 0.0;   ///< distance of points, (0, 5]; 0: a quarter of the radius
  double voxel_mm = 0.0;  ///< longest edge of the voxels that a level set was found in; 0: its own
  double min_branch_length_mm = 0.0;  ///< shorter side branches are spurs; 0: by the radius
  /// Throats of a surface that are narrower count as shut, as nothing crosses them, >= 0. Wider
  /// ones are followed however thin, down to a quarter of a voxel (detail/open_throats.hpp).
  double least_throat_mm = 0.0;

  void validate() const;  ///< @throws OptionError naming the field
};

/// How the warnings begin that another end may be the inlet: of a tree, and of a vessel's two ends.
inline constexpr const char* kUncertainInlet = "the inlet is not certain";
inline constexpr const char* kEitherEnd = "of the vessel's two ends either may be the inlet";

struct CenterlineResult {
  /// With radii, sections, tracts; at least one path. Of a lumen in several pieces the lines of
  /// several trees, the largest piece's first (core/centerline_trees.hpp).
  CenterlineTree tree;
  int tree_count = 0;
  double beside_largest = 0.0;        ///< share of the lumen outside of its largest piece, [0, 1)
  double left_out = 0.0;              ///< share of the lumen in pieces without a line, [0, 1)
  std::vector<std::string> warnings;  ///< loops that were cut, contacts, pieces left out
};

/// The lines of a segmented lumen: a tree for each of its pieces of at least 5 % of the largest.
/// @param level_set signed distance [mm], negative inside
/// @throws InputError if nothing tubular is in it
CenterlineResult extract_centerline(const Volume<float>& level_set,
                                    const CenterlineOptions& options,
                                    const Progress& progress = {});

/// The same from a closed or open triangle surface.
CenterlineResult extract_centerline(const TriangleMesh& surface, const CenterlineOptions& options,
                                    const Progress& progress = {});

/// Lumen along one path of a surface whose shape may have changed since the path was found: at
/// each of the path's points, the inscribed radius (the centre may move within the section, up to
/// the radius) and the section's area.
struct LumenProfile {
  std::vector<double> abscissa;          ///< [mm]
  std::vector<double> inscribed_radius;  ///< [mm], freed of surface noise
  std::vector<double> section_area;      ///< [mm^2]
};
/// Points outside [first_abscissa, last_abscissa] [mm] are left out.
LumenProfile measure_lumen(const TriangleMesh& surface, const CenterlinePath& path,
                           double first_abscissa, double last_abscissa);
/// The same of the points of a wall, each once. @param wall [mm], without caps
LumenProfile measure_lumen(std::vector<Vec3> wall, const CenterlinePath& path,
                           double first_abscissa, double last_abscissa);

/// Measures a lumen between two abscissas [mm] moment after moment, while its wall moves. The first
/// moment is measured by measure_lumen; each later one begins with the middle line and the radii of
/// the one before, and chooses how finely to look at fewer places, in a fraction of the time.
class LumenFollower {
 public:
  LumenFollower(double first_abscissa, double last_abscissa);
  ~LumenFollower();
  LumenFollower(LumenFollower&&) noexcept;
  LumenFollower& operator=(LumenFollower&&) noexcept;

  /// @param wall  [mm], without caps
  /// @param path  as it is at this moment; of the same points at each
  LumenProfile measure(std::vector<Vec3> wall, const CenterlinePath& path);

 private:
  struct Seen;
  double first_abscissa_, last_abscissa_;
  std::unique_ptr<Seen> seen_;  ///< null: nothing yet
};

/// Leaves out single sections that took something else for their wall: narrower than both
/// neighbours allow, r_i < r_j - |s_i - s_j| [mm]. A web thinner than one step of the profile is
/// lost, too.
LumenProfile without_disproved(const LumenProfile& seen);

/// The program's one minimal lumen diameter and area: over the profile's places between two
/// abscissas of the treated path, or over the place nearest to them where there is none.
struct Tightest {
  double mld_mm = 0.0;           ///< twice the least inscribed radius
  double mla_mm2 = 0.0;          ///< the least section area
  double mla_abscissa_mm = 0.0;  ///< where that is
};
/// Between two abscissas [mm]. @throws InputError if the profile is empty
Tightest tightest_between(const LumenProfile& profile, double first_abscissa, double last_abscissa);

struct LesionOptions {
  int centerline = -1;                 ///< path id to look at; -1: the whole tree
  double abscissa_mm = -1.0;           ///< place on it; -1: the tightest stenosis
  double min_stenosis_percent = 30.0;  ///< less is no stenosis, [10, 90]
  double min_reference_mm = 1.0;       ///< no balloon is made for thinner vessels, [0, 30]
  /// Edge of the voxels that the lumen was seen in, >= 0; 0: its wall is exact. In vessels under
  /// three voxels wide neither a diameter nor a stenosis can be told.
  double voxel_mm = 0.0;
  /// Edge [mm] of the triangles that the wall within a reach [mm] around a place is made of; unset:
  /// its wall is exact. They are chords of a wall that may be wider: a narrowing that need not be
  /// one of min_stenosis_percent is not listed.
  std::function<double(const Vec3& place, double reach)> edge_mm = nullptr;
  /// The scan's value at a place, LPS [mm]; unset: there is no scan, or one of labels. What lies on
  /// both sides of a stenosis is the same blood (detail/blood.hpp).
  std::function<double(const Vec3& place)> intensity = nullptr;

  void validate() const;
};

/// What a narrowing may be that is not listed for it.
enum class Doubt {
  none,
  faint,            ///< a vessel that is thin there by itself, or errors of its diameters
  crowded,          ///< a place where vessels touch, by chance narrow, in a large tree
  beside_no_tube,   ///< a neck of an organ or of a sac
  heart,            ///< one of its valves, or vessels beyond it
  at_beginning,     ///< the end of an image, or of its signal, or of a surface that ends closed
  at_end,           ///< likewise
  bead,             ///< one of many on a string: a ragged surface, or fibromuscular dysplasia
  bridge,           ///< a few voxels or triangles that join two vessels where they touch
  diffuse,          ///< a thin vessel with wide ends
  beyond_aneurysm,  ///< of a line's end whose healthy width is known from beyond an aneurysm alone
  wide_sides,       ///< half as wide as the same vessel before and behind it, but hardly narrower
                    ///< than the healthy tree
  other_blood,  ///< not between two pieces of one vessel: what it joins is not equally bright, or
                ///< not even
};

struct Lesion {
  bool is_stenosis = false;   ///< false: no stenosis, and this is a place for a trial, narrow and
                              ///< with room for a balloon, of the longest vessel (or where the
                              ///< user said)
  bool is_too_small = false;  ///< it would be one, but its vessel is under min_reference_mm wide,
  bool is_too_thin = false;   ///< or the data are too coarse to measure it,
  Doubt doubt = Doubt::none;  ///< or it may be something else
  int path_id = 0;
  double abscissa_mm = 0.0;  ///< of the MLD, or where the user said
  double proximal_mm = 0.0;  ///< abscissas of the lesion's edges: where the stenosis is 20 %;
  double distal_mm = 0.0;    ///< both abscissa_mm when it is less everywhere
  double mld_mm = 0.0;       ///< 2 x the least inscribed radius, freed of single points' errors,
                             ///< of places that are narrowed by min_stenosis_percent, by half, if
                             ///< any is
  double mla_mm2 = 0.0;      ///< least section area, perhaps beside the MLD
  double reference_diameter_mm = 0.0;  ///< by reference_rule: the same number
  std::string reference_rule;          ///< "tree", "sides", "vessel" or "ends"
  /// Healthy diameter where the MLD is by the best healthy tree (find_reference).
  double reference_tree_mm = 0.0;
  /// The straight line through the healthy diameters of the same branch within five diameters
  /// before and behind the lesion, read where the MLD is; 0 unless a diameter is healthy on either
  /// side.
  double reference_interpolated_mm = 0.0;
  double reference_proximal_mm = 0.0;  ///< median of the healthy diameters within three diameters
  double reference_distal_mm = 0.0;    ///< before and behind the edges; 0 where there are none
  double reference_average_mm = 0.0;   ///< the mean of both, or of the one there is; 0: neither
  /// The mean of the widest places of the same branch within three diameters before and behind the
  /// edges, healthy or not (their 0.9 quantiles); 0 unless both are seen over a diameter.
  double widest_beside_mm = 0.0;
  /// The widest that the same branch is both before and behind the tightest place, at two places no
  /// farther apart than six such diameters; else the diameter there. Far less than the reference
  /// where a throat lies in a thin stretch. 0 within one and a half diameters of the branch's end.
  double beside_throat_mm = 0.0;
  double diameter_stenosis_percent = 0.0;  ///< 100 (1 - mld / reference)
  double area_stenosis_percent = 0.0;      ///< 100 (1 - mla / (pi / 4 reference^2))
  double length_mm = 0.0;                  ///< distal_mm - proximal_mm
  /// By how much a healthy tree that is as thin there explains all diameters worse: the natural
  /// logarithm of the odds. 0 where no stenosis is listed.
  double evidence = 0.0;

  /// Against the widest places before and behind it; 0 where they are not seen.
  [[nodiscard]] double percent_of_sides() const {
    return widest_beside_mm > 0.0 ? 100.0 * (1.0 - mld_mm / widest_beside_mm) : 0.0;
  }
  /// Whether the vessel is over a quarter wider before and behind it than its reference.
  [[nodiscard]] bool has_wide_sides() const {
    return widest_beside_mm >= 1.25 * reference_diameter_mm;
  }
  /// Whether the reference is over a third wider than the vessel right beside the tightest place.
  [[nodiscard]] bool is_in_thin_vessel() const {
    return beside_throat_mm > 0.0 && beside_throat_mm < 0.75 * reference_diameter_mm;
  }
  [[nodiscard]] bool is_doubtful() const { return doubt != Doubt::none; }
  [[nodiscard]] bool is_left_out() const { return is_too_small || is_too_thin || is_doubtful(); }
};

/// Every stenosis of at least min_stenosis_percent, the most severe first, each once though several
/// paths run through it.
///
/// The reference is that of the best healthy tree (centerline/detail/reference.hpp). A dip below it
/// is listed if neither a healthy tree that is as thin there nor the diameters' errors explain it
/// (in one vessel as well; open to both sides among six branches or more, at odds of seven to one);
/// in a tree whose lines pass from vessel to vessel, where vessels touch or a loop was cut, and in
/// one of more than 25 branches, the evidence for it has to be as much stronger as there are more
/// places to be misled by. There no narrowing of a vessel over 25 mm wide is listed (a heart's
/// valve), and none beyond the heart: where a vessel over 25 mm wide has lost half of its reference
/// on the way, or has fallen to half of its width and is over 25 mm wide again. None is listed
/// that its line begins or ends in, tightest within a diameter of that end, where an image ends
/// there (voxel_mm > 0) or the lumen is closed (the ball at the tip is under half as wide as in
/// the narrowing, or under a tenth of the healthy width). None is listed beside a lumen that is no
/// tube, as an organ's or a sac's: the largest circle fills less than two fifths of the sections;
/// and none where the width swings to and fro, by 1.35 each time, more than six times within eight
/// healthy diameters to both sides; and none whose reference is more than 1.5 times as wide as the
/// healthy vessel on both sides. Where nothing is measured before a narrowing, or behind it, the
/// odds have to be e to one; e^2 to one if an aneurysm lies between it and the healthy vessel on
/// its other side. None is listed in a scan whose two sides are not the same blood
/// (detail/blood.hpp). None of that where `centerline` names a line. Half of the width or more does
/// not go missing without a word where the vessel is seen before and behind: told (Doubt::faint),
/// whatever the odds.
///
/// Stenoses are apart where the vessel between them is back above the edges' 20 %; a branching,
/// where nothing is measured, does not part them along the wider daughter. A narrowing whose area
/// falls by less than half the percentage that its diameter does is none. A neck may be a bridge
/// between vessels that touch (told where half of the width is missing, listed only if `centerline`
/// names its line) if it is
/// shorter than half its reference diameter, or than 1.25 of them where the line turns round it by
/// more than 80 degrees out of one vessel and into another; and if within 1.25 diameters a vessel
/// about as wide (0.6) parts from the line and passes it by.
/// Where there is none, one entry with is_stenosis = false. Then those that are left out
/// (is_left_out).
std::vector<Lesion> find_lesions(const CenterlineTree& tree, const LesionOptions& options);

/// Every stenosis of the whole tree that does not overlap one of them, wherever the options look.
std::vector<Lesion> stenoses_beside(const CenterlineTree& tree, const Lesion& one,
                                    const LesionOptions& options);

}  // namespace angio::centerline
