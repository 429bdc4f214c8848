#pragma once

#include <array>
#include <vector>

#include "core/centerline.hpp"

/// A tree of lines as smooth curves with smooth radii, which a few numbers move.
namespace angio::reconstruction::detail {

/// The weights of four nodes at a place on a uniform cubic B-spline (de Boor, A Practical Guide to
/// Splines, 2001, ch. IX): those of its value, and of its first and second derivative by arc
/// length.
struct SplinePlace {
  int first_node = 0;
  std::array<double, 4> value{}, slope{}, bend{};
};

/// What a curve has at a place.
struct CurvePoint {
  Vec3 point;                              ///< LPS [mm]
  Vec3 tangent;                            ///< by the parameter, near unit length
  double log_radius = 0.0;                 ///< of the section at right angles, ln [mm]
  double log_slope = 0.0, log_bend = 0.0;  ///< its derivatives by the parameter [1/mm], [1/mm^2]
};

/// A line that is a curve of its own: the tree's first, or another from where it leaves an earlier
/// one.
struct TreeCurve {
  double length = 0.0, node_step = 1.0;  ///< [mm]
  // Of each node.
  std::vector<Vec3> node;
  std::vector<double> log_radius;
  std::vector<Vec3> first_normal, second_normal;  ///< a node moves along these alone: to slide
                                                  ///< along its curve changes nothing
  std::vector<SplinePlace> samples;               ///< evenly from 0 to length
  int first_parameter = 0;                        ///< three to a node
  double blank_start = 0.0, blank_end = 0.0;      ///< of closed ends that no tube fills [mm]
  int parent = -1;                                ///< the curve that it leaves; -1: none
  SplinePlace joint;                              ///< where on it

  [[nodiscard]] SplinePlace place(double abscissa) const;
  [[nodiscard]] CurvePoint at(const SplinePlace& place) const;
};

/// A point of a path of the tree that the curves were made of.
struct CurvePlace {
  int curve = 0;
  double abscissa = 0.0;
};

struct TreeCurves {
  std::vector<TreeCurve> curves;
  std::vector<std::vector<CurvePlace>> places;  ///< shape [paths][points]
  double node_step = 1.0;                       ///< [mm], at most
  [[nodiscard]] int node_count() const;
};

/// Curves through a tree's points and measured radii.
///
/// @param node_step  of nodes [mm], > 0; shorter where a curve would have too few
/// @param sample_step  [mm], > 0
/// @throws InputError  a line has fewer than two points
TreeCurves make_curves(const CenterlineTree& tree, double node_step, double sample_step);

/// Moves nodes and radii.
/// @param step  three numbers a node: along both normals [mm], ln radius
void move_curves(TreeCurves& curves, const std::vector<double>& step);

}  // namespace angio::reconstruction::detail
