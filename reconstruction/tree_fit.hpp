#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/centerline.hpp"
#include "core/progress.hpp"
#include "reconstruction/reconstruction.hpp"

namespace angio::reconstruction {

struct TreeFitOptions {
  /// Between the places where a line may bend and its radius change [mm], [0.2, 10]; 0: half the
  /// mean radius, at least a pixel at the isocentre.
  double node_spacing_mm = 0.0;
  /// By how much each frame may have been taken from elsewhere than it says: shift of the C-arm
  /// along each axis [mm], [0, 20], and turn around each [degrees], [0, 20], sd; 0: it says the
  /// truth.
  double frame_shift_sd_mm = 0.1;
  double frame_turn_sd_degrees = 0.0;
  int most_steps = 40;  ///< [1, 1000]
  /// Pixels of each frame that show something else and are not fitted, shape [frames][rows *
  /// columns]; empty, also of a frame: none.
  std::vector<std::vector<char>> left_out = {};

  void validate() const;  ///< @throws OptionError naming the bad field
};

/// A tree, fitted to all frames at once.
struct TreeFit {
  /// The tree with new points and radii: `equivalent_radius` of the section at right angles,
  /// `inscribed_radius` and `tube_radius` of the ball within the tube.
  CenterlineTree tree;
  std::vector<std::vector<double>> radius_sd;    ///< of `tube_radius` [mm], shape [paths][points]
  std::vector<angiogram::ConeBeamFrame> frames;  ///< where they were found to be
  std::vector<double>
      contrast_per_mm;         ///< attenuation of the medium above what it replaces, a frame
  double noise = 0.0;          ///< sd of a line integral beside the model, mean over the frames
  double correlation = 1.0;    ///< by how much neighbours' residuals agree: the variance of a sum
                               ///< over that of independent ones, >= 1; it widens `radius_sd`
  double blur_pixels = 0.0;    ///< width of the box by which pixels see the vessel
  double place_sd_mm = 0.0;    ///< smoothness found: of third differences of nodes
  double log_radius_sd = 0.0;  ///< of second differences of ln radius
  int steps = 0;
  bool converged = false;
};

/// How many of its radii have no standard deviation: none that is a number.
std::size_t radii_without_sd(const TreeFit& fit);

/// Fits centreline and radii of a tree to all frames at once (Gauss-Newton, damped after Levenberg
/// and Marquardt):
///
///     min  sum over frames f, pixels q near the tree   rho((p - a_f way(q) - b_f(q)) / sigma_f)
///          + sum over nodes (D3 x)^2 / sd_x^2 + (D2 ln r)^2 / sd_r^2
///          + sum over frames |turn|^2 / sd_t^2 + |shift|^2 / sd_s^2
///
/// p: line integrals; way: through tubes of round section around cubic B-splines, blurred by a box
/// whose width is fitted (detail/tube_chord.hpp); a_f: the medium's attenuation, so that what is
/// dark tells depth (densitometry) where it is sharp at the edges (silhouette); b_f: background,
/// linear across the vessel and along pieces of three diameters (detail/fit_equations.hpp); rho:
/// Huber's; D: differences between nodes, whose spreads are those of the greatest evidence
/// (detail/smoothness.hpp). The radii's sd come from the inverse normal matrix.
///
/// @param run    frames and pictures as reconstruct_volume() takes them; `frames` where they were
///               found to be (Reconstruction::frames). No arc is needed: two frames will do
/// @param air    RunQuality::unattenuated; of no matter where the run has masks
/// @param start  lines at most about a radius off
/// @throws InputError  no frame sees the tree, or none with contrast medium in it
TreeFit fit_tree(const RotationalRun& run, double air, const CenterlineTree& start,
                 const TreeFitOptions& options, const Progress& progress = {});

}  // namespace angio::reconstruction
