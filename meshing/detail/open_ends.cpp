#include "meshing/detail/open_ends.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "core/error.hpp"
#include "meshing/detail/surface_query.hpp"

namespace angio::meshing::detail {
namespace {

/// Abscissa at a distance inside an end.
double abscissa_inside(const CenterlinePath& path, const LineEnd& end, double inset) {
  const double first = path.abscissa.front();
  const double last = path.abscissa.back();
  return std::clamp(end.at_inlet ? first + inset : last - inset, first, last);
}

/// The crossing of a mesh's edges with a plane, as chains of crossed triangles.
class PlaneSection {
 public:
  PlaneSection(const TriangleMesh& mesh, const Plane& plane) : mesh_(mesh) {
    side_.reserve(mesh.vertices.size());
    for (const Vec3& p : mesh.vertices) {
      const double d = plane.signed_distance(p);
      side_.push_back(std::abs(d) < 1e-9 ? 1e-9 : d);  // no vertex lies on the plane
    }
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (std::size_t c = 0; c < 3; ++c) {
        const int a = mesh.triangles[t][c];
        const int b = mesh.triangles[t][(c + 1) % 3];
        if (beyond(a) || !beyond(b)) continue;
        // Each crossed triangle has one edge that leaves and one that enters.
        leaving_[{std::min(a, b), std::max(a, b)}] = int(t);
      }
  }

  [[nodiscard]] bool beyond(int v) const { return side_[std::size_t(v)] > 0.0; }
  [[nodiscard]] Vec3 crossing(int a, int b) const {
    if (a > b) std::swap(a, b);
    const double da = side_[std::size_t(a)];
    const double db = side_[std::size_t(b)];
    return mesh_.vertices[std::size_t(a)] +
           (da / (da - db)) * (mesh_.vertices[std::size_t(b)] - mesh_.vertices[std::size_t(a)]);
  }

  struct Loop {
    std::vector<int> triangles;
    std::vector<Vec3> points;
  };
  /// The closed sections; chains that end at a border are left out.
  [[nodiscard]] std::vector<Loop> loops() const {
    std::map<int, std::array<int, 2>> edge_of;  // leaving edge of each crossed triangle
    for (const auto& [edge, t] : leaving_) edge_of[t] = edge;
    std::vector<Loop> loops;
    while (!edge_of.empty()) {
      Loop loop;
      const int first = edge_of.begin()->first;
      int t = first;
      bool closed = false;
      for (auto at = edge_of.find(t); at != edge_of.end(); at = edge_of.find(t)) {
        loop.triangles.push_back(t);
        loop.points.push_back(crossing(at->second[0], at->second[1]));
        edge_of.erase(at);
        t = triangle_across_entering_edge(t);
        if (t == first) closed = true;
      }
      if (closed) loops.push_back(std::move(loop));
    }
    return loops;
  }

 private:
  /// The neighbour that leaves through the edge by which triangle t enters.
  [[nodiscard]] int triangle_across_entering_edge(int t) const {
    const Triangle& corners = mesh_.triangles[std::size_t(t)];
    for (std::size_t c = 0; c < 3; ++c) {
      const int a = corners[c];
      const int b = corners[(c + 1) % 3];
      if (!beyond(a) || beyond(b)) continue;
      const auto found = leaving_.find({std::min(a, b), std::max(a, b)});
      return found == leaving_.end() ? -1 : found->second;
    }
    return -1;
  }

