#include "meshing/detail/winding.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "core/parallel.hpp"

namespace angio::meshing::detail {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

}  // namespace

Winding::Winding(const TriangleMesh& closed) : mesh_(closed) {
  constexpr double kHuge = std::numeric_limits<double>::max();
  std::array<double, 2> high{-kHuge, -kHuge};
  low_ = {kHuge, kHuge};
  for (const Triangle& t : closed.triangles)
    for (const int v : t)
      for (int axis = 0; axis < 2; ++axis) {
        const double x = closed.vertices[std::size_t(v)][axis + 1];
        low_[std::size_t(axis)] = std::min(low_[std::size_t(axis)], x);
        high[std::size_t(axis)] = std::max(high[std::size_t(axis)], x);
      }
  const int side =
      std::clamp(int(std::sqrt(double(closed.triangles.size()))), 1, 1024);  // a few in each bin
  for (std::size_t axis = 0; axis < 2; ++axis) {
    count_[axis] = side;
    cell_[axis] = std::max((high[axis] - low_[axis]) / side, std::numeric_limits<double>::min());
  }
  first_.assign(std::size_t(side) * std::size_t(side) + 1, 0);
  const auto for_bins = [&](const Triangle& t, const auto& take) {
    std::array<int, 4> range{};
    for (int axis = 0; axis < 2; ++axis) {
      const auto x = [&](std::size_t c) { return closed.vertices[std::size_t(t[c])][axis + 1]; };
      const auto [least, most] = std::minmax({x(0), x(1), x(2)});
      range[std::size_t(2 * axis)] = bin(least, axis);
      range[std::size_t(2 * axis + 1)] = bin(most, axis);
    }
    for (int k = range[2]; k <= range[3]; ++k)
      for (int j = range[0]; j <= range[1]; ++j)
        take(std::size_t(k) * std::size_t(count_[0]) + std::size_t(j));
  };
  for (const Triangle& t : closed.triangles) for_bins(t, [&](std::size_t at) { ++first_[at + 1]; });
  for (std::size_t i = 0; i + 1 < first_.size(); ++i) first_[i + 1] += first_[i];
  triangles_.resize(std::size_t(first_.back()));
  std::vector<int> next(first_.begin(), first_.end() - 1);
  for (std::size_t t = 0; t < closed.triangles.size(); ++t)
    for_bins(closed.triangles[t],
             [&](std::size_t at) { triangles_[std::size_t(next[at]++)] = int(t); });
}

int Winding::bin(double value, int axis) const {
  const auto a = std::size_t(axis);
  return std::clamp(int(std::floor((value - low_[a]) / cell_[a])), 0, count_[a] - 1);
}

double Winding::next_line(double y, double z) const {
  if (z < low_[1] || z > low_[1] + cell_[1] * count_[1]) return kNone;
  const std::size_t row = std::size_t(bin(z, 1)) * std::size_t(count_[0]);
  const int own = bin(y, 0);
  for (int j = own; j < count_[0]; ++j)
    if (first_[row + std::size_t(j)] < first_[row + std::size_t(j) + 1])
      return j == own ? std::max(y, low_[0]) : low_[0] + j * cell_[0];
  return kNone;
}

void Winding::visit(double y, double z, const auto& found) const {
  if (y < low_[0] || z < low_[1] || y > low_[0] + cell_[0] * count_[0] ||
      z > low_[1] + cell_[1] * count_[1])
    return;
  const auto at = std::size_t(bin(z, 1)) * std::size_t(count_[0]) + std::size_t(bin(y, 0));
  // Twice the area of the line's place with a side; both triangles of a side get the same bits.
  const auto side = [&](int from, int to) {
    const bool swapped = from > to;
    const Vec3& a = mesh_.vertices[std::size_t(swapped ? to : from)];
    const Vec3& b = mesh_.vertices[std::size_t(swapped ? from : to)];
    const double area = (b.y - a.y) * (z - a.z) - (b.z - a.z) * (y - a.y);
    // On the side itself the line is moved by less than any number, first in y, less in z.
    const bool is_left = area != 0.0 ? area > 0.0 : (a.z != b.z ? a.z > b.z : b.y > a.y);
    return std::pair(swapped ? -area : area, swapped ? !is_left : is_left);
  };
  for (int i = first_[at]; i < first_[at + 1]; ++i) {
    const Triangle& t = mesh_.triangles[std::size_t(triangles_[std::size_t(i)])];
    const auto [w2, left2] = side(t[0], t[1]);
    const auto [w0, left0] = side(t[1], t[2]);
    const auto [w1, left1] = side(t[2], t[0]);
    if (left0 != left1 || left1 != left2) continue;
    const double sum = w0 + w1 + w2;
    if (sum == 0.0) continue;
    const double x =
        (w0 * mesh_.vertices[std::size_t(t[0])].x + w1 * mesh_.vertices[std::size_t(t[1])].x +
         w2 * mesh_.vertices[std::size_t(t[2])].x) /
        sum;
    found(x, left0 ? -1 : +1);  // seen from -x the triangle runs clockwise where the line enters
  }
}

int Winding::at(const Vec3& place) const {
  int winding = 0;
  visit(place.y, place.z, [&](double x, int step) {
    if (x <= place.x) winding += step;
  });
  return winding;
}

