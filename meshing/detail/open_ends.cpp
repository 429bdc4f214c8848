#include "meshing/detail/open_ends.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "core/centerline_trees.hpp"
#include "core/error.hpp"
#include "meshing/detail/edge_table.hpp"

namespace angio::meshing::detail {
namespace {

/// Abscissa at a distance inside an end.
double abscissa_inside(const CenterlinePath& path, const LineEnd& end, double inset) {
  const double first = path.abscissa.front();
  const double last = path.abscissa.back();
  return std::clamp(end.at_inlet ? first + inset : last - inset, first, last);
}

/// How often a loop in a plane turns around the plane's origin (0: the origin lies outside).
int winding_number(const std::vector<Vec3>& points, const Plane& plane) {
  double angle = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 a = points[i] - plane.origin;
    const Vec3 b = points[(i + 1) % points.size()] - plane.origin;
    angle += std::atan2(dot(cross(a, b), plane.normal), dot(a, b));
  }
  return int(std::lround(angle / (2.0 * std::numbers::pi)));
}

constexpr double kSectionReach = 4.0;  // radii; a wider section is not that of this vessel

/// 4 pi area / perimeter^2 of a plane loop.
double roundness(const std::vector<Vec3>& points) {
  Vec3 area_doubled;
  double perimeter = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3& next = points[(i + 1) % points.size()];
    area_doubled += cross(points[i] - points[0], next - points[0]);
    perimeter += distance(points[i], next);
  }
  return 2.0 * std::numbers::pi * norm(area_doubled) / (perimeter * perimeter);
}

int nearest_vertex(const TriangleMesh& mesh, const Vec3& point) {
  int best = 0;
  double best_squared = std::numeric_limits<double>::infinity();
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const double squared = norm_squared(mesh.vertices[v] - point);
    if (squared >= best_squared) continue;
    best_squared = squared;
    best = int(v);
  }
  return best;
}

}  // namespace

std::vector<LineEnd> line_ends(const CenterlineTree& tree) {
  std::vector<LineEnd> ends, other_inlets;
  const std::vector<int> tree_of = tree_of_paths(tree);
  for (std::size_t p = 0; p < tree.paths.size(); ++p) {
    const CenterlinePath& path = tree.paths[p];
    if (path.points.size() < 2)
      throw InputError(
          "a line of the centreline has less than two points (it has no direction to "
          "cut across). Run the stage centerline again");
    const bool is_first = std::find(tree_of.begin(), tree_of.begin() + std::ptrdiff_t(p),
                                    tree_of[p]) == tree_of.begin() + std::ptrdiff_t(p);
    if (is_first)
      (p == 0 ? ends : other_inlets).push_back({path.points.front(), 0.0, int(p), true});
    ends.push_back({path.points.back(), 0.0, int(p), false});
  }
  ends.insert(ends.end(), other_inlets.begin(), other_inlets.end());
  for (LineEnd& end : ends) {
    // Towards a blind tip the inscribed sphere shrinks; walk inwards until it stops growing.
    const CenterlinePath& path = tree.paths[std::size_t(end.path)];
    const double shortest = 1e-3 * (path.abscissa.back() - path.abscissa.front());
    double radius =
        std::max(sample(path, abscissa_inside(path, end, 0.0)).inscribed_radius, shortest);
    for (int step = 0; step < 30; ++step) {
      double widest = radius;
      for (int part = 1; part <= 8; ++part)
        widest = std::max(
            widest,
            sample(path, abscissa_inside(path, end, 2.0 * radius * part / 8)).inscribed_radius);
      if (widest < 1.2 * radius) break;
      radius = widest;
    }
    end.radius = radius;
  }
  return ends;
}

std::string name_of_end(int end) {
  return end == 0 ? "the inlet" : "outlet " + std::to_string(end);
}

Plane plane_near_end(const CenterlineTree& tree, const LineEnd& end, double inset) {
  const CenterlinePath& path = tree.paths[std::size_t(end.path)];
  const double reach = 0.5 * end.radius;
  const Vec3 outer = sample(path, abscissa_inside(path, end, inset - reach)).point;
  const Vec3 inner = sample(path, abscissa_inside(path, end, inset + reach)).point;
  return {sample(path, abscissa_inside(path, end, inset)).point, normalized(outer - inner)};
}

