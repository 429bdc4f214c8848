#include "reconstruction/detail/view_shifts.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace angio::reconstruction::detail {
namespace {

constexpr double kBin = 0.25;   ///< [mm] at the isocentre
constexpr double kFar = 120.0;  ///< from the isocentre [mm]
constexpr double kMost = 30.0;  ///< shift that is looked for [mm]
constexpr double kWorthIt = 0.03;
constexpr double kBlur = 1.0;  ///< sd of a profile's blur [mm]

/// Planes through two sources, by their angle around the line between them.
struct Planes {
  Vec3 origin;         ///< a source
  Vec3 along, across;  ///< unit, at right angles to the line: towards the isocentre, and beside it
  double away = 0.0;   ///< of the isocentre from the line [mm]
};

Planes planes_between(const Vec3& a, const Vec3& b) {
  const Vec3 line = normalized(b - a);
  const Vec3 to_middle = -a - dot(-a, line) * line;
  Planes planes;
  planes.origin = a;
  planes.away = norm(to_middle);
  planes.along = to_middle / std::max(planes.away, 1e-9);
  planes.across = cross(line, planes.along);
  return planes;
}

/// Which plane a ray lies in [mm] at the isocentre.
double plane_of(const Planes& planes, const ViewPicture& view, double column, double row) {
  const Vec3 ray = view.frame.place(column, row) - view.frame.source;
  return planes.away * std::atan2(dot(ray, planes.across), dot(ray, planes.along));
}

/// What a view shows of the medium, plane by plane.
std::vector<double> profile(const ViewPicture& view, const Planes& planes) {
  constexpr float kBeside = 1.3F;  // radii
  const int bins = int(2.0 * kFar / kBin);
  std::vector<double> sums(std::size_t(bins), 0.0);
  for (int r = 0; r < view.frame.rows; ++r)
    for (int c = 0; c < view.frame.columns; ++c) {
      const std::size_t i = std::size_t(r) * std::size_t(view.frame.columns) + std::size_t(c);
      if (view.nearest[i] < 0 ||
          view.distance[i] > kBeside * view.lines.radius[std::size_t(view.nearest[i])])
        continue;
      const double y = plane_of(planes, view, c, r) / kBin + 0.5 * bins;
      const int bin = int(std::floor(y));
      if (bin < 0 || bin + 1 >= bins) continue;
      const double value = std::max(0.0, double(view.vessels[i]));
      sums[std::size_t(bin)] += (1.0 - (y - bin)) * value;
      sums[std::size_t(bin) + 1] += (y - bin) * value;
    }
  return sums;
}

std::vector<double> blurred(const std::vector<double>& values) {
  const int half = int(std::ceil(3.0 * kBlur / kBin));
  std::vector<double> smooth(values.size(), 0.0);
  for (int n = 0; n < int(values.size()); ++n)
    for (int k = -half; k <= half; ++k)
      if (n + k >= 0 && n + k < int(values.size()))
        smooth[std::size_t(n)] +=
            values[std::size_t(n + k)] * std::exp(-0.5 * k * k * kBin * kBin / (kBlur * kBlur));
  return smooth;
}

/// Pearson's, of a(y) and b(y + shift), where both are within reach.
double correlation(const std::vector<double>& a, const std::vector<double>& b, int shift) {
  double sa = 0.0, sb = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;
  int count = 0;
  for (int n = 0; n < int(a.size()); ++n) {
    if (n + shift < 0 || n + shift >= int(b.size())) continue;
    const double x = a[std::size_t(n)], y = b[std::size_t(n + shift)];
    sa += x, sb += y, aa += x * x, bb += y * y, ab += x * y;
    ++count;
  }
  const double n = std::max(1, count);
  const double spread =
      std::sqrt(std::max(0.0, aa - sa * sa / n) * std::max(0.0, bb - sb * sb / n));
  return spread > 0.0 ? (ab - sa * sb / n) / spread : 0.0;
}

/// What two views say of the second one's shift.
struct PairShift {
  Vec3 across;      ///< unit: a shift along it is seen
  double mm = 0.0;  ///< of the second view's picture
  double as_given = 0.0, best = 0.0;
};

/// Where the profiles' shift is looked for [mm].
struct Window {
  double middle = 0.0, half = kMost;
};

PairShift pair_shift(const ViewPicture& a, const ViewPicture& b, const Planes& planes,
                     const Window& window) {
  const std::vector<double> pa = blurred(profile(a, planes)), pb = blurred(profile(b, planes));
  PairShift pair{planes.across, 0.0, correlation(pa, pb, 0), 0.0};
  pair.best = pair.as_given;
  const int middle = int(std::lround(window.middle / kBin)), half = int(window.half / kBin);
  if (std::abs(window.middle) > window.half) pair.best = -1.0;
  for (int shift = middle - half; shift <= middle + half; ++shift)
    if (const double found = correlation(pa, pb, shift); found > pair.best) {
      pair.best = found;
      pair.mm = shift * kBin;
    }
  if (pair.best < pair.as_given + kWorthIt) {
    pair.mm = 0.0;
    pair.best = pair.as_given;
  }
  return pair;
}

}  // namespace

