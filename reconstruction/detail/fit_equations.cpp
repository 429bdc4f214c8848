#include "reconstruction/detail/fit_equations.hpp"

#include <algorithm>
#include <cmath>

namespace angio::reconstruction::detail {
namespace {

constexpr double kHatDiameters = 3.0;  ///< from hat to hat along a curve
constexpr int kMotions = 6;
constexpr int kFirstHat = 1 + kMotions;  ///< of a frame's own numbers: contrast, motion, background
constexpr double kHeld = 1e12;           ///< information on a motion that is none
constexpr double kFaint = 1e-9;          ///< on a background that no pixel sees

/// Between a ray and a tube: where it is less, the section changes along the ray's way, and a tube
/// of one radius is no model of it (a view along the vessel).
constexpr double kLeastSine = 0.5;

struct Hats {
  int first = 0, count = 2;
};

bool is_seen_from_its_end(const TubeHit& hit, const FrameRays& rays, const SampledCurves& curves) {
  const Vec3 tangent =
      normalized(curves.points[std::size_t(hit.curve)][std::size_t(hit.sample)].tangent);
  return norm(cross(tangent, rays.direction(hit.pixel))) < kLeastSine;
}

/// The hats of each curve.
std::vector<Hats> make_hats(const SampledCurves& curves) {
  std::vector<Hats> all;
  int first = 0;
  for (std::size_t c = 0; c < curves.points.size(); ++c) {
    double sum = 0.0;
    for (const CurvePoint& point : curves.points[c]) sum += std::exp(point.log_radius);
    const double diameter = 2.0 * sum / double(curves.points[c].size());
    const double length = curves.curves->curves[c].length;
    const int count = 1 + std::max(1, int(std::lround(length / (kHatDiameters * diameter))));
    all.push_back({first, count});
    first += count;
  }
  return all;
}

/// The frame's model of one pixel, and how its numbers change it.
struct PixelRow {
  std::vector<int> index;  ///< of the tree's parameters
  std::vector<double> by_tree;
  std::array<double, kFirstHat> by_own{};
  std::array<int, 4> background{};
  std::array<double, 4> by_background{};
};

class FrameSums {
 public:
  FrameSums(const FitFrame& frame, const FrameState& state, int parameters)
      : frame_(frame), state_(state), scratch_(std::size_t(parameters), 0.0) {
    const int own = kFirstHat + 2 * frame.hat_count;
    equations_.normal = Eigen::MatrixXd::Zero(parameters, parameters);
    equations_.right = Eigen::VectorXd::Zero(parameters);
    equations_.residual.reserve(frame.pixels.size());
    own_ = Eigen::MatrixXd::Zero(own, own);
    own_right_ = Eigen::VectorXd::Zero(own);
    between_ = Eigen::MatrixXd::Zero(own, parameters);
  }

  void add(const FitPixel& pixel, double way, const WayGradient& gradient) {
    PixelRow row = row_of(pixel, way, gradient);
    double model = state_.contrast * way;
    for (std::size_t b = 0; b < 4; ++b)
      model += row.by_background[b] * state_.background[std::size_t(row.background[b])];
    const double residual = double(pixel.value) - model;
    equations_.residual.push_back(float(residual));
    const double size = std::abs(residual) / state_.noise;
    equations_.cost += size < kHuber ? size * size : kHuber * (2.0 * size - kHuber);
    const double weight = std::min(1.0, kHuber / size) / (state_.noise * state_.noise);
    add_products(row, weight, residual);
  }

  FrameEquations eliminate(const MotionPrior& prior);

 private:
  PixelRow row_of(const FitPixel& pixel, double way, const WayGradient& gradient);
  void add_products(const PixelRow& row, double weight, double residual);

