#include "reconstruction/detail/self_calibration.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "core/parallel.hpp"
#include "core/units.hpp"
#include "reconstruction/detail/box_sum.hpp"

namespace angio::reconstruction::detail {
namespace {

using angiogram::ConeBeamFrame;
using angiogram::ConeBeamView;

constexpr double kSurroundingsMm = 4.0;     ///< half the box that a voxel stands out of
constexpr double kAboveNoise = 4.0;         ///< of the voxels' noise
constexpr std::size_t kMostVoxels = 60000;  ///< that stand out
constexpr std::size_t kMostPoints = 8000;   ///< that they are gathered into
constexpr std::size_t kFewestPoints = 50;
constexpr double kShiftSd = 1.0;                      ///< [mm], of a C-arm's sway
constexpr double kTurnSd = 0.5 * units::kPi / 180.0;  ///< [radians]
constexpr double kHeldSd = 1e-4;                      ///< [mm]
constexpr double kScaleSd = 0.5;
constexpr int kInnerSteps = 3;
constexpr double kSeen = 0.02;         ///< of the brightest pixel of the points
constexpr int kBackgroundPixels = 12;  ///< half the box that smooths what lies around the points

/// The mean of a volume over a box around each voxel, cut at its border.
std::vector<float> surroundings(const Volume<float>& volume, int half) {
  const int ni = volume.geometry.size[0], nj = volume.geometry.size[1],
            nk = volume.geometry.size[2];
  const std::size_t slice = std::size_t(ni) * std::size_t(nj);
  std::vector<float> means(volume.values.size());
  parallel_for(nk, [&](std::ptrdiff_t k) {
    const float* from = volume.values.data() + std::size_t(k) * slice;
    std::vector<double> sums(from, from + slice), above;
    box_sum(sums, ni, nj, half, above);
    std::copy(sums.begin(), sums.end(), means.begin() + std::ptrdiff_t(std::size_t(k) * slice));
  });
  const auto span = [half](int at, int count) {
    return std::min(at + half, count - 1) - std::max(at - half, 0) + 1;
  };
  parallel_for(nj, [&](std::ptrdiff_t j) {
    const std::size_t width = std::size_t(ni);
    std::vector<double> sums((std::size_t(nk) + 1) * width, 0.0);  // over k, of each i
    for (int k = 0; k < nk; ++k)
      for (std::size_t i = 0; i < width; ++i)
        sums[(std::size_t(k) + 1) * width + i] =
            sums[std::size_t(k) * width + i] +
            double(means[volume.geometry.offset(int(i), int(j), k)]);
    for (int k = 0; k < nk; ++k) {
      const double* above = sums.data() + std::size_t(std::min(k + half + 1, nk)) * width;
      const double* below = sums.data() + std::size_t(std::max(k - half, 0)) * width;
      for (int i = 0; i < ni; ++i)
        means[volume.geometry.offset(i, int(j), k)] =
            float((above[i] - below[i]) / (double(span(i, ni)) * span(int(j), nj) * span(k, nk)));
    }
  });
  return means;
}

/// A voxel and how far it stands out of its surroundings.
struct BrightVoxel {
  int i = 0, j = 0, k = 0;
  float excess = 0.0F;
};

/// Those that stand out by more than `least`, in the order of the volume.
std::vector<BrightVoxel> bright_voxels(const Volume<float>& volume, float least) {
  const VolumeGeometry& g = volume.geometry;
  const int half = std::max(2, int(std::lround(kSurroundingsMm / g.spacing.x)));
  const std::vector<float> means = surroundings(volume, half);
  std::vector<std::vector<BrightVoxel>> slices(std::size_t(g.size[2]));
  parallel_for(g.size[2], [&](std::ptrdiff_t k) {
    for (int j = 0; j < g.size[1]; ++j)
      for (int i = 0; i < g.size[0]; ++i) {
        const std::size_t v = g.offset(i, j, int(k));
        const float excess = volume.values[v] - means[v];
        if (excess > least) slices[std::size_t(k)].push_back({i, j, int(k), excess});
      }
  });
  std::vector<BrightVoxel> all;
  for (const auto& slice : slices) all.insert(all.end(), slice.begin(), slice.end());
  return all;
}

/// Those of a cell of voxels as one point in their middle.
std::vector<BrightPoint> gather(const VolumeGeometry& g, const std::vector<BrightVoxel>& voxels,
                                int cell) {
  struct Sum {
    Vec3 place;
    double amount = 0.0;
  };
  std::map<std::array<int, 3>, Sum> cells;
  for (const BrightVoxel& v : voxels) {
    Sum& sum = cells[{v.k / cell, v.j / cell, v.i / cell}];
    sum.place += double(v.excess) * Vec3{double(v.i), double(v.j), double(v.k)};
    sum.amount += double(v.excess);
  }
  const double voxel = g.spacing.x * g.spacing.y * g.spacing.z;
  std::vector<BrightPoint> points;
  for (const auto& [place, sum] : cells)
    points.push_back({g.lps_from_index(sum.place / sum.amount), sum.amount * voxel});
  return points;
}

constexpr int kParameters = 7;  ///< turn, shift, scale
using Parameters = Eigen::Matrix<double, kParameters, 1>;

/// What a frame sees of the points, and how that changes when the frame moves.
struct Picture {
  int columns = 0, rows = 0;
  double least = 0.0;         ///< what is seen less is not looked at; 0: nothing is seen
  std::vector<double> value;  ///< shape [rows, columns]
  std::vector<int> seen;      ///< the same; which of `change`, -1: it sees none
  std::vector<std::array<double, 6>> change;  ///< by turn and shift
};

/// How a point's place in the picture changes with the frame's turn and shift: the point goes the
/// other way, by -(w x x + t).
struct PlaceChange {
  std::array<double, 6> column{}, row{};
};
PlaceChange place_change(const std::array<std::array<double, 4>, 3>& m, const Vec3& x,
                         double column, double row, double depth) {
  const auto gradient = [&](int line, double at) {
    const auto& a = m[std::size_t(line)];
    return Vec3{a[0] - at * m[2][0], a[1] - at * m[2][1], a[2] - at * m[2][2]} / depth;
  };
  PlaceChange change;
  const auto fill = [&](const Vec3& g, std::array<double, 6>& out) {
    const Vec3 by_turn = -cross(x, g);  // g . (w x x) = w . (x x g)
    for (int k = 0; k < 3; ++k) {
      out[std::size_t(k)] = by_turn[k];
      out[std::size_t(k) + 3] = -g[k];
    }
  };
  fill(gradient(0, column), change.column);
  fill(gradient(1, row), change.row);
  return change;
}

/// Adds up Gaussians of the points' amounts.
/// @param last  a picture whose memory is taken over
Picture splat(const ConeBeamFrame& frame, const std::vector<BrightPoint>& points, double sd,
              Picture last) {
  Picture picture = std::move(last);
  const std::size_t count = std::size_t(frame.columns) * std::size_t(frame.rows);
  picture.columns = frame.columns;
  picture.rows = frame.rows;
  picture.value.assign(count, 0.0);
  picture.seen.assign(count, -1);
  picture.change.clear();
  const auto m = ConeBeamView(frame).matrix();
  const Vec3 pixel = cross(frame.column_step, frame.row_step);
  const double pixel_area = norm(pixel);
  const int reach = int(std::ceil(2.5 * sd));
  const double per_variance = 1.0 / (sd * sd);
  for (const BrightPoint& p : points) {
    const auto at = [&](int line) {
      const auto& a = m[std::size_t(line)];
      return a[0] * p.point.x + a[1] * p.point.y + a[2] * p.point.z + a[3];
    };
    const double depth = at(2);
    if (!(depth > 0.0)) continue;
    const double column = at(0) / depth, row = at(1) / depth;
    const int c0 = int(std::lround(column)), r0 = int(std::lround(row));
    if (c0 < 0 || r0 < 0 || c0 >= frame.columns || r0 >= frame.rows) continue;
    const PlaceChange change = place_change(m, p.point, column, row, depth);
    // A pixel's area at the point's depth.
    const double amount =
        p.amount / (pixel_area * depth * depth) * per_variance / (2.0 * units::kPi);
    for (int r = std::max(0, r0 - reach); r <= std::min(frame.rows - 1, r0 + reach); ++r)
      for (int c = std::max(0, c0 - reach); c <= std::min(frame.columns - 1, c0 + reach); ++c) {
        const double dc = c - column, dr = r - row;
        const double g = amount * std::exp(-0.5 * per_variance * (dc * dc + dr * dr));
        const std::size_t place = std::size_t(r) * std::size_t(frame.columns) + std::size_t(c);
        picture.value[place] += g;
        if (picture.seen[place] < 0) {
          picture.seen[place] = int(picture.change.size());
          picture.change.push_back({});
        }
        auto& sum = picture.change[std::size_t(picture.seen[place])];
        for (std::size_t k = 0; k < 6; ++k)
          sum[k] += g * per_variance * (dc * change.column[k] + dr * change.row[k]);
      }
  }
  picture.least = kSeen * *std::max_element(picture.value.begin(), picture.value.end());
  return picture;
}

/// What lies around the points, smoothed, goes on under them.
class Background {
 public:
  const std::vector<double>& of(const std::vector<float>& line_integrals, const Picture& picture) {
    outside_.resize(line_integrals.size());
    weight_.resize(line_integrals.size());
    for (std::size_t i = 0; i < outside_.size(); ++i) {
      weight_[i] = picture.value[i] > picture.least ? 1e-6 : 1.0;
      outside_[i] = weight_[i] * double(line_integrals[i]);
    }
    for (int pass = 0; pass < 2; ++pass) {
      box_sum(outside_, picture.columns, picture.rows, kBackgroundPixels, above_);
      box_sum(weight_, picture.columns, picture.rows, kBackgroundPixels, above_);
    }
    for (std::size_t i = 0; i < outside_.size(); ++i) outside_[i] /= weight_[i];
    return outside_;
  }

