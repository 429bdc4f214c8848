#pragma once

#include <Eigen/Dense>
#include <array>
#include <vector>

#include "reconstruction/detail/self_calibration.hpp"
#include "reconstruction/detail/tube_projection.hpp"

/// What one frame says about a tree: its pixels near the vessels against a model of them.
///
///     p(pixel) = a way(pixel) + sum_j N_j(s) (b_j + g_j side) + noise
///
/// a: attenuation of the contrast medium [1/mm], the frame's own; way: through the tubes (1: no
/// medium elsewhere); N_j: hats along the curves, some diameters wide; b, g: the background there,
/// and how it rises across the vessel.
namespace angio::reconstruction::detail {

/// A pixel near a vessel.
struct FitPixel {
  int index = 0;
  float value = 0.0F;       ///< line integral
  int first_hat = 0;        ///< it lies between this one and the next
  float next_share = 0.0F;  ///< of the next
  float side = 0.0F;        ///< of the curve, in radii
};

/// Numbers of a frame that are fitted with the tree.
struct FrameState {
  Motion motion;
  double contrast = 0.0;           ///< a [1/mm]
  std::vector<double> background;  ///< b and g of each hat
  double noise = 1.0;              ///< sd of a pixel
};

/// What is known of a C-arm before the frames are seen: a motion of sd 0 is none.
struct MotionPrior {
  double turn_sd = 0.0;   ///< [radians]
  double shift_sd = 0.0;  ///< [mm]
};

/// A frame's pixels that are fitted.
struct FitFrame {
  angiogram::ConeBeamFrame frame;  ///< as given
  std::vector<FitPixel> pixels;    ///< ordered by index
  std::vector<char> wanted;        ///< one a pixel of the frame
  int hat_count = 0;
};

/// Chooses the pixels within reach of a curve, of no open end, and of no tube that the frame sees
/// under 30 degrees from its end.
/// @param line_integrals  shape [rows, columns]
FitFrame choose_pixels(const angiogram::ConeBeamFrame& frame,
                       const std::vector<float>& line_integrals, const SampledCurves& curves,
                       double width_pixels);

/// A frame's part of the normal equations. Parameters of the tree come first, then ln of the box's
/// width; the frame's own ones are eliminated: own = own_start - own_by_tree tree.
struct FrameEquations {
  Eigen::MatrixXd normal;  ///< shape [parameters, parameters]
  Eigen::VectorXd right;
  Eigen::VectorXd own_start;
  Eigen::MatrixXd own_by_tree;
  double cost = 0.0;            ///< sum of Huber's rho of residual / noise, and the prior
  std::vector<float> residual;  ///< one a pixel
};

/// Huber's rho(t) = t^2 below `kHuber`, linear above (Huber, Ann. Math. Stat. 35:73, 1964).
inline constexpr double kHuber = 3.0;

/// @param curves  as they are now
/// @param state   as it is now
FrameEquations frame_equations(const FitFrame& frame, const FrameState& state,
                               const SampledCurves& curves, double width_pixels,
                               const MotionPrior& prior);

/// Moves a frame's own numbers by a step of the tree's.
void move_state(FrameState& state, const FrameEquations& equations, const Eigen::VectorXd& step);

}  // namespace angio::reconstruction::detail