  const TriangleMesh& mesh_;
  std::vector<double> side_;
  std::map<std::array<int, 2>, int> leaving_;
};

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

/// Vertices beyond the plane that hang on the loop's far side.
std::vector<char> cut_off_part(const TriangleMesh& mesh, const PlaneSection& section,
                               const PlaneSection::Loop& loop) {
  std::vector<char> crossed(mesh.triangles.size(), 0);
  for (const int t : loop.triangles) crossed[std::size_t(t)] = 1;
  std::vector<std::vector<int>> triangles_of(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (!crossed[t])
      for (const int v : mesh.triangles[t]) triangles_of[std::size_t(v)].push_back(int(t));
  std::vector<char> gone(mesh.vertices.size(), 0);
  std::vector<int> stack;
  const auto visit = [&](int v) {
    if (gone[std::size_t(v)]) return;
    gone[std::size_t(v)] = 1;
    stack.push_back(v);
  };
  for (const int t : loop.triangles)
    for (const int v : mesh.triangles[std::size_t(t)])
      if (section.beyond(v)) visit(v);
  while (!stack.empty()) {
    const int v = stack.back();
    stack.pop_back();
    for (const int t : triangles_of[std::size_t(v)])
      for (const int u : mesh.triangles[std::size_t(t)]) visit(u);
  }
  return gone;
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

/// Rebuilds the mesh without the part that is gone; crossed triangles keep their near piece.
void rebuild(TriangleMesh& mesh, std::vector<int>& rim, const PlaneSection& section,
             const PlaneSection::Loop& loop, const std::vector<char>& gone, int rim_index) {
  std::vector<char> crossed(mesh.triangles.size(), 0);
  for (const int t : loop.triangles) crossed[std::size_t(t)] = 1;
  TriangleMesh result;
  std::vector<int> result_rim;
  std::vector<int> index(mesh.vertices.size(), -1);
  std::map<std::array<int, 2>, int> cut_index;
  const auto old_vertex = [&](int v) {
    int& at = index[std::size_t(v)];
    if (at < 0) {
      at = int(result.vertices.size());
      result.vertices.push_back(mesh.vertices[std::size_t(v)]);
      result_rim.push_back(rim[std::size_t(v)]);
    }
    return at;
  };
  const auto cut_vertex = [&](int a, int b) {
    const auto [at, is_new] =
        cut_index.try_emplace({std::min(a, b), std::max(a, b)}, int(result.vertices.size()));
    if (is_new) {
      result.vertices.push_back(section.crossing(a, b));
      result_rim.push_back(rim_index);
    }
    return at->second;
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& corners = mesh.triangles[t];
    if (!crossed[t]) {
      if (gone[std::size_t(corners[0])]) continue;
      result.triangles.push_back(
          {old_vertex(corners[0]), old_vertex(corners[1]), old_vertex(corners[2])});
      continue;
    }
    std::vector<int> polygon;
    for (std::size_t c = 0; c < 3; ++c) {
      const int a = corners[c];
      const int b = corners[(c + 1) % 3];
      if (!section.beyond(a)) polygon.push_back(old_vertex(a));
      if (section.beyond(a) != section.beyond(b)) polygon.push_back(cut_vertex(a, b));
    }
    for (std::size_t c = 1; c + 1 < polygon.size(); ++c)
      result.triangles.push_back({polygon[0], polygon[c], polygon[c + 1]});
  }
  mesh = std::move(result);
  rim = std::move(result_rim);
}

}  // namespace

std::vector<LineEnd> line_ends(const CenterlineTree& tree) {
  std::vector<LineEnd> ends;
  for (std::size_t p = 0; p < tree.paths.size(); ++p) {
    const CenterlinePath& path = tree.paths[p];
    if (path.points.size() < 2)
      throw InputError(
          "a line of the centreline has less than two points (it has no direction to "
          "cut across). Run the stage centerline again");
    if (p == 0) ends.push_back({path.points.front(), 0.0, 0, true});
    ends.push_back({path.points.back(), 0.0, int(p), false});
  }
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

bool open_end(TriangleMesh& mesh, std::vector<int>& rim, const Plane& plane, double radius,
              int rim_index, const std::vector<Vec3>& keep) {
  const PlaneSection section(mesh, plane);
  for (const PlaneSection::Loop& loop : section.loops()) {
    if (winding_number(loop.points, plane) == 0) continue;
    double reach = 0.0;
    for (const Vec3& p : loop.points) reach = std::max(reach, distance(p, plane.origin));
    if (reach > 4.0 * radius) continue;
    const std::vector<char> gone = cut_off_part(mesh, section, loop);
    bool sound = true;
    for (const int t : loop.triangles)  // the far side must not lead back to the near side
      for (const int v : mesh.triangles[std::size_t(t)])
        sound &= section.beyond(v) || !gone[std::size_t(v)];
    for (const Vec3& p : keep) sound &= !gone[std::size_t(nearest_vertex(mesh, p))];
    if (!sound) continue;
    rebuild(mesh, rim, section, loop, gone, rim_index);
    return true;
  }
  return false;
}

CappedMesh cap_rims(const TriangleMesh& open, const std::vector<int>& rim) {
  CappedMesh capped{open, std::vector<int>(open.vertices.size(), 0)};
  for (std::size_t v = 0; v < rim.size(); ++v) capped.id[v] = rim[v] + 1;
  for (const std::vector<int>& loop : boundary_loops(open)) {
    std::vector<Vec3> points;
    Vec3 centre;
    for (const int v : loop) {
      points.push_back(open.vertices[std::size_t(v)]);
      centre += points.back();
    }
    centre = centre / double(points.size());
    Vec3 area;
    for (std::size_t i = 0; i < points.size(); ++i)
      area += cross(points[i] - centre, points[(i + 1) % points.size()] - centre);
    bool star_shaped = true;
    for (std::size_t i = 0; i < points.size(); ++i)
      star_shaped &=
          dot(cross(points[i] - centre, points[(i + 1) % points.size()] - centre), area) > 0.0;
    std::vector<Triangle> patch;
    int split = -1;
    if (!star_shaped) {
      patch = triangulate_loop(points);
      if (patch.empty()) throw InternalError("a rim of the lumen could not be capped");
      // The centre goes into the largest triangle, so that each cap has a vertex of its own.
      double largest = 0.0;
      for (std::size_t t = 0; t < patch.size(); ++t) {
        const Vec3& a = points[std::size_t(patch[t][0])];
        const Vec3 n =
            cross(points[std::size_t(patch[t][1])] - a, points[std::size_t(patch[t][2])] - a);
        if (norm(n) <= largest) continue;
        largest = norm(n);
        split = int(t);
      }
    }
    const int centre_index = int(capped.mesh.vertices.size());
    const auto fan = [&](int a, int b) { capped.mesh.triangles.push_back({a, b, centre_index}); };
    if (star_shaped) {
      for (std::size_t i = 0; i < loop.size(); ++i) fan(loop[i], loop[(i + 1) % loop.size()]);
    }
    for (std::size_t t = 0; t < patch.size(); ++t) {
      const int a = loop[std::size_t(patch[t][0])];
      const int b = loop[std::size_t(patch[t][1])];
      const int c = loop[std::size_t(patch[t][2])];
      if (int(t) == split) {
        fan(a, b);
        fan(b, c);
        fan(c, a);
        centre = (open.vertices[std::size_t(a)] + open.vertices[std::size_t(b)] +
                  open.vertices[std::size_t(c)]) /
                 3.0;
      } else {
        capped.mesh.triangles.push_back({a, b, c});
      }
    }
    capped.mesh.vertices.push_back(centre);
    capped.id.push_back(rim[std::size_t(loop.front())] + 1);
  }
  return capped;
}

}  // namespace angio::meshing::detail