 private:
  std::vector<double> outside_, weight_, above_;
};

/// One Gauss-Newton step.
///
/// A shift along the beam only changes the size of the picture, by so little that noise and blur
/// would tell it: it is held.
/// @param around  the background
/// @param beam    unit
Parameters step(const std::vector<float>& line_integrals, const std::vector<double>& around,
                const Picture& picture, const Motion& motion, const Vec3& beam, double scale) {
  Eigen::Matrix<double, kParameters, kParameters> normal;
  normal.setZero();
  Parameters right = Parameters::Zero();
  double squares = 0.0, number = 0.0;
  for (std::size_t i = 0; i < line_integrals.size(); ++i) {
    if (!(picture.value[i] > picture.least)) continue;
    Parameters row;
    const auto& change = picture.change[std::size_t(picture.seen[i])];
    for (std::size_t k = 0; k < 6; ++k) row[Eigen::Index(k)] = scale * change[k];
    row[6] = picture.value[i];
    const double left = double(line_integrals[i]) - around[i] - scale * picture.value[i];
    normal += row * row.transpose();
    right += left * row;
    squares += left * left;
    number += 1.0;
  }
  if (number < double(kFewestPoints)) return Parameters::Zero();
  const double variance = std::max(squares / number, 1e-12);
  for (int k = 0; k < 3; ++k) {
    const double turn = variance / (kTurnSd * kTurnSd);
    const double shift = variance / (kShiftSd * kShiftSd);
    normal(k, k) += turn;
    normal(k + 3, k + 3) += shift;
    right[k] -= turn * motion.turn[k];
    right[k + 3] -= shift * motion.shift[k];
    for (int l = 0; l < 3; ++l)
      normal(k + 3, l + 3) += variance / (kHeldSd * kHeldSd) * beam[k] * beam[l];
  }
  normal(6, 6) += variance / (kScaleSd * kScaleSd);
  right[6] += variance / (kScaleSd * kScaleSd) * (1.0 - scale);
  return normal.ldlt().solve(right);
}

/// How far apart two frames see the points, root mean square [pixels].
double apart(const ConeBeamFrame& a, const ConeBeamFrame& b,
             const std::vector<BrightPoint>& points) {
  const ConeBeamView first(a), second(b);
  double squares = 0.0;
  std::size_t count = 0;
  constexpr std::size_t kEvery = 17;
  for (std::size_t p = 0; p < points.size(); p += kEvery, ++count) {
    const auto x = first.see(points[p].point), y = second.see(points[p].point);
    squares += (x.column - y.column) * (x.column - y.column) + (x.row - y.row) * (x.row - y.row);
  }
  return std::sqrt(squares / double(std::max<std::size_t>(count, 1)));
}

}  // namespace

ConeBeamFrame moved(ConeBeamFrame frame, const Motion& motion) {
  const double angle = norm(motion.turn);
  const Vec3 axis = normalized(motion.turn);
  const auto turned = [&](const Vec3& v) {
    return std::cos(angle) * v + std::sin(angle) * cross(axis, v) +
           (1.0 - std::cos(angle)) * dot(axis, v) * axis;
  };
  frame.source = turned(frame.source) + motion.shift;
  frame.first_pixel = turned(frame.first_pixel) + motion.shift;
  frame.column_step = turned(frame.column_step);
  frame.row_step = turned(frame.row_step);
  return frame;
}

void take_out_common(std::vector<Motion>& motions) {
  Motion mean;
  for (const Motion& m : motions) {
    mean.turn += m.turn / double(motions.size());
    mean.shift += m.shift / double(motions.size());
  }
  for (Motion& m : motions) {
    m.turn -= mean.turn;
    m.shift -= mean.shift;
  }
}

std::vector<BrightPoint> find_bright_points(const Volume<float>& volume, double noise_per_mm) {
  const VolumeGeometry& g = volume.geometry;
  std::vector<BrightVoxel> voxels = bright_voxels(volume, float(kAboveNoise * noise_per_mm));
  // The brightest of them, and at least half as bright as the brightest thousandth.
  const auto keep_above = [&](std::size_t from_top, float part) {
    if (from_top >= voxels.size()) return;
    std::vector<float> ordered;
    for (const BrightVoxel& voxel : voxels) ordered.push_back(voxel.excess);
    const auto place = ordered.end() - std::ptrdiff_t(from_top + 1);
    std::nth_element(ordered.begin(), place, ordered.end());
    std::erase_if(voxels,
                  [least = part * *place](const BrightVoxel& v) { return v.excess <= least; });
  };
  keep_above(g.voxel_count() / 1000, 0.5F);
  keep_above(kMostVoxels, 1.0F);
  for (int cell = 1;; ++cell) {
    std::vector<BrightPoint> points = gather(g, voxels, cell);
    if (points.size() > kMostPoints) continue;
    if (points.size() < kFewestPoints) points.clear();
    return points;
  }
}

FrameFit fit_frame(const ConeBeamFrame& given, const Motion& from,
                   const std::vector<float>& line_integrals, const std::vector<BrightPoint>& points,
                   double blur_pixels) {
  const FrameFit unfitted{from, 0.0, false};
  FrameFit fit{from, 0.0, true};
  const Vec3 beam =
      normalized(given.place(0.5 * (given.columns - 1), 0.5 * (given.rows - 1)) - given.source);
  double scale = 1.0;
  Picture picture;
  Background background;
  for (int n = 0; n < kInnerSteps; ++n) {
    picture = splat(moved(given, fit.motion), points, blur_pixels, std::move(picture));
    if (!(picture.least > 0.0)) return unfitted;
    const std::vector<double>& around = background.of(line_integrals, picture);
    const Parameters by = step(line_integrals, around, picture, fit.motion, beam, scale);
    if (by.isZero()) return unfitted;
    fit.motion.turn += {by[0], by[1], by[2]};
    fit.motion.shift += {by[3], by[4], by[5]};
    scale = std::clamp(scale + by[6], 0.2, 5.0);
  }
  fit.moved_pixels = apart(moved(given, from), moved(given, fit.motion), points);
  return std::isfinite(fit.moved_pixels) ? fit : unfitted;
}

}  // namespace angio::reconstruction::detail