std::vector<Winding::Crossing> Winding::crossings(double y, double z) const {
  std::vector<Crossing> line;
  visit(y, z, [&](double x, int step) { line.emplace_back(x, step); });
  std::sort(line.begin(), line.end());
  return line;
}

namespace {

/// Where a line runs through what is wound around.
struct Chord {
  int line = 0;  ///< of its row
  double enter = 0.0, leave = 0.0;

  [[nodiscard]] bool overlaps(const Chord& other) const {
    return enter < other.leave && other.enter < leave;
  }
};

struct Chords {
  double step = 0.0;                     ///< between lines and between rows [mm]
  std::vector<std::vector<Chord>> rows;  ///< of each row by line, then along it
};

/// Of the places that a surface winds around at least so many times.
Chords chords_of(const TriangleMesh& closed, double line_distance, int least) {
  constexpr double kMostLines = 1500.0;  // a side
  constexpr double kEnough = 4e5;        // squares of the distance in the area
  // Turned, so that no tube or face of a construction lies along the lines.
  const Vec3 u = normalized(Vec3{0.81, 0.47, 0.35});
  const Vec3 v = normalized(cross(u, Vec3{0.13, -0.71, 0.69}));
  const Vec3 w = cross(u, v);
  TriangleMesh turned = closed;
  for (Vec3& p : turned.vertices) p = {dot(p, u), dot(p, v), dot(p, w)};
  Vec3 low = turned.vertices.front(), high = low;
  for (const Vec3& p : turned.vertices)
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  constexpr double kMost = 2e4;  // lines a side, however small the surface is in its box
  const double side = std::max(high.y - low.y, high.z - low.z);
  const double wide = std::min(side / kMostLines, std::sqrt(surface_area(closed) / kEnough));
  const double step = std::max({line_distance, wide, side / kMost});
  Chords chords{step, {}};
  if (!(step > 0.0)) return chords;
  chords.rows.resize(std::size_t(std::ceil((high.z - low.z) / step)));
  const int lines = int(std::ceil((high.y - low.y) / step));
  const Winding winding(turned);
  parallel_for_uneven(std::ptrdiff_t(chords.rows.size()), [&](std::ptrdiff_t row) {
    const double z = low.z + (double(row) + 0.5) * step;
    for (int i = 0; i < lines; ++i) {
      const double next = winding.next_line(low.y + (i + 0.5) * step, z);
      if (next == kNone) break;
      i = std::max(i, int((next - low.y) / step - 0.5));
      int turns = 0;
      double entered = 0.0;
      for (const auto& [x, change] : winding.crossings(low.y + (i + 0.5) * step, z)) {
        const bool was_inside = turns >= least;
        turns += change;
        if (!was_inside && turns >= least) entered = x;
        if (was_inside && turns < least) chords.rows[std::size_t(row)].push_back({i, entered, x});
      }
    }
  });
  return chords;
}

}  // namespace

double wound_volume(const TriangleMesh& closed, double line_distance, int least) {
  const Chords chords = chords_of(closed, line_distance, least);
  double sum = 0.0;
  for (const std::vector<Chord>& row : chords.rows) {
    double length = 0.0;
    for (const Chord& chord : row) length += chord.leave - chord.enter;
    sum += length;
  }
  return sum * chords.step * chords.step;
}

std::vector<double> wound_parts(const TriangleMesh& closed, double line_distance) {
  const Chords chords = chords_of(closed, line_distance, 1);
  std::vector<std::size_t> first_of_row{0}, part;
  for (const std::vector<Chord>& row : chords.rows)
    first_of_row.push_back(first_of_row.back() + row.size());
  part.resize(first_of_row.back());
  std::iota(part.begin(), part.end(), std::size_t(0));
  const auto root = [&](std::size_t n) {
    while (part[n] != n) n = part[n] = part[part[n]];
    return n;
  };
  // Chords of one line of a row with those of another that they overlap.
  const auto join = [&](std::size_t row, std::size_t other_row, int lines_on) {
    const std::vector<Chord>&ours = chords.rows[row], &theirs = chords.rows[other_row];
    std::size_t begin = 0;
    for (std::size_t i = 0; i < ours.size(); ++i) {
      const int line = ours[i].line + lines_on;
      while (begin < theirs.size() && theirs[begin].line < line) ++begin;
      for (std::size_t k = begin; k < theirs.size() && theirs[k].line == line; ++k)
        if (ours[i].overlaps(theirs[k]))
          part[root(first_of_row[row] + i)] = root(first_of_row[other_row] + k);
    }
  };
  for (std::size_t row = 0; row < chords.rows.size(); ++row) {
    join(row, row, 1);
    if (row + 1 < chords.rows.size()) join(row, row + 1, 0);
  }
  std::map<std::size_t, double> volume;
  for (std::size_t row = 0; row < chords.rows.size(); ++row)
    for (std::size_t i = 0; i < chords.rows[row].size(); ++i) {
      const Chord& chord = chords.rows[row][i];
      volume[root(first_of_row[row] + i)] +=
          (chord.leave - chord.enter) * chords.step * chords.step;
    }
  std::vector<double> parts;
  for (const auto& [of, size] : volume) parts.push_back(size);
  std::sort(parts.rbegin(), parts.rend());
  return parts;
}

}  // namespace angio::meshing::detail