  const FitFrame& frame_;
  const FrameState& state_;
  FrameEquations equations_;
  Eigen::MatrixXd own_, between_;
  Eigen::VectorXd own_right_;
  std::vector<double> scratch_;
};

PixelRow FrameSums::row_of(const FitPixel& pixel, double way, const WayGradient& gradient) {
  PixelRow row;
  const auto add = [&](int index, double value) {
    if (value == 0.0) return;
    double& sum = scratch_[std::size_t(index)];
    if (sum == 0.0) row.index.push_back(index);
    sum += value;
  };
  for (const auto& [index, value] : gradient.by_parameter) add(index, state_.contrast * value);
  add(int(scratch_.size()) - 1, state_.contrast * gradient.by_width);
  for (const int index : row.index) {
    row.by_tree.push_back(scratch_[std::size_t(index)]);
    scratch_[std::size_t(index)] = 0.0;  // where a sum came to zero and went on, once is enough
  }
  row.by_own[0] = way;
  for (std::size_t m = 0; m < kMotions; ++m)
    row.by_own[1 + m] = state_.contrast * gradient.by_motion[m];
  const double next = double(pixel.next_share), side = double(pixel.side);
  const int first = 2 * pixel.first_hat;
  row.background = {first, first + 1, first + 2, first + 3};
  row.by_background = {1.0 - next, (1.0 - next) * side, next, next * side};
  return row;
}

void FrameSums::add_products(const PixelRow& row, double weight, double residual) {
  std::array<int, kFirstHat + 4> own_index{};
  std::array<double, kFirstHat + 4> by_own{};
  for (std::size_t o = 0; o < kFirstHat; ++o) {
    own_index[o] = int(o);
    by_own[o] = row.by_own[o];
  }
  for (std::size_t b = 0; b < 4; ++b) {
    own_index[kFirstHat + b] = kFirstHat + row.background[b];
    by_own[kFirstHat + b] = row.by_background[b];
  }
  const auto add = [&](Eigen::MatrixXd& matrix, int i, int j, double value) {
    matrix.data()[std::ptrdiff_t(j) * matrix.rows() + i] += value;
  };
  for (std::size_t a = 0; a < row.index.size(); ++a) {
    const double left = weight * row.by_tree[a];
    const int i = row.index[a];
    equations_.right[i] += left * residual;
    for (std::size_t b = 0; b <= a; ++b)
      add(equations_.normal, std::max(i, row.index[b]), std::min(i, row.index[b]),
          left * row.by_tree[b]);
    for (std::size_t o = 0; o < own_index.size(); ++o)
      add(between_, own_index[o], i, left * by_own[o]);
  }
  for (std::size_t a = 0; a < own_index.size(); ++a) {
    own_right_[own_index[a]] += weight * by_own[a] * residual;
    for (std::size_t b = 0; b < own_index.size(); ++b)
      add(own_, own_index[a], own_index[b], weight * by_own[a] * by_own[b]);
  }
}

FrameEquations FrameSums::eliminate(const MotionPrior& prior) {
  for (int m = 0; m < kMotions; ++m) {
    const double sd = m < 3 ? prior.turn_sd : prior.shift_sd;
    const double at = m < 3 ? state_.motion.turn[m] : state_.motion.shift[m - 3];
    const double information = sd > 0.0 ? 1.0 / (sd * sd) : kHeld;
    own_(1 + m, 1 + m) += information;
    own_right_[1 + m] -= information * at;
    equations_.cost += information * at * at;
  }
  own_.diagonal().array() += kFaint * (1.0 + own_.diagonal().maxCoeff() / kHeld);
  const Eigen::LDLT<Eigen::MatrixXd> solver(own_);
  equations_.own_start = solver.solve(own_right_);
  equations_.own_by_tree = solver.solve(between_);
  equations_.normal = equations_.normal.selfadjointView<Eigen::Lower>();
  equations_.normal.noalias() -= between_.transpose() * equations_.own_by_tree;
  equations_.right.noalias() -= between_.transpose() * equations_.own_start;
  return std::move(equations_);
}

}  // namespace

FitFrame choose_pixels(const angiogram::ConeBeamFrame& frame,
                       const std::vector<float>& line_integrals, const SampledCurves& curves,
                       double width_pixels) {
  const FrameRays rays(frame);
  const std::vector<Hats> hats = make_hats(curves);
  FitFrame chosen;
  chosen.frame = frame;
  chosen.hat_count = hats.back().first + hats.back().count;
  chosen.wanted.assign(line_integrals.size(), 0);
  std::vector<char> is_end(line_integrals.size(), 0);
  for (const int pixel : find_end_pixels(rays, curves, width_pixels))
    is_end[std::size_t(pixel)] = 1;
  const std::vector<TubeHit> hits = find_hits(rays, curves, width_pixels, Reach::surroundings, {});
  const auto is_nearer = [](const TubeHit& a, const TubeHit& b) {
    return a.distance * b.radius < b.distance * a.radius;
  };
  for (std::size_t h = 0; h < hits.size();) {
    std::size_t nearest = h;
    const int pixel = hits[h].pixel;
    bool is_left_out = is_end[std::size_t(pixel)] != 0;
    for (; h < hits.size() && hits[h].pixel == pixel; ++h) {
      if (is_nearer(hits[h], hits[nearest])) nearest = h;
      is_left_out = is_left_out || is_seen_from_its_end(hits[h], rays, curves);
    }
    if (is_left_out || !std::isfinite(line_integrals[std::size_t(pixel)])) continue;
    const TubeHit& hit = hits[nearest];
    const Hats& row = hats[std::size_t(hit.curve)];
    const double last = double(curves.points[std::size_t(hit.curve)].size() - 1);
    const double along = (hit.sample + hit.part) / last * (row.count - 1);
    const int hat = std::clamp(int(along), 0, row.count - 2);
    chosen.wanted[std::size_t(pixel)] = 1;
    chosen.pixels.push_back({pixel, line_integrals[std::size_t(pixel)], row.first + hat,
                             float(along - hat), float(hit.side / hit.radius)});
  }
  return chosen;
}

FrameEquations frame_equations(const FitFrame& frame, const FrameState& state,
                               const SampledCurves& curves, double width_pixels,
                               const MotionPrior& prior) {
  const FrameRays rays(moved(frame.frame, state.motion));
  const std::vector<TubeHit> hits =
      find_hits(rays, curves, width_pixels, Reach::tube, frame.wanted);
  FrameSums sums(frame, state, 3 * curves.curves->node_count() + 1);
  const TubeHit* hit = hits.data();
  const TubeHit* const last = hit + hits.size();
  for (const FitPixel& pixel : frame.pixels) {
    const TubeHit* const first = hit;
    while (hit != last && hit->pixel == pixel.index) ++hit;
    WayGradient gradient;
    const double way = way_of_ray(rays, curves, width_pixels, first, hit, &gradient);
    sums.add(pixel, way, gradient);
  }
  return sums.eliminate(prior);
}

void move_state(FrameState& state, const FrameEquations& equations, const Eigen::VectorXd& step) {
  const Eigen::VectorXd own = equations.own_start - equations.own_by_tree * step;
  state.contrast += own[0];
  for (int axis = 0; axis < 3; ++axis) {
    state.motion.turn[axis] += own[1 + axis];
    state.motion.shift[axis] += own[4 + axis];
  }
  for (std::size_t b = 0; b < state.background.size(); ++b)
    state.background[b] += own[kFirstHat + int(b)];
}

}  // namespace angio::reconstruction::detail
