#include "reconstruction/detail/read_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/error.hpp"
#include "core/statistics.hpp"
#include "reconstruction/detail/line_integrals.hpp"
#include "reconstruction/detail/vessel_pictures.hpp"

namespace angio::reconstruction {
namespace detail {
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
/// length for the leaf's blur, of a line (the medians of slopes and of places: Theil and Sen).
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
  std::vector<double> slopes;
  const std::size_t half = along.size() / 2;
  for (std::size_t n = 0; n + half < along.size(); ++n)
    slopes.push_back((reach[n + half] - reach[n]) / (along[n + half] - along[n]));
  const double slope = median(std::move(slopes));
  std::vector<double> starts;
  for (std::size_t n = 0; n < along.size(); ++n) starts.push_back(reach[n] - slope * along[n]);
  const double start = median(starts);
  const double tolerance = std::max(kPixels, kOfLength * side.length());
  const auto within = [&](double most) {
    return double(std::count_if(starts.begin(), starts.end(),
                                [&](double one) { return std::abs(one - start) <= most; }));
  };
  const double beside = within(kJoined * tolerance);
  if (beside < least || within(tolerance) < kStraight * beside) return 0;
  return int(std::lround(start + std::max(0.0, slope * (side.length() - 1))));
}

/// How many of the first rows or columns a collimator covers, with its blurred edge.
int covered(const Side& side, double middle) {
  return leaf_at(side, middle) + int(kEdge * side.depth());
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

ViewPicture read_view(const RotationalRun& run, int index, double air, double widest_mm,
                      std::vector<char> covered) {
  const angiogram::ConeBeamFrame& frame = run.frames[std::size_t(index)];
  std::vector<float> integrals = read_line_integrals(run, index, 1, air);
  OpenField open = open_field(integrals, frame.columns, frame.rows);
  const OpenField given = around_open(covered, frame.columns, frame.rows);
  open = {std::max(open.first_column, given.first_column),
          std::min(open.last_column, given.last_column), std::max(open.first_row, given.first_row),
          std::min(open.last_row, given.last_row)};
  if (open.first_column > open.last_column || open.first_row > open.last_row)
    throw InputError(fmt::format("view {}: its shutter covers all of it. Give another", index + 1));
  cover_shutter(integrals.data(), frame.columns, frame.rows, open);
  VesselPicture picture = vessels_of(std::move(integrals), frame.columns, frame.rows,
                                     widest_mm / pixel_at_isocentre(frame), run.masks != nullptr);
  covered.resize(picture.line_integrals.size(), 0);
  for (int row = 0; row < frame.rows; ++row)
    for (int c = 0; c < frame.columns; ++c)
      if (c < open.first_column || c > open.last_column || row < open.first_row ||
          row > open.last_row)
        covered[std::size_t(row) * std::size_t(frame.columns) + std::size_t(c)] = 1;
  return make_view_picture(frame, std::move(picture.line_integrals), covered, widest_mm);
}

}  // namespace detail

OpenField around_open(const std::vector<char>& covered, int columns, int rows) {
  if (covered.empty()) return {0, columns - 1, 0, rows - 1};
  OpenField open{columns, -1, rows, -1};
  for (int row = 0; row < rows; ++row)
    for (int c = 0; c < columns; ++c) {
      if (covered[std::size_t(row) * std::size_t(columns) + std::size_t(c)] != 0) continue;
      open = {std::min(open.first_column, c), std::max(open.last_column, c),
              std::min(open.first_row, row), std::max(open.last_row, row)};
    }
  return open;
}

}  // namespace angio::reconstruction