ViewShifts find_view_shifts(const std::vector<ViewPicture>& views,
                            const std::vector<VesselEnds>& ends) {
  // A shift of a centimetre is nothing rare; a profile tells one to about a millimetre.
  constexpr double kOfShift = 1.0 / (10.0 * 10.0);
  const auto count = Eigen::Index(views.size()) - 1;
  Eigen::MatrixXd normal = kOfShift * Eigen::MatrixXd::Identity(3 * count, 3 * count);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(3 * count);
  ViewShifts result;
  result.agreement = result.agreement_as_given = 1.0;
  for (std::size_t b = 1; b < views.size(); ++b) {
    double best = -1.0, as_given = -1.0;
    for (std::size_t a = 0; a < b; ++a) {
      const Planes planes = planes_between(views[a].frame.source, views[b].frame.source);
      Window window;
      if (!ends.empty()) {
        constexpr double kEndsErr = 4.0;  // [mm]
        const auto apart = [&](const std::array<double, 2>& in_a,
                               const std::array<double, 2>& in_b) {
          return plane_of(planes, views[b], in_b[0], in_b[1]) -
                 plane_of(planes, views[a], in_a[0], in_a[1]);
        };
        const double proximal = apart(ends[a].proximal, ends[b].proximal),
                     distal = apart(ends[a].distal, ends[b].distal);
        window = {0.5 * (proximal + distal), kEndsErr};
        result.ends_apart_mm = std::max(result.ends_apart_mm, std::abs(proximal - distal));
      }
      const PairShift pair = pair_shift(views[a], views[b], planes, window);
      best = std::max(best, pair.best);
      as_given = std::max(as_given, pair.as_given);
      // The patient's picture lies at +mm in b: b's C-arm stands at -mm from where it says.
      Eigen::VectorXd row = Eigen::VectorXd::Zero(3 * count);
      const Eigen::Vector3d across{pair.across.x, pair.across.y, pair.across.z};
      row.segment(3 * (Eigen::Index(b) - 1), 3) = across;
      if (a > 0) row.segment(3 * (Eigen::Index(a) - 1), 3) = -across;
      const double weight = std::max(0.0, pair.best);
      normal += weight * row * row.transpose();
      right -= weight * pair.mm * row;
    }
    result.agreement = std::min(result.agreement, best);
    result.agreement_as_given = std::min(result.agreement_as_given, as_given);
  }
  const Eigen::VectorXd solved = normal.ldlt().solve(right);
  result.shift.emplace_back();
  for (Eigen::Index v = 0; v < count; ++v)
    result.shift.push_back({solved[3 * v], solved[3 * v + 1], solved[3 * v + 2]});
  return result;
}

}  // namespace angio::reconstruction::detail
