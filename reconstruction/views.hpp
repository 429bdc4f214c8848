#pragma once

#include <array>
#include <vector>

#include "core/progress.hpp"
#include "core/vec3.hpp"
#include "reconstruction/reconstruction.hpp"
#include "reconstruction/tree_fit.hpp"

/// From angiograms of a C-arm that stood still, from two sides or more, to the vessels in space
/// (three-dimensional quantitative coronary angiography).
namespace angio::reconstruction {

/// Where one vessel begins and ends in a view: column, row [pixels], from the middle of the first.
struct VesselEnds {
  std::array<double, 2> proximal{}, distal{};
};

/// The rectangle around what of a picture is not covered.
/// @param covered  shape [rows, columns]; empty: nothing is
/// @return last sides before the first ones where all is
OpenField around_open(const std::vector<char>& covered, int columns, int rows);

struct ViewsOptions {
  /// Of the one vessel that is wanted, one a view, in the run's order; empty: all vessels that the
  /// views tell of.
  std::vector<VesselEnds> ends = {};
  /// Pixels of each view's frame that are no picture (of a shutter, or beside a picture that was
  /// widened), 1, shape [views][rows * columns]; empty, also of a view: none. No vessel is looked
  /// for there, or fitted.
  std::vector<std::vector<char>> covered = {};
  /// Diameter of the thinnest vessel, [0, 5]; a stenosis may be thinner; 0: all that are seen.
  double thinnest_mm = 0.0;
  double widest_mm = 12.0;  ///< and of the widest, above `thinnest_mm`, [1, 40]
  /// How far the table may have moved between views beside what is found of it, and how far the
  /// C-arm stands from its header, sd of each view [mm], [0, 20].
  double shift_sd_mm = 1.0;
  double turn_sd_degrees = 0.0;  ///< [0, 20]
  double voxel_mm = 0.0;         ///< as ReconstructionOptions::voxel_mm
  int largest_side = 512;        ///< as ReconstructionOptions::largest_side
  double max_memory_gib = 0.0;   ///< of the volume, and of the places that may be
                                 ///< vessel, [0, 65536]; 0: what the computer has free

  void validate() const;  ///< @throws OptionError naming the bad field
};

/// Vessels that some views show.
struct TreeOfViews {
  TreeFit fit;  ///< lines and radii with their sd, and where each view was found to be taken
  Volume<float> volume;  ///< attenuation of the contrast medium in the fitted tubes [1/mm]
  double widest_angle_degrees = 0.0;  ///< between two views
  double unattenuated = 0.0;          ///< as RunQuality::unattenuated
  std::vector<Vec3> shifts_mm;        ///< of each view's C-arm against the patient, as found
  /// How far each C-arm was found to be turned from where it says, around the isocentre: axis, as
  /// long as the angle. Empty where it is not looked for: of two views, and with named ends.
  std::vector<Vec3> turns_degrees = {};
  std::vector<double> explained_parts;  ///< of each view's lines that the tree accounts for; of
                                        ///< the one vessel that is wanted, of its own
  /// Of each view's pixels of the one vessel that is wanted, those that other vessels cover: they
  /// are left out of the fit up to a half.
  std::vector<double> hidden_parts = {};
  double agreement = 0.0;  ///< detail/view_shifts.hpp
  double skew_mm = 0.0;    ///< of the views' rays to the same places (detail/view_by_view.hpp)
  bool by_view = false;    ///< each view was measured by itself, for that is over two pixels
  /// Why the tree is not determined: of a whole tree (no ends were named) from two views that
  /// explains less than six tenths of what looks like a vessel in one of them; of one vessel
  /// between whose named ends the views' medium agrees badly. Empty: it is.
  std::string doubt;
  std::vector<std::string> warnings;
};

/// Finds each view's lines (detail/vessel_lines.hpp), by how much the table moved between them
/// (detail/view_shifts.hpp), the tree that explains them (detail/view_tree.hpp), or the one vessel
/// between given ends, and fits it to the pixels of all views at once (fit_tree()), or of each by
/// itself where the vessels moved between them (detail/view_by_view.hpp). Sections are taken as
/// round.
///
/// @param run  one frame a view: the one that is filled the best
/// @throws InputError  fewer than two views, none 30 degrees apart; a view shows no vessel; no
///                     vessel is seen by all of them, or the tree explains too little of the
///                     views to be believed (name one vessel's ends); the volume is too large; as
///                     fit_tree()
TreeOfViews reconstruct_views(const RotationalRun& run, const ViewsOptions& options,
                              const Progress& progress = {});

/// The frames of a standing run that show the most contrast medium.
struct FilledFrames {
  int best = 0;               ///< numbered from 0
  std::vector<double> share;  ///< of the best one's medium, one a frame, [0, 1]; 0: not looked at
};

/// @param run  all frames of one view, from the same place
/// @param options  `covered` of that view alone
/// @param phase  wanted part of the heart's beat, where the run names R waves, [0, 1): of the
///               frames with nine tenths of the most medium the nearest to it
FilledFrames find_filled_frame(const RotationalRun& run, const ViewsOptions& options, double phase);

}  // namespace angio::reconstruction