double full_width_inset(const CenterlineTree& tree, const LineEnd& end) {
  const CenterlinePath& path = tree.paths[std::size_t(end.path)];
  for (double part = 0.25; part < 3.0; part += 0.05) {
    const double radius =
        sample(path, abscissa_inside(path, end, part * end.radius)).inscribed_radius;
    if (radius >= 0.75 * end.radius) return part * end.radius;
  }
  return end.radius;
}

EndOpener::EndOpener(const TriangleMesh& mesh, const std::vector<Vec3>& tips)
    : mesh_(mesh),
      blocks_(mesh),
      first_triangle_(mesh.vertices.size() + 1, 0),
      cut_of_(mesh.triangles.size(), -1),
      gone_(mesh.vertices.size(), 0),
      is_tip_(mesh.vertices.size(), 0),
      vertex_mark_(mesh.vertices.size(), 0),
      triangle_mark_(mesh.triangles.size(), 0) {
  for (const Triangle& t : mesh.triangles)
    for (const int v : t) ++first_triangle_[std::size_t(v) + 1];
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    first_triangle_[v + 1] += first_triangle_[v];
  triangles_around_.resize(3 * mesh.triangles.size());
  std::vector<int> next(first_triangle_.begin(), first_triangle_.end() - 1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const int v : mesh.triangles[t])
      triangles_around_[std::size_t(next[std::size_t(v)]++)] = int(t);
  for (const Vec3& tip : tips) {
    tip_vertex_.push_back(nearest_vertex(mesh, tip));
    is_tip_[std::size_t(tip_vertex_.back())] = 1;
  }
}

double EndOpener::side(const Plane& plane, int v) const {
  const double d = plane.signed_distance(mesh_.vertices[std::size_t(v)]);
  return std::abs(d) < 1e-9 ? 1e-9 : d;  // no vertex lies on the plane
}

Vec3 EndOpener::crossing(const Plane& plane, int a, int b) const {
  if (a > b) std::swap(a, b);  // both triangles of an edge get the same bits
  const double da = side(plane, a);
  const double db = side(plane, b);
  return mesh_.vertices[std::size_t(a)] +
         (da / (da - db)) * (mesh_.vertices[std::size_t(b)] - mesh_.vertices[std::size_t(a)]);
}

std::vector<EndOpener::Loop> EndOpener::sections(const Plane& plane, const Ball& ball,
                                                 const Ball& corners) const {
  struct Crossed {
    int triangle;
    EdgeKey leaving;   ///< the edge that leads to the far side
    EdgeKey entering;  ///< the one that leads back
  };
  std::vector<Crossed> crossed;
  const auto is_near = [&](int v) {
    return norm_squared(mesh_.vertices[std::size_t(v)] - corners.middle) <=
           corners.radius * corners.radius;
  };
  for (const int t : blocks_.near_cut(plane, ball)) {
    const Triangle& triangle = mesh_.triangles[std::size_t(t)];
    std::array<bool, 3> is_far{};
    for (std::size_t c = 0; c < 3; ++c) is_far[c] = side(plane, triangle[c]) > 0.0;
    if (is_far[0] == is_far[1] && is_far[1] == is_far[2]) continue;
    if (std::none_of(triangle.begin(), triangle.end(), is_near)) continue;
    Crossed& added = crossed.emplace_back(Crossed{t, {}, {}});
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t next = (c + 1) % 3;
      if (is_far[c] == is_far[next]) continue;
      (is_far[next] ? added.leaving : added.entering) = edge_key(triangle[c], triangle[next]);
    }
  }
  std::sort(crossed.begin(), crossed.end(),
            [](const Crossed& x, const Crossed& y) { return x.triangle < y.triangle; });
  std::vector<std::pair<EdgeKey, int>> leaving;  // edge, place in `crossed`
  for (std::size_t i = 0; i < crossed.size(); ++i) leaving.emplace_back(crossed[i].leaving, int(i));
  std::sort(leaving.begin(), leaving.end());
  const auto next_place = [&](const Crossed& from) {  // -1: a border
    const std::pair<EdgeKey, int> wanted{from.entering, -1};
    const auto found = std::lower_bound(leaving.begin(), leaving.end(), wanted);
    return found == leaving.end() || found->first != wanted.first ? -1 : found->second;
  };
  std::vector<Loop> loops;
  std::vector<char> is_taken(crossed.size(), 0);
  for (std::size_t first = 0; first < crossed.size(); ++first) {
    if (is_taken[first] != 0) continue;
    Loop loop;
    int place = int(first);
    while (place >= 0 && std::exchange(is_taken[std::size_t(place)], char(1)) == 0) {
      const Crossed& here = crossed[std::size_t(place)];
      loop.triangles.push_back(here.triangle);
      loop.points.push_back(crossing(plane, here.leaving[0], here.leaving[1]));
      place = next_place(here);
    }
    if (place == int(first)) loops.push_back(std::move(loop));  // else it ends at a border
  }
  return loops;
}

