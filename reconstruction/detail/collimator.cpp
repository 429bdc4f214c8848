#include "reconstruction/detail/collimator.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "core/statistics.hpp"
#include "reconstruction/detail/line_integrals.hpp"

namespace angio::reconstruction::detail {
namespace {

constexpr double kFar = 0.8;  ///< of a line integral: less than half of the beam, or twice as much

/// A side of a picture, as rows that run inwards from it.
struct Side {
  const std::vector<float>& picture;
  int columns = 0, rows = 0;
  bool is_column = false;  ///< left or right
  bool from_end = false;   ///< right or bottom

  [[nodiscard]] int depth() const { return is_column ? columns : rows; }
  [[nodiscard]] int length() const { return is_column ? rows : columns; }
  [[nodiscard]] double at(int along, int inwards) const {
    const int in = from_end ? depth() - 1 - inwards : inwards;
    const int c = is_column ? in : along, r = is_column ? along : in;
    return double(picture[std::size_t(r) * std::size_t(columns) + std::size_t(c)]);
  }
};

/// A leaf's edge: how far it reaches inwards at `along`.
struct Line {
  double start = 0.0, slope = 0.0;
  [[nodiscard]] double at(double along) const { return start + slope * along; }
};

/// Through points in ascending order, by the medians of slopes and of places (Theil and Sen).
Line straight_line(const std::vector<double>& along, const std::vector<double>& reach) {
  std::vector<double> slopes, starts;
  const std::size_t half = along.size() / 2;
  for (std::size_t n = 0; n + half < along.size(); ++n)
    slopes.push_back((reach[n + half] - reach[n]) / (along[n + half] - along[n]));
  const double slope = median(std::move(slopes));
  for (std::size_t n = 0; n < along.size(); ++n) starts.push_back(reach[n] - slope * along[n]);
  return {median(std::move(starts)), slope};
}

std::size_t count_beside(const Line& line, const std::vector<double>& along,
                         const std::vector<double>& reach, double most) {
  std::size_t count = 0;
  for (std::size_t n = 0; n < along.size(); ++n)
    if (std::abs(reach[n] - line.at(along[n])) <= most) ++count;
  return count;
}

/// Where a leaf that leans reaches farthest, in whole rows.
int deepest(const Line& line, const Side& side) {
  return int(std::lround(std::max(line.at(0.0), line.at(side.length() - 1))));
}

constexpr double kEdge = 0.03;  ///< of a picture: a leaf's blurred edge, left out at every side

/// How far what is far from the picture's median reaches inwards at a place of the side; 0: nothing
/// does behind the edge.
int reach_at(const Side& side, int along, double middle) {
  constexpr int kAround = 2;
  const int edge = int(kEdge * side.depth());
  for (int in = edge; in < side.depth(); ++in) {
    std::vector<double> values;
    for (int n = along - kAround; n <= along + kAround; ++n)
      values.push_back(side.at(std::clamp(n, 0, side.length() - 1), in));
    if (std::abs(median(std::move(values)) - middle) <= kFar) return in > edge ? in : 0;
  }
  return side.depth();
}

/// How many rows or columns a collimator's leaf covers at a side, 0: there is none. A leaf ends in
/// a straight line, bone does not: nine tenths of it lie within two pixels, or a hundredth of its
/// length for the leaf's blur, of a line.
/// Corners may be round, so only the side's middle three fifths count; and of these up to a third
/// may lie elsewhere, where a wire, another leaf or bone joins it. A leaf that leans is covered to
/// where it reaches farthest.
int leaf_at(const Side& side, double middle) {
  constexpr double kPixels = 2.0, kOfLength = 0.01, kStraight = 0.9;
  constexpr double kPart = 2.0 / 3.0, kDeepest = 1.0 / 3.0,
                   kJoined = 5.0;  // the last in tolerances
  std::vector<double> along, reach;
  const int first = side.length() / 5, last = side.length() - side.length() / 5;
  for (int n = first; n < last; ++n) {
    const int here = reach_at(side, n, middle);
    if (here == 0 || here > kDeepest * side.depth()) continue;
    along.push_back(n);
    reach.push_back(here);
  }
  const double least = kPart * (last - first);
  if (double(along.size()) < std::max(least, 4.0)) return 0;
  const Line line = straight_line(along, reach);
  const double tolerance = std::max(kPixels, kOfLength * side.length());
  const auto within = [&](double most) { return double(count_beside(line, along, reach, most)); };
  const double beside = within(kJoined * tolerance);
  if (beside < least || within(tolerance) < kStraight * beside) return 0;
  return deepest(line, side);
}

/// How many of the first rows or columns a collimator covers, with its blurred edge.
int covered(const Side& side, double middle) {
  return leaf_at(side, middle) + int(kEdge * side.depth());
}

/// Of a mean over frames that turn: where, seen from a place of the side, it is the most darker
/// outwards than inwards.
struct Step {
  int place = 0;  ///< rows inwards
  double height = 0.0;
};

/// The highest step, of an edge as blurred as a width: what slopes is continued to it from both
/// sides, so that a body's edge is none.
/// @param most  what is darker is a leaf as this is
Step step_at(const Side& side, int along, int width, double most) {
  constexpr double kDeepest = 1.0 / 3.0;
  std::vector<double> sums{0.0};
  for (int in = 0; in < side.depth(); ++in)
    sums.push_back(sums.back() + std::min(most, side.at(along, in)));
  const auto mean = [&](int from, int to) {
    return (sums[std::size_t(to)] - sums[std::size_t(from)]) / (to - from);
  };
  const double last = std::min(kDeepest * side.depth(), side.depth() - 5.0 * width);
  Step step;
  for (int in = 2 * width; in < last; ++in) {
    const double near = mean(std::max(0, in - 3 * width), in - width);
    const double outwards =
        in < 5 * width ? near : 2.0 * near - mean(in - 5 * width, in - 3 * width);
    const double inwards =
        2.0 * mean(in + width, in + 3 * width) - mean(in + 3 * width, in + 5 * width);
    if (outwards - inwards > step.height) step = {in, outwards - inwards};
  }
  return step;
}

/// How many rows or columns of a mean over frames that turn a leaf covers at a side, with its edge,
/// as blurred as a width; 0: there is none. Nine tenths of the side's middle three fifths have the
/// step.
int still_leaf_at(const Side& side, int width, double middle) {
  constexpr double kLeastStep = 0.3, kMostDark = 2.0, kOfLength = 0.01, kPart = 0.9;
  std::vector<double> along, reach;
  const int first = side.length() / 5, last = side.length() - side.length() / 5;
  for (int n = first; n < last; ++n)
    if (const Step step = step_at(side, n, width, middle + kMostDark); step.height > kLeastStep) {
      along.push_back(n);
      reach.push_back(step.place);
    }
  const double least = kPart * (last - first);
  if (double(along.size()) < std::max(least, 4.0)) return 0;
  const Line line = straight_line(along, reach);
  if (double(count_beside(line, along, reach, std::max(2.0, kOfLength * side.length()))) < least)
    return 0;
  return deepest(line, side) + 2 * width;
}

/// The same of edges of all widths: the sharpest that there is.
int still_leaf_at(const Side& side, double middle) {
  constexpr double kSharpest = 0.008, kWidest = 0.04;  // of the side's depth
  for (double width = std::max(1.0, kSharpest * side.depth()); width <= kWidest * side.depth();
       width *= 2.0)
    if (const int covered = still_leaf_at(side, int(std::lround(width)), middle); covered > 0)
      return covered;
  return 0;
}

/// The mean line integrals, but for a constant, of frames that are spread over the run; empty: its
/// pixels tell none.
std::vector<float> mean_integrals(const RotationalRun& run) {
  constexpr int kFrames = 24, kAtATime = 8;
  const int count = int(run.frames.size()), taken = std::min(count, kFrames);
  const std::vector<float> middle = run.pictures->read(count / 2, 1);
  const double brightest = double(*std::max_element(middle.begin(), middle.end()));
  if (run.relation == PixelRelation::linear && !(brightest > 0.0)) return {};
  std::vector<float> mean(middle.size(), 0.0F);
  for (int first = 0; first < taken; first += kAtATime) {
    std::vector<int> some;
    for (int n = first; n < std::min(taken, first + kAtATime); ++n)
      some.push_back(int(std::int64_t(n) * count / taken));
    const std::vector<float> integrals = read_line_integrals(run, some, brightest);
    for (std::size_t i = 0; i < integrals.size(); ++i)
      mean[i % mean.size()] += integrals[i] / float(taken);
  }
  return mean;
}

}  // namespace

OpenField open_field(const std::vector<float>& picture, int columns, int rows) {
  const double middle = median(std::vector<double>(picture.begin(), picture.end()));
  const auto inside = [&](bool is_column, bool from_end) {
    return covered({picture, columns, rows, is_column, from_end}, middle);
  };
  return {inside(true, false), columns - 1 - inside(true, true), inside(false, false),
          rows - 1 - inside(false, true)};
}

std::optional<OpenField> open_field(const RotationalRun& run) {
  RotationalRun pictures = run;
  pictures.masks = nullptr;
  pictures.open_field.reset();
  const std::vector<float> mean = mean_integrals(pictures);
  if (mean.empty()) return {};
  const int columns = run.frames.front().columns, rows = run.frames.front().rows;
  const double middle = median(std::vector<double>(mean.begin(), mean.end()));
  const auto leaf = [&](bool is_column, bool from_end) {
    return still_leaf_at({mean, columns, rows, is_column, from_end}, middle);
  };
  const OpenField open{leaf(true, false), columns - 1 - leaf(true, true), leaf(false, false),
                       rows - 1 - leaf(false, true)};
  const bool is_whole = open.first_column == 0 && open.last_column == columns - 1 &&
                        open.first_row == 0 && open.last_row == rows - 1;
  const bool is_left =  // what leaves nothing open is none
      3 * (open.last_column - open.first_column) > columns &&
      3 * (open.last_row - open.first_row) > rows;
  return is_whole || !is_left ? std::nullopt : std::optional(open);
}

}  // namespace angio::reconstruction::detail
