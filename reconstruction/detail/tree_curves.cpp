#include "reconstruction/detail/tree_curves.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.hpp"

namespace angio::reconstruction::detail {
namespace {

constexpr double kLeastRadius = 0.1;  ///< [mm], to begin with
constexpr int kFewestSpans = 3;

SplinePlace uniform_place(double abscissa, double step, int spans) {
  const double along = std::clamp(abscissa / step, 0.0, double(spans));
  SplinePlace place;
  place.first_node = std::min(int(along), spans - 1);
  const double t = along - place.first_node, s = 1.0 - t;
  place.value = {s * s * s / 6.0, (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
                 (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0, t * t * t / 6.0};
  place.slope = {-0.5 * s * s / step, (1.5 * t * t - 2.0 * t) / step,
                 (-1.5 * s * s + 2.0 * s) / step, 0.5 * t * t / step};
  const double square = step * step;
  place.bend = {s / square, (3.0 * t - 2.0) / square, (3.0 * s - 2.0) / square, t / square};
  return place;
}

/// How many of the first points two paths share.
std::size_t shared_points(const CenterlinePath& a, const CenterlinePath& b) {
  std::size_t count = 0;
  while (count < std::min(a.points.size(), b.points.size()) && a.points[count] == b.points[count])
    ++count;
  return count;
}

/// The earlier path that shares the most points with a path, and how many.
std::pair<std::size_t, std::size_t> nearest_relative(const CenterlineTree& tree, std::size_t path) {
  std::pair<std::size_t, std::size_t> best{0, 0};
  for (std::size_t q = 0; q < path; ++q) {
    const std::size_t count = shared_points(tree.paths[path], tree.paths[q]);
    if (count > best.second) best = {q, count};
  }
  return best;
}

/// The points and radii that a curve is made of.
struct Stretch {
  std::vector<Vec3> points;
  std::vector<double> radius;
};

/// Nodes by least squares; a trace of the third differences holds those that no point tells.
void fit_nodes(TreeCurve& curve, const Stretch& stretch, const std::vector<double>& abscissa) {
  constexpr double kHold = 1e-3;
  const int count = int(std::lround(curve.length / curve.node_step)) + 3;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(count, count);
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(count, 4);
  for (std::size_t p = 0; p < stretch.points.size(); ++p) {
    const SplinePlace at = curve.place(abscissa[p]);
    const Eigen::RowVector4d value{stretch.points[p].x, stretch.points[p].y, stretch.points[p].z,
                                   std::log(std::max(stretch.radius[p], kLeastRadius))};
    for (int a = 0; a < 4; ++a) {
      right.row(at.first_node + a) += at.value[std::size_t(a)] * value;
      for (int b = 0; b < 4; ++b)
        normal(at.first_node + a, at.first_node + b) +=
            at.value[std::size_t(a)] * at.value[std::size_t(b)];
    }
  }
  const Eigen::Vector4d third{-1.0, 3.0, -3.0, 1.0};
  for (int n = 0; n + 4 <= count; ++n)
    normal.block(n, n, 4, 4) += kHold * third * third.transpose();
  const Eigen::MatrixXd solved = normal.ldlt().solve(right);
  for (int n = 0; n < count; ++n) {
    curve.node.push_back({solved(n, 0), solved(n, 1), solved(n, 2)});
    curve.log_radius.push_back(solved(n, 3));
  }
}

/// Normals that turn as little as they can along the curve.
void set_normals(TreeCurve& curve) {
  Vec3 normal;
  for (std::size_t n = 0; n < curve.node.size(); ++n) {
    const std::size_t before = n == 0 ? 0 : n - 1, after = std::min(n + 1, curve.node.size() - 1);
    const Vec3 tangent = normalized(curve.node[after] - curve.node[before]);
    const Vec3 carried = normal - dot(normal, tangent) * tangent;
    normal = norm(carried) > 0.1 ? normalized(carried) : any_perpendicular(tangent);
    curve.first_normal.push_back(normal);
    curve.second_normal.push_back(cross(tangent, normal));
  }
}

/// Radii whose points near an end have that of the first beyond them: in a closed end the inscribed
/// one goes to zero, where the vessel's does not.
struct Blanked {
  std::vector<double> radius;
  double length = 0.0;  ///< how far from the end [mm]
};

Blanked blank(std::vector<double> radius, const std::vector<double>& from_end, double end_radius) {
  const double most =
      std::min(end_radius, 0.25 * *std::max_element(from_end.begin(), from_end.end()));
  std::size_t border = 0;
  for (std::size_t p = 0; p < radius.size(); ++p)
    if (from_end[p] >= most && (from_end[border] < most || from_end[p] < from_end[border]))
      border = p;
  for (std::size_t p = 0; p < radius.size(); ++p)
    if (from_end[p] < most) radius[p] = radius[border];
  return {std::move(radius), most};
}

TreeCurve make_curve(Stretch stretch, double node_step, double sample_step, double start_radius,
                     double end_radius) {
  TreeCurve curve;
  const std::vector<double> abscissa = arc_length(stretch.points);
  curve.length = abscissa.back();
  if (!(curve.length > 0.0)) throw InputError("a line of the tree has no length");
  std::vector<double> from_end;
  for (const double along : abscissa) from_end.push_back(curve.length - along);
  Blanked blanked = blank(std::move(stretch.radius), from_end, end_radius);
  curve.blank_end = blanked.length;
  if (start_radius > 0.0) {
    blanked = blank(std::move(blanked.radius), abscissa, start_radius);
    curve.blank_start = blanked.length;
  }
  stretch.radius = std::move(blanked.radius);
  const int spans = std::max(kFewestSpans, int(std::ceil(curve.length / node_step)));
  curve.node_step = curve.length / spans;
  fit_nodes(curve, stretch, abscissa);
  set_normals(curve);
  const int samples = std::max(spans, int(std::ceil(curve.length / sample_step)));
  for (int s = 0; s <= samples; ++s)
    curve.samples.push_back(curve.place(curve.length * s / samples));
  return curve;
}

}  // namespace

SplinePlace TreeCurve::place(double abscissa) const {
  return uniform_place(abscissa, node_step, int(std::lround(length / node_step)));
}

CurvePoint TreeCurve::at(const SplinePlace& place) const {
  CurvePoint point;
  for (std::size_t a = 0; a < 4; ++a) {
    const std::size_t n = std::size_t(place.first_node) + a;
    point.point += place.value[a] * node[n];
    point.tangent += place.slope[a] * node[n];
    point.log_radius += place.value[a] * log_radius[n];
    point.log_slope += place.slope[a] * log_radius[n];
    point.log_bend += place.bend[a] * log_radius[n];
  }
  return point;
}

int TreeCurves::node_count() const {
  std::size_t count = 0;
  for (const TreeCurve& curve : curves) count += curve.node.size();
  return int(count);
}

TreeCurves make_curves(const CenterlineTree& tree, double node_step, double sample_step) {
  ANGIO_EXPECT(node_step > 0.0 && sample_step > 0.0);
  TreeCurves result;
  result.node_step = node_step;
  int first_parameter = 0;
  for (std::size_t p = 0; p < tree.paths.size(); ++p) {
    const CenterlinePath& path = tree.paths[p];
    if (path.points.size() < 2) throw InputError("a line of the tree has fewer than two points");
    const auto [with, shared] = nearest_relative(tree, p);
    std::vector<CurvePlace> places;
    if (shared > 0)
      places.assign(result.places[with].begin(),
                    result.places[with].begin() + std::ptrdiff_t(shared));
    if (shared < path.points.size()) {
      const auto first = std::ptrdiff_t(shared > 0 ? shared - 1 : 0);
      const std::vector<double>& radius = measured_radius(path);
      TreeCurve curve =
          make_curve({{path.points.begin() + first, path.points.end()},
                      {radius.begin() + first, radius.end()}},
                     node_step, sample_step, shared > 0 ? 0.0 : radius_at_end(path, PathEnd::inlet),
                     radius_at_end(path, PathEnd::outlet));
      if (shared > 0) {
        curve.parent = places.back().curve;
        curve.joint = result.curves[std::size_t(curve.parent)].place(places.back().abscissa);
      }
      curve.first_parameter = first_parameter;
      first_parameter += 3 * int(curve.node.size());
      const std::vector<double> along =
          arc_length({path.points.begin() + first, path.points.end()});
      for (std::size_t n = shared > 0 ? 1 : 0; n < along.size(); ++n)
        places.push_back({int(result.curves.size()), along[n]});
      result.curves.push_back(std::move(curve));
    }
    result.places.push_back(std::move(places));
  }
  return result;
}

void move_curves(TreeCurves& curves, const std::vector<double>& step) {
  for (TreeCurve& curve : curves.curves)
    for (std::size_t n = 0; n < curve.node.size(); ++n) {
      const double* by = step.data() + curve.first_parameter + 3 * std::ptrdiff_t(n);
      curve.node[n] += by[0] * curve.first_normal[n] + by[1] * curve.second_normal[n];
      curve.log_radius[n] += by[2];
    }
}

}  // namespace angio::reconstruction::detail
