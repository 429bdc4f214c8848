#include "centerline/detail/contacts.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "centerline/detail/branches.hpp"
#include "centerline/detail/polyline.hpp"
#include "centerline/detail/tracts.hpp"
#include "core/parallel.hpp"
#include "core/statistics.hpp"

namespace angio::centerline {
namespace {

constexpr double kAsWide = 1.35;      // ratio of radii
constexpr double kStraight = 0.87;    // cosine: 30 degrees
constexpr double kBeside = 0.5;       // of the parent's radius
constexpr double kClear = 2.0;        // radii past the mouth before a branch runs its own way
constexpr double kCourse = 5.0;       // radii of its course that count
constexpr double kLeastCourse = 2.5;  // shorter branches have no direction

/// How a branch leaves another line.
struct Leaving {
  Vec3 mouth;              ///< where it leaves the tube
  Vec3 middle, direction;  ///< of its straight course beyond, away from the mouth
  double radius = 0.0;     ///< there
};

double median_radius(const CenterlinePath& path, std::size_t first, std::size_t last) {
  std::vector<double> radii(path.inscribed_radius.begin() + std::ptrdiff_t(first),
                            path.inscribed_radius.begin() + std::ptrdiff_t(last));
  return median(std::move(radii));
}

std::optional<Leaving> leave(const CenterlinePath& branch, const CenterlinePath& parent) {
  std::size_t mouth = 0;
  const std::size_t count = std::min(branch.points.size(), parent.points.size());
  while (mouth < count && distance(branch.points[mouth], parent.points[mouth]) == 0.0) ++mouth;
  while (mouth < branch.points.size() &&
         inside_tube(parent.points, parent.inscribed_radius, 0, branch.points[mouth]))
    ++mouth;
  if (mouth + 1 >= branch.points.size()) return std::nullopt;
  const auto index_at = [&](double abscissa) {
    const auto at = std::lower_bound(branch.abscissa.begin(), branch.abscissa.end() - 1, abscissa);
    return std::size_t(at - branch.abscissa.begin());
  };
  const double start = branch.abscissa[mouth];
  const double guess = branch.inscribed_radius[index_at(start + branch.inscribed_radius[mouth])];
  const std::size_t first = index_at(start + kClear * guess);
  const std::size_t last = index_at(start + (kClear + kCourse) * guess);
  const double length = distance(branch.points[first], branch.points[last]);
  if (last <= first + 1 || length < kLeastCourse * guess) return std::nullopt;
  Vec3 middle;
  for (std::size_t i = first; i < last; ++i) middle += branch.points[i] / double(last - first);
  return Leaving{branch.points[mouth], middle,
                 (branch.points[last] - branch.points[first]) / length,
                 median_radius(branch, first, last)};
}

/// The place on a parent line beside which the common line of two branches runs; nothing where they
/// are branches of their own.
std::optional<Vec3> touching_place(const Leaving& a, const Leaving& b,
                                   const CenterlinePath& parent) {
  if (std::max(a.radius, b.radius) > kAsWide * std::min(a.radius, b.radius)) return std::nullopt;
  const double chord = distance(a.middle, b.middle);
  if (chord <= 0.0) return std::nullopt;
  const Vec3 along = (b.middle - a.middle) / chord;
  if (-dot(along, a.direction) < kStraight || dot(along, b.direction) < kStraight)
    return std::nullopt;
  // Where the parent is nearest to the common line, between the two.
  double nearest = 1e300;
  std::size_t at = 0;
  for (std::size_t i = 0; i < parent.points.size(); ++i) {
    const Vec3 from = parent.points[i] - a.middle;
    const double t = dot(from, along);
    if (t <= 0.0 || t >= chord) continue;
    const double away = norm(from - t * along);
    if (away >= nearest) continue;
    nearest = away;
    at = i;
  }
  // At the contact itself a line may be drawn aside: beside it the vessel shows its width and
  // place.
  constexpr std::size_t kBesides = 16;  // points: four radii
  const std::size_t low = at - std::min(at, kBesides);
  const std::size_t high = std::min(at + kBesides, parent.points.size() - 1);
  const double radius = median_radius(parent, low, high + 1);
  if (nearest > 1e299 || nearest < kBeside * radius || nearest > radius + 1.5 * a.radius)
    return std::nullopt;
  return 0.5 * (parent.points[low] + parent.points[high]);
}

}  // namespace

std::vector<Vec3> find_contacts(const CenterlineTree& tree) {
  const std::size_t count = tree.paths.size();
  std::vector<std::vector<Leaving>> leavings_of(count);
  parallel_for_uneven(std::ptrdiff_t(count), [&](std::ptrdiff_t index) {
    const auto p = std::size_t(index);
    for (std::size_t a = 0; a < count; ++a)
      if (a != p)
        if (const auto leaving = leave(tree.paths[a], tree.paths[p]))
          leavings_of[p].push_back(*leaving);
  });
  std::vector<Vec3> places;
  for (std::size_t p = 0; p < count; ++p) {
    const CenterlinePath& parent = tree.paths[p];
    const std::vector<Leaving>& leavings = leavings_of[p];
    for (std::size_t a = 0; a < leavings.size(); ++a)
      for (std::size_t b = a + 1; b < leavings.size(); ++b) {
        const auto place = touching_place(leavings[a], leavings[b], parent);
        if (!place) continue;
        const double same = 6.0 * std::max(leavings[a].radius, leavings[b].radius);
        if (std::any_of(places.begin(), places.end(),
                        [&](const Vec3& other) { return distance(other, *place) < same; }))
          continue;
        places.push_back(*place);
      }
  }
  return places;
}

int count_cut_ends(const CenterlineTree& tree) {
  constexpr double kOwn = 4.0;  // radii of a branch's beginning, which lies in its parent
  int count = 0;
  for (const Branch& branch : find_branches(tree)) {
    if (!branch.daughters.empty()) continue;
    const CenterlinePath& path = tree.paths[std::size_t(branch.path)];
    const double length = path.abscissa.back() - path.abscissa[std::size_t(branch.first)];
    if (length < kOwn * path.inscribed_radius[std::size_t(branch.first)]) continue;
    count += std::any_of(tree.paths.begin(), tree.paths.end(), [&](const CenterlinePath& other) {
      const int shared = count_shared(path, other);
      return other.id != path.id &&
             inside_tube(other.points, other.inscribed_radius, std::size_t(std::max(0, shared - 1)),
                         path.points.back());
    });
  }
  return count;
}

}  // namespace angio::centerline