std::vector<int> EndOpener::part_beyond(const Plane& plane, const Loop& loop, double reach,
                                        int end) {
  constexpr char kFar = 1, kNear = 2;
  std::vector<int> part, near;
  const auto visit = [&](int v) {
    char& mark = vertex_mark_[std::size_t(v)];
    if ((mark & kFar) == 0) part.push_back(v);
    mark = char(mark | kFar);
  };
  const auto is_other_tip = [&](int v) {
    for (std::size_t tip = 0; tip < tip_vertex_.size(); ++tip)
      if (int(tip) != end && tip_vertex_[tip] == v) return true;
    return false;
  };
  const auto separates = [&] {
    for (const int t : loop.triangles) {
      if (cut_of_[std::size_t(t)] >= 0) return false;
      triangle_mark_[std::size_t(t)] = 1;
      for (const int v : mesh_.triangles[std::size_t(t)]) {
        if (side(plane, v) > 0.0) {
          visit(v);
        } else {
          near.push_back(v);
          vertex_mark_[std::size_t(v)] = kNear;
        }
      }
    }
    for (std::size_t i = 0; i < part.size(); ++i) {
      const int v = part[i];
      // Leading back to the near side, into another cut, or far away, it separates no end.
      if ((vertex_mark_[std::size_t(v)] & kNear) != 0 || gone_[std::size_t(v)] ||
          distance(mesh_.vertices[std::size_t(v)], plane.origin) > reach ||
          (is_tip_[std::size_t(v)] && is_other_tip(v)))
        return false;
      for (int k = first_triangle_[std::size_t(v)]; k < first_triangle_[std::size_t(v) + 1]; ++k) {
        const int t = triangles_around_[std::size_t(k)];
        if (cut_of_[std::size_t(t)] >= 0) return false;
        if (triangle_mark_[std::size_t(t)] != 0) continue;
        for (const int u : mesh_.triangles[std::size_t(t)]) visit(u);
      }
    }
    return true;
  };
  const bool is_part = separates();
  for (const auto* marked : {&part, &near})
    for (const int v : *marked) vertex_mark_[std::size_t(v)] = 0;
  for (const int t : loop.triangles) triangle_mark_[std::size_t(t)] = 0;
  return is_part ? part : std::vector<int>();
}

EndOpener::Cut EndOpener::best_cut(const std::vector<Plane>& planes, double radius, int end) {
  constexpr double kRound = 0.7;   // an ellipse of 1 : 2.6
  constexpr double kLeast = 0.25;  // less is a slit, whose cap would cross the wall
  const Vec3 middle = planes.front().origin;
  double reach = 0.0;
  for (const Plane& plane : planes) reach = std::max(reach, distance(plane.origin, middle));
  reach += (kSectionReach + 1.0) * radius;
  constexpr int kConvinced = 4;  // round sections that end nothing, until the search ends
  int endless_count = 0;
  Cut best;
  for (const Plane& plane : planes) {
    Cut cut = examine(plane, radius, end, {middle, reach});
    if (cut.verdict == Verdict::no_end && best.verdict != Verdict::sound) {
      best.verdict = Verdict::no_end;
      if (cut.roundness > kRound && ++endless_count == kConvinced) break;
    }
    if (cut.verdict != Verdict::sound || cut.roundness <= std::max(kLeast, best.roundness))
      continue;
    best = std::move(cut);
    if (best.roundness > kRound) break;
  }
  return best;
}

