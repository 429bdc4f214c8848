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

/// How many of the first rows or columns a collimator may cover: their median is far from the
/// picture's.
int dark_border(const Side& side, double middle) {
  int border = 0;
  for (int in = 0; in < side.depth() / 3; ++in) {
    std::vector<double> values;
    for (int n = side.length() / 5; n < side.length() - side.length() / 5; ++n)
      values.push_back(side.at(n, in));
    if (std::abs(median(std::move(values)) - middle) > kFar) border = in + 1;
  }
  return border;
}

/// How far what is far from the picture's median reaches inwards at a place of the side.
int reach_at(const Side& side, int along, double middle) {
  constexpr int kAround = 2;
  for (int in = 0; in < side.depth(); ++in) {
    std::vector<double> values;
    for (int n = along - kAround; n <= along + kAround; ++n) values.push_back(side.at(n, in));
    if (std::abs(median(std::move(values)) - middle) <= kFar) return in;
  }
  return side.depth();
}

/// Whether what begins at a side ends in a straight line, as a collimator's leaf does and bone does
/// not: of its middle three fifths (a leaf's corners may be round) nine tenths lie within two
/// pixels, or a hundredth of it for the leaf's blur, of the line of least squares.
bool is_straight(const Side& side, double middle) {
  constexpr double kPixels = 2.0, kOfLength = 0.01, kPart = 0.9;
  std::vector<double> along, reach;
  for (int n = side.length() / 5; n < side.length() - side.length() / 5; ++n) {
    along.push_back(n);
    reach.push_back(reach_at(side, n, middle));
  }
  double mean_along = 0.0, mean_reach = 0.0, aa = 0.0, ar = 0.0;
  const double count = double(along.size());
  for (std::size_t n = 0; n < along.size(); ++n) {
    mean_along += along[n] / count;
    mean_reach += reach[n] / count;
  }
  for (std::size_t n = 0; n < along.size(); ++n) {
    aa += (along[n] - mean_along) * (along[n] - mean_along);
    ar += (along[n] - mean_along) * (reach[n] - mean_reach);
  }
  std::vector<double> beside;
  for (std::size_t n = 0; n < along.size(); ++n)
    beside.push_back(std::abs(reach[n] - mean_reach - ar / aa * (along[n] - mean_along)));
  return quantile(std::move(beside), kPart) <= std::max(kPixels, kOfLength * side.length());
}

/// How many of the first rows or columns a collimator covers, with its blurred edge.
int covered(const Side& side, double middle) {
  constexpr double kEdge = 0.03;
  const int border = dark_border(side, middle);
  return (border > 0 && is_straight(side, middle) ? border : 0) + int(kEdge * side.depth());
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
