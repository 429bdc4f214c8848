#include "meshing/detail/lumen_draft.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <numbers>
#include <set>

#include "core/centerline_trees.hpp"
#include "core/error.hpp"
#include "core/surface_rims.hpp"
#include "core/text.hpp"
#include "meshing/detail/fill_hole.hpp"
#include "meshing/detail/soup.hpp"
#include "meshing/repair_surface.hpp"

namespace angio::meshing::detail {
namespace {

std::string place_in_words(const Vec3& place) {
  std::string text = " (";
  for (int a = 0; a < 3; ++a) {
    char number[32];
    std::snprintf(number, sizeof number, "%s%.1f", a > 0 ? ", " : "", place[a]);
    text += number;
  }
  return text + ") mm";
}

std::string describe_rim(const SurfaceRim& rim) {
  char width[48];
  std::snprintf(width, sizeof width, "%.2f mm wide at", rim.diameter_mm);
  return width + place_in_words(rim.centre);
}

/// The line end that an opening belongs to, -1 if there is none; each end is taken once. One that
/// is less than half as wide as the vessel is a hole beside its end, but where the line ends in its
/// middle.
int end_at(const SurfaceRim& rim, const std::vector<LineEnd>& ends,
           const std::vector<char>& taken) {
  const double radius = 0.5 * rim.diameter_mm;
  int nearest = -1;
  for (std::size_t e = 0; e < ends.size(); ++e) {
    const double d = distance(ends[e].tip, rim.centre);
    if (!taken[e] && d < 1.5 * std::max(ends[e].radius, radius) &&
        (nearest < 0 || d < distance(ends[std::size_t(nearest)].tip, rim.centre)))
      nearest = int(e);
  }
  if (nearest < 0) return -1;
  const LineEnd& end = ends[std::size_t(nearest)];
  const bool is_in_middle = distance(end.tip, rim.centre) < 0.5 * radius;
  return is_in_middle || radius > 0.5 * end.radius ? nearest : -1;
}

/// The component that most of a tree's points are nearest to.
int component_around(const CenterlineTree& tree, const TriangleMesh& mesh,
                     const std::vector<int>& component) {
  std::map<int, int> votes;
  constexpr std::size_t kSamples = 16;  // a path
  for (const CenterlinePath& path : tree.paths) {
    const std::size_t stride = std::max<std::size_t>(1, path.points.size() / kSamples);
    for (std::size_t i = 0; i < path.points.size(); i += stride) {
      double best = std::numeric_limits<double>::infinity();
      int owner = 0;
      for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        const double squared = norm_squared(mesh.vertices[v] - path.points[i]);
        if (squared >= best) continue;
        best = squared;
        owner = component[v];
      }
      ++votes[owner];
    }
  }
  return std::max_element(votes.begin(), votes.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

}  // namespace

TriangleMesh components_of_lines(const TriangleMesh& mesh, const CenterlineTree& lines) {
  const std::vector<int> component = vertex_components(mesh);
  if (std::all_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& t) {
        return component[std::size_t(t[0])] == component[std::size_t(mesh.triangles[0][0])];
      }))
    return mesh;
  std::set<int> kept;
  for (const CenterlineTree& tree : separate_trees(lines))
    kept.insert(component_around(tree, mesh, component));
  std::vector<char> keep(mesh.triangles.size());
  for (std::size_t t = 0; t < keep.size(); ++t)
    keep[t] = kept.contains(component[std::size_t(mesh.triangles[t][0])]);
  return part_of(mesh, keep);
}

namespace {

/// Whether the triangles around a rim keep their sides when it is straightened.
bool can_be_straightened(const TriangleMesh& mesh, const SurfaceRim& rim, const Plane& plane) {
  constexpr double kMostUneven = 0.5, kLeastCosine = 0.2;  // of the radius; of a triangle's turn
  if (rim.unevenness_mm >= kMostUneven * 0.5 * rim.diameter_mm) return false;
  const std::set<int> loop(rim.loop.begin(), rim.loop.end());
  const auto straightened = [&](int v) {
    const Vec3& x = mesh.vertices[std::size_t(v)];
    return loop.contains(v) ? x - plane.signed_distance(x) * plane.normal : x;
  };
  return std::all_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& t) {
    if (std::none_of(t.begin(), t.end(), [&](int v) { return loop.contains(v); })) return true;
    const Vec3 a = straightened(t[0]), b = straightened(t[1]), c = straightened(t[2]);
    return dot(normalized(cross(b - a, c - a)), normalized(area_vector_doubled(mesh, t))) >
           kLeastCosine;
  });
}