double EndOpener::upright_share(const Plane& plane, const std::vector<int>& triangles) const {
  constexpr double kLeaning = -0.6;  // cosine: less than 53 degrees between wall and cap
  std::size_t upright_count = 0;
  for (const int t : triangles)
    upright_count += dot(normalized(area_vector_doubled(mesh_, mesh_.triangles[std::size_t(t)])),
                         plane.normal) > kLeaning;
  return double(upright_count) / double(triangles.size());
}

EndOpener::Cut EndOpener::examine(const Plane& plane, double radius, int end, const Ball& corners) {
  constexpr double kBeyond = 16.0;  // radii; an end is not longer than this
  Cut cut{plane, end, Verdict::no_section, 0.0, {}, {}};
  for (Loop& loop : sections(plane, {plane.origin, kSectionReach * radius}, corners)) {
    if (winding_number(loop.points, plane) == 0) continue;
    double reach = 0.0;
    for (const Vec3& p : loop.points) reach = std::max(reach, distance(p, plane.origin));
    if (reach > kSectionReach * radius) continue;
    cut.verdict = Verdict::no_end;
    cut.roundness = std::max(cut.roundness, roundness(loop.points));
    std::vector<int> part = part_beyond(plane, loop, kBeyond * radius, end);
    if (part.empty()) continue;
    cut.verdict = Verdict::sound;
    cut.roundness = roundness(loop.points) * upright_share(plane, loop.triangles);
    cut.triangles = std::move(loop.triangles);
    cut.beyond = std::move(part);
    return cut;
  }
  return cut;
}

void EndOpener::plan(Cut cut) {
  for (const int v : cut.beyond) gone_[std::size_t(v)] = 1;
  for (const int t : cut.triangles) cut_of_[std::size_t(t)] = int(cuts_.size());
  cuts_.push_back(std::move(cut));
}

void EndOpener::apply(TriangleMesh& mesh, std::vector<int>& rim) const {
  TriangleMesh result;
  std::vector<int> result_rim;
  std::vector<int> index(mesh_.vertices.size(), -1);
  std::map<EdgeKey, int> cut_index;
  const auto old_vertex = [&](int v) {
    int& at = index[std::size_t(v)];
    if (at < 0) {
      at = int(result.vertices.size());
      result.vertices.push_back(mesh_.vertices[std::size_t(v)]);
      result_rim.push_back(rim[std::size_t(v)]);
    }
    return at;
  };
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
    const Triangle& corners = mesh_.triangles[t];
    if (cut_of_[t] < 0) {
      if (gone_[std::size_t(corners[0])]) continue;
      result.triangles.push_back(
          {old_vertex(corners[0]), old_vertex(corners[1]), old_vertex(corners[2])});
      continue;
    }
    const Cut& cut = cuts_[std::size_t(cut_of_[t])];
    std::vector<int> polygon;  // the near piece of a crossed triangle
    for (std::size_t c = 0; c < 3; ++c) {
      const int a = corners[c];
      const int b = corners[(c + 1) % 3];
      const bool far_a = side(cut.plane, a) > 0.0;
      if (!far_a) polygon.push_back(old_vertex(a));
      if (far_a == (side(cut.plane, b) > 0.0)) continue;
      const auto [at, is_new] = cut_index.try_emplace(edge_key(a, b), int(result.vertices.size()));
      if (is_new) {
        result.vertices.push_back(crossing(cut.plane, a, b));
        result_rim.push_back(cut.end);
      }
      polygon.push_back(at->second);
    }
    for (std::size_t c = 1; c + 1 < polygon.size(); ++c)
      result.triangles.push_back({polygon[0], polygon[c], polygon[c + 1]});
  }
  mesh = std::move(result);
  rim = std::move(result_rim);
}

}  // namespace angio::meshing::detail