/// The openings of a surface as rims, where they are flat or `uneven` says so; others are filled.
/// @param uneven  ends whose opening is straightened though it is not flat, as far as it can be
SurfaceDraft draft_of(const TriangleMesh& surface, const std::vector<LineEnd>& ends,
                      const std::vector<int>& uneven, std::vector<std::string>& warnings) {
  SurfaceDraft draft;
  draft.mesh = surface;
  draft.rim.assign(draft.mesh.vertices.size(), -1);
  draft.rim_planes.resize(ends.size());
  std::vector<char> taken(ends.size(), 0);
  std::string closed;
  for (const SurfaceRim& rim : surface_rims(draft.mesh)) {
    constexpr double kFlat = 0.1;  // unevenness / radius of a rim that is straightened
    const int end = end_at(rim, ends, taken);
    if (end < 0) closed += (closed.empty() ? "" : ", ") + describe_rim(rim);
    if (end >= 0) taken[std::size_t(end)] = 1;
    const Plane plane{rim.centre, rim.normal};
    const bool is_wanted = std::find(uneven.begin(), uneven.end(), end) != uneven.end();
    const bool is_flat = rim.unevenness_mm < kFlat * 0.5 * rim.diameter_mm;
    if (end < 0 || !(is_flat || (is_wanted && can_be_straightened(draft.mesh, rim, plane)))) {
      fill_hole(draft.mesh, rim.loop);
      draft.rim.resize(draft.mesh.vertices.size(), -1);
      continue;
    }
    draft.rim_planes[std::size_t(end)] = plane;
    for (const int v : rim.loop) {
      Vec3& x = draft.mesh.vertices[std::size_t(v)];
      x -= plane.signed_distance(x) * plane.normal;
      draft.rim[std::size_t(v)] = end;
    }
  }
  if (!closed.empty())
    warnings.push_back(
        "these openings of the given surface were closed, as no line ends at them: " + closed);
  return draft;
}

}  // namespace

OpenedSurface open_surface(const TriangleMesh& surface, const CenterlineTree& tree,
                           const std::vector<LineEnd>& ends, std::vector<std::string>& warnings) {
  RepairedSurface repaired = repair_surface(surface, {.keep_all_pieces = true});
  for (const SurfaceRepair& repair : repaired.repairs)
    if (!repair.is_routine)
      warnings.push_back("the given surface was repaired: " + to_text(repair));
  const TriangleMesh mesh = components_of_lines(repaired.mesh, tree);
  OpenedSurface opened;
  std::vector<std::string> told;
  const auto open = [&](const std::vector<int>& uneven) {
    told.clear();
    opened.draft = draft_of(mesh, ends, uneven, told);
    opened.repaired = opened.draft.mesh;
    return open_ends(opened.draft, tree, ends, told);
  };
  const std::vector<int> closed = open({});
  if (!closed.empty()) open(closed);
  warnings.insert(warnings.end(), told.begin(), told.end());
  return opened;
}

namespace {

/// Planes to try at a line's end, the most natural first: across the line at its full width, then
/// nearer to the tip and further inside, then turned, for where a neighbour touches.
std::vector<Plane> planes_to_try(const CenterlineTree& tree, const LineEnd& end) {
  const double inset = full_width_inset(tree, end);
  std::vector<Plane> planes;
  for (const double factor : {1.0, 1.4, 0.7, 2.0, 0.4, 3.0, 4.0, 0.1, 6.0, 8.0})
    planes.push_back(plane_near_end(tree, end, factor * inset));
  const std::vector<Plane> across = planes;
  constexpr int kTurns = 8;
  for (const double tilt : {0.4, 0.8})  // [rad]
    for (const Plane& straight : across) {
      const Vec3 u = any_perpendicular(straight.normal);
      const Vec3 v = cross(straight.normal, u);
      for (int turn = 0; turn < kTurns; ++turn) {
        const double angle = 2.0 * std::numbers::pi * turn / kTurns;
        const Vec3 sideways = std::cos(angle) * u + std::sin(angle) * v;
        planes.push_back(
            {straight.origin, std::cos(tilt) * straight.normal + std::sin(tilt) * sideways});
      }
    }
  return planes;
}

}  // namespace

std::vector<int> open_ends(SurfaceDraft& draft, const CenterlineTree& tree,
                           const std::vector<LineEnd>& ends, std::vector<std::string>& warnings) {
  draft.rim_planes.resize(ends.size());
  std::vector<Vec3> tips;
  for (const LineEnd& end : ends) tips.push_back(end.tip);
  const TriangleMesh whole = std::move(draft.mesh);
  EndOpener opener(whole, tips);
  std::vector<std::string> joined, closed;
  std::vector<int> stay_closed;
  for (std::size_t e = 0; e < ends.size(); ++e) {
    if (std::find(draft.rim.begin(), draft.rim.end(), int(e)) != draft.rim.end()) continue;
    EndOpener::Cut cut = opener.best_cut(planes_to_try(tree, ends[e]), ends[e].radius, int(e));
    if (cut.verdict == EndOpener::Verdict::sound) {
      draft.rim_planes[e] = cut.plane;
      opener.plan(std::move(cut));
    } else {
      stay_closed.push_back(int(e));
      const bool goes_on = cut.verdict == EndOpener::Verdict::no_end;
      (goes_on ? joined : closed).push_back(name_of_end(int(e)) + place_in_words(ends[e].tip));
    }
  }
  if (!ends.empty() && joined.size() == ends.size())
    throw InputError(
        "the lumen has no end: wherever a line ends it goes on, into another vessel or into itself "
        "(vessels that touch, or a ring). Give one with an inlet and an outlet, or cut it open");
  opener.apply(draft.mesh, draft.rim);
  if (!joined.empty())
    warnings.push_back(
        "these ends of lines are no ends of the lumen, which goes on beyond them and joins another "
        "vessel (a loop, or vessels that touch); they stay closed: " +
        list_a_few(joined, "ends"));
  if (!closed.empty())
    warnings.push_back(
        "these ends of lines stay closed, because no section across the line there is that of one "
        "vessel: " +
        list_a_few(closed, "ends"));
  return stay_closed;
}

}  // namespace angio::meshing::detail
